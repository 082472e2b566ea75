"""Names of joints in the drawing of a mechanism, in Node: they keep clear of what moves."""

import numpy as np
import pytest

from jointplay import catalog
from jointplay.solver.mechanism.loops.ideal import ideal_state
from jointplay_page import live, moving
from tests.pages.live_samples import linkage
from tests.script.in_node import needs_node, ran

pytestmark = needs_node
SCALE, SIZE, POSES = 1800.0, (500, 330), 48  # px in a metre, px
PROGRAM = """
const canvas = {};
const links = data.links.map((each) => ({ ...each, frames: Float64Array.from(each.frames) }));
const put = ([x, y]) => [100 + data.scale * x, 260 - data.scale * y];
return data.poses.map((at) => stage.names(canvas, { ...data, links }, put, at, data.size));
"""


def places(mechanism):
    """Ends of the links of a four-bar at even angles of its crank, px; shape (poses, links, 2, 2)."""
    found = []
    for angle in 2 * np.pi * np.arange(POSES) / POSES:
        state = ideal_state(mechanism, angle)[0]
        arms = [mechanism.link(n).length * np.array([np.cos(state[n]), np.sin(state[n])]) for n in state]
        ground = np.array(mechanism.joint("C").bearing.point)
        starts = [np.zeros(2), arms[0], ground]
        found.append([(start, start + arm) for start, arm in zip(starts, arms, strict=True)])
    return np.array(found)


def test_names_keep_clear_of_links_and_of_each_other(tmp_path):
    mechanism = linkage()
    ends = places(mechanism)
    turned = np.arctan2(*np.moveaxis(ends[:, :, 1] - ends[:, :, 0], -1, 0)[::-1])
    frames = np.concatenate([ends[:, :, 0], turned[..., None]], -1)
    scene = moving.scene(mechanism)
    for k, link in enumerate(scene["links"]):
        link["frames"] = frames[:, k].ravel().tolist()
    data = scene | {"scale": SCALE, "size": SIZE, "poses": list(range(POSES))}
    names = np.array(ran(live.own("stage.js"), data, PROGRAM, tmp_path))
    lines = np.array([100.0, 260.0]) + SCALE * ends * [1, -1]
    along = np.linspace(0, 1, 200)[:, None]
    points = lines[:, :, None, 0] + along * (lines[:, :, None, 1] - lines[:, :, None, 0])
    apart = np.linalg.norm(points[:, None] - names[:, :, None, None], axis=-1).min(axis=(2, 3))
    assert apart.min() > 9
    between = np.linalg.norm(names[:, :, None] - names[:, None], axis=-1)
    assert between[:, ~np.eye(names.shape[1], dtype=bool)].min() > 13
    assert np.all((names > 9) & (names < np.array(SIZE) - 9))


def test_the_whole_block_of_a_slider_is_in_the_frame(tmp_path):
    mechanism = catalog.slider_crank(clearance={"G": 1e-4}, half_length=0.03, half_height=0.01)
    scene = moving.scene(mechanism)
    for link, frame in zip(scene["links"], ([0, 0, 0], [0.05, 0, 0], [0.17, 0, 0]), strict=True):
        link["frames"] = frame
    program = """
    data.links.forEach((each) => { each.frames = Float64Array.from(each.frames); });
    return stage.bounds(data);
    """
    found = ran(live.own("stage.js"), scene, program, tmp_path)
    assert found == pytest.approx([0.0, 0.2, -0.01, 0.01])


def test_the_corners_of_a_guide_are_shown_together(tmp_path):
    mechanism = catalog.slider_crank(clearance={"G": 1e-4})
    (view,) = live.views(mechanism, [])
    corners = mechanism.joint("G").contacts
    assert view["force"] == ["normal_force", *corners]
    assert view["words"][2] == "Force at G, all corners (N)"
    forces = {name: [1.0, 10.0**k] for k, name in enumerate(corners)}
    data = {"out": {"time": [0.0, 1.0], "normal_force": forces}, "wanted": [view["force"]]}
    program = "return picked(data.out, data.wanted);"
    assert ran(f"let onmessage;\n{live.own('worker.js')}", data, program, tmp_path) == [[4.0, 1111.0]]
    section = live.section(live.live(mechanism, [])[0])
    assert ">Over the turn</figcaption>" in section  # where there is no second curve
