"""Places of links over a motion, against closed forms and the poses of ideal mechanisms."""

import numpy as np
import pytest

from jointplay import catalog
from jointplay.display.errors import InputError
from jointplay.study.results.places import places
from tests.figures.support.synthetic_linkages import four_bar, slides


def missed(motion) -> float:
    return max(float(np.abs(motion[f"origin_{axis}"] - motion[f"true_{axis}"]).max()) for axis in "xy")


def test_origins_of_a_four_bar_with_clearance_are_those_of_the_closed_form():
    mechanism, motion = four_bar()
    assert missed(places(mechanism, motion)) < 1e-15


@pytest.mark.parametrize("name", ["slider_crank", "stephenson", "quick_return"])
def test_origins_of_ideal_mechanisms_are_those_of_their_poses(name):
    mechanism = getattr(catalog, name)(clearance=0)
    motion = slides(mechanism)
    assert missed(places(mechanism, motion)) < 1e-12


def test_order_and_further_links_of_the_result_do_not_matter():
    mechanism, motion = four_bar()
    assert missed(places(mechanism, motion.isel(link=[2, 0, 1]))) < 1e-15


def test_the_motion_of_another_mechanism_is_refused():
    mechanism, motion = four_bar()
    with pytest.raises(InputError, match="joints of this one are"):
        places(mechanism, motion.assign(journal_x=motion["journal_x"] + 0.01 * motion["time"]))
    with pytest.raises(InputError, match="joints of this one are"):
        places(catalog.slider_crank(crank=0.06, clearance=0), slides(catalog.slider_crank(clearance=0)))


@pytest.mark.parametrize("name", ["angle", "journal_x"])
def test_what_was_not_recorded_is_told(name):
    mechanism, motion = four_bar()
    with pytest.raises(InputError, match=f"no {name}"):
        places(mechanism, motion.drop_vars(name))


def test_several_motions_are_refused_and_one_of_them_is_not():
    mechanism, motion = four_bar()
    several = motion.expand_dims(clearance_of_B=2)
    with pytest.raises(
        InputError, match="got 'motions over clearance_of_B'; one motion is accepted: select it"
    ):
        places(mechanism, several)
    assert missed(places(mechanism, several.isel(clearance_of_B=0))) < 1e-15


@pytest.mark.parametrize("recorded", [True, False])
def test_a_slider_with_play_in_its_guide_is_where_its_rod_holds_it(recorded):
    mechanism = catalog.slider_crank(clearance={"G": 1e-3})
    motion = slides(catalog.slider_crank(clearance=0))
    corners = mechanism.joint("G").contacts
    slide = motion["slide_position"].sel(joint="G")
    loose = motion.drop_vars("slide_position").drop_sel(joint="G")
    if recorded:
        loose = loose.assign(slide_position=slide.drop_vars("joint").expand_dims(corner=4))
        loose = loose.drop_dims("joint").rename(corner="joint").assign_coords(joint=list(corners))
    assert missed(places(mechanism, loose)) < 1e-12
