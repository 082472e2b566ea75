"""What a gradient is taken by where nobody says it."""

import pytest

from jointplay import catalog
from jointplay.analysis.gradients.selection import usual_parameters

JOINT = [f"joints.B.{name}" for name in ("clearance", "contact.stiffness", "contact.damping")]
MASSES = [f"links.{name}.mass" for name in ("crank", "coupler", "rocker")]


@pytest.mark.parametrize(("changes", "drive"), [({}, "gear_ratio"), ({"speed": 20.0}, "speed")])
def test_joints_with_clearance_masses_and_the_drive(changes, drive):
    found = usual_parameters(catalog.chunmei2002(friction=0.1, **changes))
    assert list(found) == [*JOINT, "joints.B.friction.coefficient", *MASSES, drive]


def test_all_numbers_of_a_test_system():
    system = catalog.soft_impact_pair(3.0, 10.0, 0.1)
    assert set(usual_parameters(system)) == {"gap", "stiffness", "damping"}
