"""The solver itself in pages of browsers: the motion that it gives is the program's own."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

import jointplay as jp
from jointplay_page import live
from tests.pages.browsing import complaints, opened, text, until
from tests.pages.test_live_in_browser import MOTIONS, SAID, SETTLED, exponent

pytestmark = [pytest.mark.nightly, pytest.mark.timeout(600)]
TURNS = 2
TWO_TURNS = f"""
const {{ text, solver }} = jointplay.data.live;
const make = new Function(text.slice(0, text.lastIndexOf('"use strict"')) + '; return makeSolver');
const run = make()(solver);
const found = run.run({TURNS}, {{ samples: 1 }});
return JSON.stringify([found.status, Array.from(run.state()), found.events.map((each) => each.time)])
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The paper's chaotic case."""
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
    (path,) = jp.report(mechanism, tmp_path_factory.mktemp("live") / "c.html")
    return SimpleNamespace(mechanism=mechanism, path=path)


@pytest.mark.parametrize("name", ["chromium", "firefox"])
def test_two_turns_are_those_of_the_program(name, page, request):
    browser = request.getfixturevalue(name)
    opened(browser, page.path)
    status, state, times = json.loads(browser.execute_script(TWO_TURNS))
    native = jp.simulate(page.mechanism, turns=TURNS, rtol=live.RTOL, samples_per_turn=1)
    assert status == "ok"
    angles = native.angle.isel(time=-1).values
    speeds = native.angular_velocity.isel(time=-1).values
    for ours, theirs in ((state[:3], angles), (state[3:], speeds)):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-9 * np.abs(theirs).max())
    np.testing.assert_allclose(times, native.event_time.values, rtol=0, atol=1e-9 * times[-1])


@pytest.mark.nightly
def test_the_force_of_a_clicked_point_is_the_program_s(page, chromium, tmp_path):
    over = {"clearance": [1e-4, 2.9e-4]}
    sweep = jp.bifurcation(page.mechanism, over=over, direction="up", transient=20, turns=20, n_jobs=1)
    path, _ = jp.report(sweep, tmp_path / "sweep.html", mechanism=page.mechanism)
    opened(chromium, path, "#cell=1")
    until(chromium, f"return {SAID}.includes('in which the stored motion ended')", 120)
    time, _, _, force = np.array(chromium.execute_script(MOTIONS)[0])
    state = sweep["end_state"].isel(clearance=1).values.ravel()
    names = [link.name for link in page.mechanism.links]
    start = {"angle": dict(zip(names, state[:3], strict=True))}
    start["angular_velocity"] = dict(zip(names, state[3:], strict=True))
    native = jp.simulate(page.mechanism, turns=4, initial=start, rtol=1e-9, samples_per_turn=720)
    theirs = native.normal_force.values[1:, 0]
    assert time[-1] == pytest.approx(4.0)
    assert np.ptp(theirs[:720]) > 20
    np.testing.assert_allclose(force[:720], theirs[:720], rtol=0, atol=1e-3 * theirs.max())
    assert complaints(chromium) == []


@pytest.mark.parametrize("name", ["chromium", pytest.param("firefox", marks=pytest.mark.nightly)])
def test_the_verdict_on_the_chaotic_case_is_the_program_s(name, page, request):
    browser = request.getfixturevalue(name)
    opened(browser, page.path)
    until(browser, f"{SETTLED}400", 300)
    verdict = text(browser, "live-verdict")
    value, error = exponent(verdict)
    assert "The motion is chaotic" in verdict
    assert abs(value - 1.667) < 4 * np.hypot(error, 0.017)  # docs/findings.md, of 5000 turns
    if name == "chromium":
        assert complaints(browser) == []
    assert page.path.stat().st_size < 1.5e6
