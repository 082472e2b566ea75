"""From outside: laws of contact and friction, a mechanism, a kind of study, a figure, a verb, a function."""

from __future__ import annotations

from typing import Any, Unpack

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import jointplay as jp
from jointplay.analysis.declared import Outputs, values_of
from jointplay.analysis.evaluate import OUTCOME
from jointplay.analysis.keywords import Motion, Moving, Share, analysis
from jointplay.analysis.labels import Out
from jointplay.analysis.poincare import poincare
from jointplay.cli.verb import Verb, option, say
from jointplay.figures.registry import picture
from jointplay.kinds import Kind
from jointplay.solver.equations.friction import FrictionLaw
from jointplay.solver.equations.laws import Law
from jointplay.solver.equations.quantity import Quantity
from jointplay.solver.mechanism.base import Natural
from jointplay.solver.mechanism.signature import preset

MEADOW = Law(
    force=lambda m, u, v_n, K, C: (K * u + C * v_n, K * u**2 / 2),
    slopes=lambda depth, K, C: (K, C),
    numbers={"stiffness": Quantity("K", "N/m"), "damping": Quantity("C", "N s/m", least=0.0)},
    formula="K u + C v",
    references=("A. Stranger, Soft ground, 2026",),
)
VELVET = FrictionLaw(
    lambda m, v_t, f, c: f * m.tanh(v_t / c),
    numbers={"nap": Quantity("c", "m/s", usual=0.1)},
    formula="f tanh(v_t/c)",
    references=(),
)


@preset()
def seesaw(clearance: float = 1e-4, **changes: Any) -> jp.Mechanism:
    """Give a four-bar whose joints have the law `meadow` and the friction `velvet`.

    Parameters
    ----------
    clearance : float
        Radial clearance of joint B, m.
    **changes
        As in `Mechanism.replace`.
    """
    plain = jp.catalog.chunmei2002(gear_ratio=3.0, clearance=clearance)
    laws = {"contact": jp.Contact(law="meadow", stiffness=1e7, damping=200.0)}
    laws |= {"friction": jp.Friction(law="velvet", coefficient=0.1)}
    joints = [joint.model_copy(update=laws) for joint in plain.joints]
    return jp.Mechanism(**dict(plain) | {"name": "seesaw", "joints": joints}).replace(**changes)


OUTPUTS = Outputs("echoes", {}, {"echo_share": Out((), "share of section points near the first")} | OUTCOME)


@analysis("model", outputs=OUTPUTS)
def echoes(
    mechanism: Moving, *, turns: Natural = 10, near: Share = 0.1, **motion: Unpack[Motion]
) -> xr.Dataset:
    """Give the share of section points that are near the first one.

    Parameters
    ----------
    mechanism : Mechanism or TestSystem
        What moves.
    turns : int
        Section points.
    near : float
        Distance up to which a point counts as near.
    """
    cut = poincare(mechanism, turns=turns, **motion)
    points = cut["angle" if "angle" in cut else "state_value"].values
    share = np.mean(np.linalg.norm(points - points[:1], axis=1) < near)
    return OUTPUTS.dataset({"echo_share": share} | values_of(cut, OUTCOME))


ECHOES = Kind("echoes", "jointplay_example:echoes", ("portrait",), "{turns} turns", references=())


@picture(needs=("echo_share",))
def portrait(dataset: xr.Dataset, *, colour: str = "black") -> Figure:
    """Draw the share as a bar.

    Parameters
    ----------
    dataset : Dataset
        What the analysis `echoes` gave.
    colour : str
        Of the bar.
    """
    figure = Figure()
    figure.subplots().bar(["echoes"], [float(dataset["echo_share"])], color=colour)
    return figure


def _greet(arguments: Any) -> int:
    """Greet somebody."""
    say(f"hello {arguments.name}")
    return 0


GREET = Verb("greet", _greet, (option("name"),), "you")


def echo(word: str) -> str:
    """Give a word back."""
    return word
