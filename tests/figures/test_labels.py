"""Labels are words: no figure of a result over key paths has a key path drawn on it."""

import re

import pytest
from matplotlib.text import Text

import jointplay as jp
from jointplay import figures
from tests.support.sweep_samples import loaded, ran

DOTTED = re.compile(r"[A-Za-z_]\.[A-Za-z_]|[a-z]:[A-Za-z_]|[a-z]_[a-z]")  # a.b, largest:force:B, normal_force
STIFFNESS, MASS = "joints.B.contact.stiffness", "links.coupler.mass"
COUNTERWEIGHT = "links.coupler.masses.counterweight.mass"
START = {"transient": 40, "rtol": 1e-6}


def four_bar():
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-5, gear_ratio=15.0)
    mass = jp.PointMass(name="counterweight", at=-0.05, mass=0.01)
    return mechanism.varied({"links.coupler.masses": (mass,)})


def diagram(*paths):
    over = {path: [value, 1.02 * value] for path, value in zip(paths, (7.15e6, 0.174), strict=False)}
    return jp.bifurcation(four_bar(), over=over, direction="reset", turns=4, transient=4, rtol=1e-5)


SWEEP = f"""\
kind = "lyapunov"
name = "swept"
[mechanism]
catalog = "chunmei2002"
clearance = 2.9e-5
gear_ratio = 15.0
[vary]
"{STIFFNESS}" = [7e6, 8e6]
[analysis]
turns = 4
"""


def region(half):
    return {f"eccentricity_ratio_{axis}": (-half, half) for axis in "xy"}


RESULTS = {
    "bifurcation": lambda _: diagram(STIFFNESS),
    "parameter_map": lambda _: diagram(STIFFNESS, MASS),
    "sweep": lambda folder: ran(loaded(SWEEP), folder),
    "gradient": lambda _: jp.gradient(
        four_bar(), by=[STIFFNESS, COUNTERWEIGHT, "drive.rated_torque"], turns=1, rtol=1e-6
    ),
    "optimise": lambda _: jp.optimise(
        four_bar(),
        by={COUNTERWEIGHT: (0.001, 0.05), MASS: (0.17, 0.18)},
        least="largest:normal_force:B",
        orbit=False,
        max_iterations=2,
        rtol=1e-6,
    ),
    "continuation": lambda _: jp.continuation(
        four_bar(), parameter=STIFFNESS, range=(7.1e6, 7.2e6), max_points=3, step=0.5, **START
    ),
    "curve": lambda _: jp.curve(
        four_bar(), plane={STIFFNESS: (7.1e6, 7.2e6), MASS: (0.17, 0.18)}, max_points=2, step=0.5, **START
    ),
    "attractors": lambda _: jp.attractors(
        four_bar(), over={STIFFNESS: [7.1e6, 7.2e6]}, region=region(0.5), starts=4, turns=4, lyapunov_turns=2
    ),
}


@pytest.mark.nightly
@pytest.mark.parametrize("kind", RESULTS)
def test_no_drawn_text_is_a_key(kind, tmp_path):
    figure = figures.draw(RESULTS[kind](tmp_path), {"kind": kind})
    figure.draw_without_rendering()
    drawn = [text.get_text() for text in figure.findobj(Text) if text.get_visible()]
    assert len("".join(drawn)) > 20
    assert [text for text in drawn if DOTTED.search(text)] == []
