"""Links by shape: closed forms against integrals, what follows anew and what stays, and what is refused."""

import math
import tomllib

import pytest
from scipy.integrate import dblquad

import jointplay as jp
from jointplay.analysis.keywords import doubts
from jointplay.solver.mechanism.parts.beam import Shape, modal
from jointplay.solver.mechanism.parts.materials import TABLE
from jointplay.solver.mechanism.paths import at_paths
from jointplay.study.models import build_mechanism
from tests.support.wrong import only, problems_of

BAR = {"bar": {"width": "20 mm", "thickness": "6 mm"}, "material": "steel"}
LENGTH, STEEL = 0.1, 7850.0


def link(shape=BAR, **more):
    return jp.Link(name="bar", length=LENGTH, shape=shape, **more)


def told(**body):
    """Mass, mass centre and moment of inertia about it of a steel link."""
    return list(Shape(**body, material="steel").numbers(LENGTH).values())


def integrated(half_width, thickness, left, right):
    """The same of a homogeneous sheet between two ends and under a curve, by quadrature."""

    def over(weight):
        whole = dblquad(lambda y, x: weight(x - LENGTH / 2, y), left, right, 0, half_width, epsabs=1e-12)[0]
        return 2 * STEEL * thickness * whole

    mass = over(lambda x, y: 1)
    return [mass, LENGTH / 2 + over(lambda x, y: x) / mass, over(lambda x, y: x**2 + y**2)]


def test_a_bar_reaches_past_its_pins():
    mass, whole = STEEL * 0.02 * 0.006 * 0.13, 0.13
    bar = {"width": 0.02, "thickness": 0.006, "overhang": 0.015}
    assert told(bar=bar) == pytest.approx([mass, 0.05, mass * (whole**2 + 0.02**2) / 12], rel=1e-14)
    assert told(bar=bar) == pytest.approx(integrated(lambda x: 0.01, 0.006, -0.015, 0.115), rel=1e-9)


def test_a_rod_is_a_cylinder_and_a_tube_what_is_left_of_one():
    def cylinder(d):
        mass = STEEL * math.pi * d**2 / 4 * LENGTH
        return [mass, mass * (LENGTH**2 / 12 + d**2 / 16)]

    mass, _, inertia = told(rod={"diameter": 0.02})
    assert [mass, inertia] == pytest.approx(cylinder(0.02), rel=1e-14)
    mass, _, inertia = told(tube={"diameter": 0.02, "wall": 0.002})
    left = [a - b for a, b in zip(cylinder(0.02), cylinder(0.016), strict=True)]
    assert [mass, inertia] == pytest.approx(left, rel=1e-12)
    wide = told(tube={"diameter": 0.02, "wall": 0.002, "overhang": 0.01})
    assert wide[0] == pytest.approx(mass * 1.2, rel=1e-14)
    assert wide[1] == LENGTH / 2


def test_a_plate_is_round_about_its_pins():
    r = 0.02

    def half(x):
        beyond = max(-x, x - LENGTH, 0.0)
        return math.sqrt(max(r**2 - beyond**2, 0.0))

    parts = [integrated(half, 0.005, *ends) for ends in ((-r, 0), (0, LENGTH), (LENGTH, LENGTH + r))]
    mass, inertia = (sum(part[i] for part in parts) for i in (0, 2))
    assert told(plate={"width": 2 * r, "thickness": 0.005}) == pytest.approx([mass, 0.05, inertia], rel=1e-7)


def test_a_link_takes_mass_inertia_and_its_beam_from_its_shape():
    made = link(elastic=True, beam={"damping_ratio": 0.01, "shapes": "sine"})
    mass = STEEL * 0.02 * 0.006 * 0.1
    assert (made.mass, made.centre) == (pytest.approx(mass), 0.05)
    assert made.inertia == pytest.approx(mass * (0.1**2 / 3 + 0.02**2 / 12), rel=1e-14)
    # the lowest frequency of a pinned beam is (pi/l)² sqrt(E I/(rho A)), and sqrt(I/A) of a bar w/sqrt(12)
    lowest = (math.pi / 0.1) ** 2 * math.sqrt(2.1e11 / STEEL) * 0.02 / math.sqrt(12)
    assert modal(made).frequency[0] == pytest.approx(lowest, rel=1e-12)
    tube = link({"tube": {"diameter": 0.02, "wall": 0.002}, "material": "aluminium"}).beam
    assert (tube.modulus, tube.density) == (7e10, 2700.0)
    assert tube.second_moment == pytest.approx(math.pi * (0.02**4 - 0.016**4) / 64, rel=1e-14)


def test_what_is_given_beside_a_shape_wins_and_is_compared():
    weighed = link(mass=0.3)
    assert weighed.inertia == pytest.approx(0.3 * (0.1**2 / 3 + 0.02**2 / 12), rel=1e-14)
    assert link(inertia_centre=1e-4).inertia is None
    assert link(beam={"modulus": 2e11}).beam.modulus == 2e11
    assert link(beam={"modulus": 2e11}).beam.density == STEEL
    four_bar = jp.catalog.slider_crank()
    doubted = {}
    for key, value in (("mass", 0.3), ("mass", 0.1), ("inertia_centre", 1e-3), ("centre", 0.02)):
        wide = {"bar": {"width": 0.03, "thickness": 0.004}, "material": "steel"}
        rod = jp.Link(name="rod", length=0.12, shape=wide, **{key: value})
        links = (four_bar.links[0], rod, four_bar.links[2])
        found = list(doubts(jp.Mechanism(**dict(four_bar) | {"links": links}), None, None))
        doubted[key, value] = [(problem.key, problem.expected) for problem in found]
    assert doubted["mass", 0.1] == []  # the shape's is 0.113 kg
    for key, value in (("mass", "0.113"), ("inertia_centre", "0.0001441"), ("centre", "0.06")):
        ((where, text),) = doubted[key, 0.3 if key == "mass" else 1e-3 if key[0] == "i" else 0.02]
        assert where == f"mechanism.links[1].{key}"
        assert f"the shape of rod gives {value}" in text


@pytest.mark.parametrize(("radius", "meant"), [(10.0, "; did you mean 10 mm = 0.01 m?"), (90.0, "")])
def test_a_pin_longer_than_its_link_is_told_instead_of_the_link_s_shape(radius, meant):
    base = jp.catalog.slider_crank(clearance=1e-5)
    wide = {"bar": {"width": 0.03, "thickness": 0.004}, "material": "steel"}
    links = (base.links[0], jp.Link(name="rod", length=0.12, shape=wide), base.links[2])
    (i,) = (i for i, each in enumerate(base.joints) if not each.ideal)
    said = {}
    for size, key in ((radius, f"joints[{i}].radius"), (0.016, "links[1].shape.bar.width")):
        joints = [each.model_copy(update={"radius": size} if each.radius else {}) for each in base.joints]
        parts = dict(base) | {"links": links, "joints": tuple(joints)}
        said[size] = only(problems_of(jp.Mechanism, **parts), f"mechanism.{key}").expected
    assert said[radius] == f"a radius less than 0.015 m is accepted, half the width of rod{meant}"
    assert said[0.016].startswith("a width greater than 0.032 m is accepted")
    assert said[0.016].endswith("is accepted: with 0.03 m a radius of joint B less than 0.015 m")


def test_a_radius_that_varies_is_told_the_radius_that_the_link_takes():
    base = jp.catalog.slider_crank(clearance=1e-5)
    wide = {"bar": {"width": 0.03, "thickness": 0.004}, "material": "steel"}
    links = (base.links[0], jp.Link(name="rod", length=0.12, shape=wide), base.links[2])
    mechanism = jp.Mechanism(**dict(base) | {"links": links})
    with pytest.raises(jp.InputError) as told:
        mechanism.varied({"joints.B.radius": 0.016})
    width = "links.rod.shape.bar.width is 0.03, and there a width greater than 0.032 m is accepted"
    radius = "with 0.03 m a radius of joint B less than 0.015 m"
    assert str(told.value) == f"joints.B.radius: got 0.016; {width}: {radius}"
    assert mechanism.varied({"joints.B.radius": 0.0149}).joint("B").radius == 0.0149


@pytest.mark.parametrize(
    ("change", "mass", "gyration"),
    [
        ({"length": 0.2}, STEEL * 0.2 * 0.02 * 0.006, 0.2**2 / 3 + 0.02**2 / 12),
        ({"shape.bar.width": 0.03}, STEEL * 0.1 * 0.03 * 0.006, 0.1**2 / 3 + 0.03**2 / 12),
        ({"shape.material": "aluminium"}, 2700 * 0.1 * 0.02 * 0.006, 0.1**2 / 3 + 0.02**2 / 12),
        ({"mass": 0.3}, 0.3, 0.1**2 / 3 + 0.02**2 / 12),
        ({"centre": 0.06}, STEEL * 0.1 * 0.02 * 0.006, 0.06**2 + (0.1**2 + 0.02**2) / 12),
    ],
)
def test_what_follows_from_a_shape_follows_a_change(change, mass, gyration):
    for made in (
        link(),
        jp.Link(**link().model_dump()),
        jp.Link.model_validate_json(link().model_dump_json()),
    ):
        changed = at_paths(made, change)
        assert changed.mass == pytest.approx(mass, rel=1e-14)
        assert changed.inertia == pytest.approx(mass * gyration, rel=1e-14)
    bent = at_paths(link(beam={"modulus": 2e11}), {"shape.bar.width": 0.03, "beam.gauge": 0.4}).beam
    assert (bent.modulus, bent.gauge) == (2e11, 0.4)
    assert bent.area == pytest.approx(0.03 * 0.006)


def test_a_shape_varies_and_a_file_reads_back_as_it_was():
    table = tomllib.loads("""
        [[links]]
        name = "arm"
        length = "100 mm"
        shape.plate = { width = "30 mm", thickness = "5 mm" }
        shape.material = { modulus = "70 GPa", density = 2700 }
        [[joints]]
        name = "O"
        journal = { link = "arm" }
        bearing = { link = "ground", point = [0, 0] }
        """)
    made = build_mechanism(table)
    assert jp.Mechanism.model_validate_json(made.model_dump_json()) == made
    twice = made.varied({"links.arm.shape.plate.thickness": 0.01}).links[0]
    assert twice.mass == pytest.approx(2 * made.links[0].mass, rel=1e-14)
    assert twice.inertia == pytest.approx(2 * made.links[0].inertia, rel=1e-14)


def test_wrong_shapes_are_named_with_what_would_be_accepted():
    found = problems_of(jp.Link, name="bar", length=0.1, mass=1.0)
    assert "shape = { bar = {" in only(found, "link.inertia").expected
    assert {"link.mass", "link.inertia"} == problems_of(jp.Link, name="bar", length=0.1).keys()
    wrong = {"bar": {"width": 0}, "material": "stel"}
    found = problems_of(jp.Link, name="bar", length=0.1, shape=wrong)
    assert {"link.shape.bar.width", "link.shape.bar.thickness", "link.shape.material"} == found.keys()
    assert "did you mean 'steel'" in found["link.shape.material"].expected
    assert all(name in found["link.shape.material"].expected for name in TABLE)
    both = BAR | {"rod": {"diameter": 0.01}}
    assert only(problems_of(jp.Link, name="bar", length=0.1, shape=both), "link.shape").given == [
        "bar",
        "rod",
    ]
    thick = {"tube": {"diameter": 0.01, "wall": "5 mm"}, "material": "POM"}
    problem = only(problems_of(jp.Link, name="bar", length=0.1, shape=thick), "link.shape.tube.wall")
    assert "less than half the diameter, 0.005 m" in problem.expected


def test_a_shape_thinner_than_a_pin_through_it_is_refused():
    made = jp.catalog.slider_crank()
    rod = jp.Link(name="rod", length=0.12, shape=BAR)
    whole = dict(made) | {"links": (made.links[0], rod, made.links[2])}
    problem = only(problems_of(jp.Mechanism, **whole), "mechanism.links[1].shape.bar.width")
    assert problem.given == 0.02
    assert "greater than 0.02 m" in problem.expected
    assert "joint" in problem.expected
