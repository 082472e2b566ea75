"""Contact data of a pin in its bush: formulas against integrals and textbooks, and how a joint takes them."""

import math
import tomllib

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

import jointplay as jp
from jointplay.analysis.keywords import doubts
from jointplay.solver.mechanism.parts.contact_data import ContactData, PinInBush, damping_factor
from jointplay.solver.mechanism.parts.materials import TABLE
from jointplay.study.models import build_mechanism
from tests.support.wrong import only, problems_of

RADIUS, CLEARANCE, LENGTH = 0.0075, 17e-6, 0.012
PARTS = {"pin": "steel", "bush": "bronze", "length": LENGTH}
STEEL, BRONZE = (2.1e11, 0.3), (1e11, 0.34)
STAR = 1 / sum((1 - nu**2) / E for E, nu in (STEEL, BRONZE))  # E*
SIDE = {"name": "B", "journal": {"link": "rod", "at": 0.12}, "bearing": {"link": "slider"}}


def data(**more):
    return ContactData(PinInBush(**PARTS | more), RADIUS, CLEARANCE)


def joint(**more):
    return jp.Joint(**{**SIDE, "radius": "7.5 mm", "clearance": CLEARANCE, **more})


def linkage(**more):
    base = jp.catalog.slider_crank()
    joints = tuple(joint(**more) if each.name == "B" else each for each in base.joints)
    return jp.Mechanism(**dict(base) | {"joints": joints})


def test_contact_data_are_printed_as_a_person_writes_numbers():
    text = str(data())
    assert " × 10⁸ N/m" in text
    assert "e+" not in text


@pytest.mark.parametrize("load", [9.0, 1200.0, 1e6])
def test_a_value_and_its_range_are_printed_with_the_same_digits(load):
    lines = [line.split("(")[0:2] for line in str(data(load=load)).splitlines()[:3]]
    for value, ends in lines:
        low, high = (number(each) for each in ends.partition(")")[0].split(" to "))
        assert low <= number(value.split(maxsplit=1)[1]) <= high


def number(text):
    """A number of a printed table, without its unit."""
    mantissa, _, power = text.strip().partition(" × 10")
    raised = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
    return float(mantissa.split()[0]) * 10 ** int(power.split()[0].translate(raised) if power else 0)


def test_a_load_that_no_material_bears_is_remarked():
    said = [jp.contact_data("5 mm", "40 um", **PARTS, load=load).crushed for load in (2e3, 1e6)]
    assert said[0] == ""
    assert "far beyond elastic contact" in said[1]
    assert said[1] in str(jp.contact_data("5 mm", "40 um", **PARTS, load=1e6))
    for name in TABLE:
        assert jp.contact_data("5 mm", "40 um", **PARTS | {"bush": name}).crushed == ""
    loaded = {"clearance": CLEARANCE, "contact": PARTS | {"load": "1e9 N"}}
    assert {each.key for each in doubts(linkage(**loaded))} == {"mechanism.joints[2].contact.load"}
    assert [*doubts(linkage(**loaded).replace(as_meant=True))] == []


def test_a_clearance_beyond_the_radius_is_refused():
    problem = only(problems_of(jp.contact_data, "5 mm", "6 mm", **PARTS), "clearance")
    assert problem.expected.endswith("of a bearing of 0.006 m it is 0.001")


# The elastic approach


def test_the_contact_is_as_wide_and_pressed_as_roark_prints():
    """Roark's Formulas for Stress and Strain, table 14.1, case 2c, a cylinder in a circular groove.

    The whole width is 1.60 √(p K_D C_E), the pressure 0.798 √(p/(K_D C_E)), with K_D = D1 D2/(D1 - D2).
    """
    found = data(load=300.0)
    p, K_D = 300.0 / LENGTH, 2 * (RADIUS + CLEARANCE) * RADIUS / CLEARANCE
    half_width = RADIUS * math.sin(found.half_angle)
    assert 2 * half_width == pytest.approx(1.60 * math.sqrt(p * K_D / STAR), rel=3e-3)
    assert found.pressure == pytest.approx(0.798 * math.sqrt(p * STAR / K_D), rel=1e-3)


def test_hertz_is_the_strain_below_the_contact_summed_up():
    """The stresses on the line through the contact are known, of a pressure that is an ellipse.

    In the bush they are those of a half-space, in the pin those of a disc with its load on the other side too
    (Johnson 1985, sections 4.2 and 5.6); the strain is summed up to the wall's depth and to the pin's centre.
    """
    load = 4.0
    w, wall = load / LENGTH, 0.02
    a = 2 * math.sqrt(w * RADIUS * (RADIUS + CLEARANCE) / (math.pi * STAR * CLEARANCE))

    def strain(across, along, E, nu):
        return -(1 - nu**2) / E * (along - nu / (1 - nu) * across)

    def bush(z):
        root = math.sqrt(a**2 + z**2)
        across = -2 * w / (math.pi * a**2) * ((a**2 + 2 * z**2) / root - 2 * z)
        return strain(across, -2 * w / (math.pi * root), *BRONZE)

    def pin(z):
        root = math.sqrt(a**2 + z**2)
        across = w / math.pi * (1 / RADIUS - 2 * (a**2 + 2 * z**2) / (a**2 * root) + 4 * z / a**2)
        along = w / math.pi * (1 / RADIUS - 2 / (2 * RADIUS - z) - 2 / root)
        return strain(across, along, *STEEL)

    points = {"points": [a, 10 * a], "limit": 400}
    summed = quad(bush, 0, wall, **points)[0] + quad(pin, 0, RADIUS, **points)[0]
    found = data(load=load, method="hertz", wall=wall, roughness=0.0)
    assert a < 0.02 * RADIUS
    assert found.approach - found._bent(0) == pytest.approx(summed, rel=1e-3)


def test_the_other_methods_are_the_published_formulas():
    S = math.pi * STAR * LENGTH
    for load in (50.0, 900.0):
        bare = {"load": load, "roughness": 0.0}
        found = {name: data(method=name, **bare) for name in ("johnson", "dubowsky_freudenstein", "liu")}
        u = {name: each.approach - each._bent(0) for name, each in found.items()}
        johnson = load / S * (math.log(4 * S * CLEARANCE / load) - 1)
        assert u["johnson"] == pytest.approx(johnson, rel=1e-12)
        inside = S * LENGTH**2 * CLEARANCE / (RADIUS * (RADIUS + CLEARANCE) * load)
        assert u["dubowsky_freudenstein"] == pytest.approx(load / S * (math.log(inside) + 1), rel=1e-12)
        conforming = S / 2 * u["liu"] * math.sqrt(u["liu"] / (2 * (CLEARANCE + u["liu"])))
        assert conforming == pytest.approx(load, rel=1e-12)


@pytest.mark.parametrize("method", ["hertz", "johnson", "dubowsky_freudenstein", "liu"])
def test_the_exponent_is_that_of_the_tangent_at_the_load(method):
    more, less, at = (
        data(method=method, roughness=0.0, load=900.0 * each).approach for each in (1 + 1e-5, 1 - 1e-5, 1)
    )
    slope = 2e-5 / math.log(more / less)
    found = data(method=method, roughness=0.0, load=900.0)
    assert found.exponent.value == pytest.approx(slope, rel=1e-6)
    assert found.stiffness.value * at**found.exponent.value == pytest.approx(900.0, rel=1e-12)


def test_roughness_is_a_stiffness_of_the_load_over_its_height_in_series():
    smooth, rough = data(roughness=0.0), data(roughness=0.8e-6)
    height = 0.4 * math.sqrt(2) * 1.25 * 0.8e-6
    assert rough.approach == pytest.approx(smooth.approach + height, rel=1e-12)
    tangents = [each.exponent.value * each.load / each.approach for each in (smooth, rough)]
    assert 1 / tangents[1] == pytest.approx(1 / tangents[0] + height / rough.load, rel=1e-12)


def test_a_pin_bends_and_shears_as_a_beam_held_at_the_ends_of_its_bush():
    """The mean of a deflection of curvature q x (L - x)/(2 E I) and slope of shear q (L/2 - x)/(k G A)."""
    load, R, L, (E, nu) = 900.0, RADIUS, 0.1, STEEL
    x = np.linspace(0, L, 20001)
    q, I, A, G = load / L, math.pi * R**4 / 4, math.pi * R**2, E / 2 / (1 + nu)
    step = x[1] - x[0]
    slope = np.cumsum(q * x * (L - x) / (2 * E * I)) * step
    bent = np.cumsum(slope) * step
    bent = bent[-1] * x / L - bent
    sheared = np.cumsum(q * (L / 2 - x) / (0.9 * G * A)) * step
    found = ContactData(PinInBush(**PARTS | {"length": L, "load": load}), R, CLEARANCE)
    assert found._bent(0) == pytest.approx(np.mean(bent + sheared), rel=1e-3)


def test_hertz_gives_way_to_liu_where_the_contact_is_wide_and_a_band_holds_all_methods():
    assert data().method == "hertz"
    assert data(bush="POM").method == "liu"
    assert math.degrees(data(bush="POM").half_angle) > 30
    wide = data(load=5e3)
    assert wide.method == "liu"
    assert "hertz" not in wide.methods
    problem = only(
        problems_of(jp.contact_data, RADIUS, CLEARANCE, **PARTS, load=5e3, method="hertz"), "method"
    )
    assert "'liu'" in problem.expected
    found = data()
    assert {"hertz", "johnson", "dubowsky_freudenstein", "liu"} == set(found.methods)
    assert found.secant.value == pytest.approx(found.methods["hertz"], rel=1e-14)
    assert all(found.secant.low < value < found.secant.high for value in found.methods.values())
    assert found.stiffness.low / found.stiffness.value == pytest.approx(found.secant.low / found.secant.value)


# Damping and friction


@pytest.mark.parametrize(
    ("restitution", "mass", "power"), [(0.9, 0.2, 1.5), (0.6, 3.0, 1.1), (0.2, 1.0, 1.25)]
)
def test_a_blow_at_the_speed_has_the_restitution_whatever_mass_and_power(restitution, mass, power):
    speed, K = 0.3, 1e9
    chi = damping_factor(restitution) / speed

    def rates(t, y):
        return [y[1], -K * max(y[0], 0.0) ** power * (1 + chi * y[1]) / mass]

    def gone(t, y):
        return y[0]

    gone.terminal, gone.direction = True, -1
    run = solve_ivp(
        rates, (0, 1), [1e-15, speed], events=gone, rtol=1e-10, atol=1e-14, method="DOP853", max_step=1e-4
    )
    assert -run.y[1, -1] / speed == pytest.approx(restitution, rel=1e-6)


def test_damping_and_friction_are_the_softer_material_s_with_their_spread():
    bronze, swapped = data(), data(pin="POM", bush="steel")
    assert bronze.friction[:3] == TABLE["bronze"].greased
    assert data(lubrication="dry").friction[:3] == TABLE["bronze"].dry
    assert swapped.friction[:3] == TABLE["POM"].greased
    assert swapped.restitution[:3] == TABLE["POM"].restitution
    assert bronze.dissipation.value == pytest.approx(damping_factor(0.8) / 0.1)
    assert bronze.dissipation.low < bronze.dissipation.value < bronze.dissipation.high
    assert data(restitution=0.7, speed=0.2).dissipation.value == pytest.approx(damping_factor(0.7) / 0.2)
    assert damping_factor(1.0) == 0
    for each in TABLE.values():
        for usual, low, high in (each.modulus, each.dry, each.greased, each.restitution):
            assert low < usual < high
    for each in (bronze.stiffness, bronze.exponent, bronze.restitution, bronze.friction):
        assert each.source
        assert each.low <= each.value <= each.high


# In a joint


def test_a_joint_takes_the_numbers_of_its_law_and_friction_from_its_parts():
    made = joint(contact=PARTS)
    told = jp.contact_data("7.5 mm", "17 um", pin="steel", bush="bronze", length="12 mm")
    assert made.contact.law == "hunt_crossley"
    assert made.contact.stiffness == told.stiffness.value
    assert made.contact.parameters == {"exponent": told.exponent.value, "dissipation": told.dissipation.value}
    assert made.friction == jp.Friction(coefficient=0.12)
    assert made.data == told
    for copy in (jp.Joint(**made.model_dump()), jp.Joint.model_validate_json(made.model_dump_json())):
        assert copy == made
    linear = joint(contact=PARTS | {"law": "kelvin_voigt", "damping": 200}).contact
    assert linear.stiffness == told.secant.value
    flores = joint(contact=PARTS | {"law": "flores"}).contact
    assert flores.parameters == {"exponent": told.exponent.value, "restitution": 0.8}
    liu = joint(contact=PARTS | {"law": "liu"}).contact
    assert (liu.parameters["length"], liu.parameters["bearing_modulus"]) == (LENGTH, 1e11)
    assert liu.parameters["restitution"] == 0.8


def test_what_is_given_beside_the_parts_wins():
    given = joint(
        contact=PARTS | {"stiffness": 1e9, "parameters": {"exponent": 1.5}}, friction={"coefficient": 0}
    )
    assert given.contact.stiffness == 1e9
    assert given.contact.parameters["exponent"] == 1.5
    assert given.contact.parameters["dissipation"] > 0
    assert given.friction.coefficient == 0
    steep = joint(contact=PARTS | {"law": "hertz", "parameters": {"exponent": 1.5}})
    assert steep.contact.stiffness * steep.data.approach**1.5 == pytest.approx(steep.data.load)


@pytest.mark.parametrize(
    ("contact", "friction", "told"),
    [
        ({"stiffness": 1e7, "damping": 200.0}, {"coefficient": 0.1}, ["given"] * 3),
        ({"law": "hertz", "stiffness": 1e9}, None, ["given", "default", "left out"]),
        (PARTS, None, ["from pin and bush"] * 4),
        (
            PARTS | {"stiffness": 1e8},
            {"coefficient": 0.1},
            ["given", *["from pin and bush"] * 2, "given"],
        ),
    ],
)
def test_each_number_knows_where_it_comes_from(contact, friction, told):
    one = joint(contact=contact, friction=friction)
    assert [*one.sources] == [*one.contact.numbers, "friction"]
    assert [*one.sources.values()] == told


def test_an_entry_s_own_friction_gives_way_to_that_of_pin_and_bush_and_a_given_one_stays():
    """Its 0.05 stood as if it had been given, where the parts give 0.12."""
    parts = {"joints.B.radius": RADIUS, "joints.B.fit": "H7/f7", "joints.B.contact": PARTS}

    def friction(**more):
        found = jp.catalog.slider_crank(**parts | more).joint("B")
        return found.friction.coefficient, found.sources["friction"]

    assert friction() == (0.12, "from pin and bush")
    assert friction(friction=0.05) == (0.05, "given")
    assert friction(**{"joints.B.friction": {"coefficient": 0.3}}) == (0.3, "given")
    assert friction(**{"joints.B.friction.coefficient": 0.3}) == (0.3, "given")
    later = jp.catalog.slider_crank().replace(friction=0.2, **parts).joint("B")
    assert (later.friction.coefficient, later.sources["friction"]) == (0.2, "given")
    assert jp.catalog.slider_crank(**parts).joint("A").friction.coefficient == 0.05


def test_a_stiffness_by_hand_that_no_such_pin_has_is_doubted():
    def doubted(**contact):
        return list(doubts(linkage(contact=PARTS | contact), None, None))

    assert doubted() == doubted(stiffness=1e9) == doubted(law="kelvin_voigt", damping=9, stiffness=1e8) == []
    assert doubted(law="liu") == []
    for contact in ({"stiffness": 1e7}, {"law": "kelvin_voigt", "damping": 9.0, "stiffness": 1e6}):
        (problem,) = doubted(**contact)
        assert problem.key == "mechanism.joints[2].contact.stiffness"
        told = "1.67e10" if len(contact) == 1 else "5.757e8"
        assert f"pin and bush of B give {told}" in problem.expected


def test_a_path_to_a_part_without_its_last_step_but_one_is_named():
    with pytest.raises(jp.InputError, match=r"did you mean 'parts\.length'"):
        linkage(contact=PARTS).replace(**{"joints.B.contact.length": 0.02})
    with pytest.raises(jp.InputError, match=r"accepted: crank\.mass, coupler\.mass, rocker\.mass$"):
        jp.catalog.chunmei2002().replace(**{"links.mass": 0.02})


def test_what_follows_from_parts_follows_a_change():
    whole = linkage(contact=PARTS)

    def changed(**changes):
        return whole.replace(**changes).joint("B")

    for changes, more in (
        ({"joints.B.clearance": 5e-5}, {"clearance": 5e-5}),
        ({"joints.B.radius": 0.01}, {"radius": 0.01}),
        ({"joints.B.contact.law": "flores"}, {"contact": PARTS | {"law": "flores"}}),
        ({"joints.B.contact.parts.length": 0.02}, {"contact": PARTS | {"length": 0.02}}),
        ({"joints.B.contact.parts.bush": "POM"}, {"contact": PARTS | {"bush": "POM"}}),
        ({"joints.B.contact.stiffness": 1e8}, {"contact": PARTS | {"stiffness": 1e8}}),
    ):
        assert changed(**changes) == joint(**{"contact": PARTS} | more)
    rubbing = changed(**{"joints.B.friction.coefficient": 0.3, "joints.B.friction.viscous": 2.0})
    assert rubbing.friction == jp.Friction(coefficient=0.3, viscous=2.0)
    assert changed(friction=0).friction == jp.Friction(coefficient=0)
    assert changed(friction=0.3).friction == jp.Friction(coefficient=0.3)
    ideal = whole.replace(clearance=0)
    assert ideal.joint("B").ideal
    assert ideal.replace(clearance=5e-5).joint("B") == changed(**{"joints.B.clearance": 5e-5})
    same = whole.varied({"joints.B.contact.stiffness": whole.joint("B").contact.stiffness})
    assert same == whole


def test_numbers_alone_change_one_by_one():
    """As on a page, whose sliders each move one number."""
    drawn = linkage(contact=PARTS)
    bar = {"bar": {"width": 0.03, "thickness": 0.004}, "material": "steel"}
    rod = jp.Link(name="rod", length=0.12, shape=bar)
    whole = jp.Mechanism(**dict(drawn) | {"links": (drawn.links[0], rod, drawn.links[2])})
    alone = whole.numbers_alone()
    assert (alone.link("rod").mass, alone.link("rod").inertia) == (rod.mass, rod.inertia)
    assert alone.joint("B").numbers == whole.joint("B").numbers
    wider = alone.replace(**{"joints.B.clearance": 5e-5, "links.rod.mass": 0.12})
    assert wider.joint("B").contact == alone.joint("B").contact
    assert wider.link("rod").inertia == rod.inertia


def test_a_file_states_parts_as_a_drawing_does_also_of_the_catalog():
    text = """
        catalog = "slider_crank"
        clearance = 0
        [joints.B]
        radius = "7.5 mm"
        fit = "H7/f7"
        contact = { pin = "steel", bush = "bronze", length = "12 mm" }
        friction.coefficient = 0.1
        """
    made = build_mechanism(tomllib.loads(text))
    assert made.joint("B").contact == joint(contact=PARTS).contact
    assert made.joint("B").friction.coefficient == 0.1
    assert jp.Mechanism.model_validate_json(made.model_dump_json()) == made


def test_wrong_parts_are_named_with_what_would_be_accepted():
    found = problems_of(joint, contact={"pin": "stel", "length": -1}, radius=None)
    assert set(found) == {"joint.contact.pin", "joint.contact.bush", "joint.contact.length", "joint.radius"}
    assert "did you mean 'steel'" in found["joint.contact.pin"].expected
    assert "PTFE-lined" in found["joint.contact.bush"].expected
    problem = only(problems_of(joint, contact=PARTS | {"law": "kelvin_voigt"}), "joint.contact.damping")
    assert "kelvin_voigt" in problem.expected
    assert set(problems_of(joint, contact=PARTS | {"damping": 3.0})) == {"joint.contact.damping"}
    wide = PARTS | {"load": "5 kN", "method": "hertz"}
    assert "'liu'" in only(problems_of(joint, contact=wide), "joint.contact.method").expected
    guide = {"kind": "prismatic", "radius": None, "half_length": 0.01, "half_height": 0.01}
    assert "revolute" in only(problems_of(joint, contact=PARTS, **guide), "joint.contact.parts").expected
    wrong = {"pin": "steel", "colour": 3, "method": "guess", "speed": "3 m"}
    found = set(problems_of(jp.contact_data, -1, CLEARANCE, **wrong))
    assert found == {"radius", "bush", "length", "colour", "method", "speed"}


# Balls


def test_stiffness_is_that_of_a_ball_in_a_hollow_ball():
    radius, clearance, E, nu = 0.01, 1e-4, (2.07e11, 1.1e11), (0.3, 0.34)
    h = [(1 - n**2) / (math.pi * e) for e, n in zip(E, nu, strict=True)]
    whole = math.sqrt((radius + clearance) * radius / clearance)
    assert jp.contact_stiffness(radius, clearance, E, nu) == pytest.approx(
        4 / (3 * math.pi * sum(h)) * whole, rel=1e-14
    )
    assert jp.contact_stiffness(radius, clearance) == jp.contact_stiffness(
        radius, clearance, (2.07e11, 2.07e11), (0.3, 0.3)
    )


def test_what_makes_no_stiffness_is_refused_together():
    with pytest.raises(jp.InputError) as caught:
        jp.contact_stiffness(-0.01, 0, (1.0, 2.0, 3.0), 0.7)
    told = str(caught.value)
    for key in (
        "radius: got -0.01",
        "clearance: got 0",
        "modulus: got (1.0, 2.0, 3.0)",
        "poisson_ratio: got 0.7",
    ):
        assert key in told
    with pytest.raises(jp.InputError, match="poisson_ratio"):
        jp.contact_stiffness(0.01, 1e-4, poisson_ratio="steel")


def test_a_bearing_s_radius_is_no_clearance():
    problem = only(problems_of(jp.contact_stiffness, 0.01, 0.0101), "clearance")
    assert "less than the radius, 0.01 m" in problem.expected
    assert "of a bearing of 0.0101 m it is 0.0001" in problem.expected


def test_what_is_wrong_in_a_contact_that_is_changed_has_its_own_key():
    for wrong, key, words in (
        ({"length": "-2 mm"}, "length", "greater than 0"),
        ({"pin": "stel"}, "pin", "did you mean 'steel'"),
        ({"finish": 3}, "finish", "these are accepted: pin, bush, length, "),
    ):
        problems = problems_of(linkage(contact=PARTS).replace, **{"joints.B.contact": PARTS | wrong})
        assert words in only(problems, f"joints.B.contact.{key}").expected


def test_a_doubtful_length_is_named_by_the_key_of_files():
    (problem,) = doubts(linkage(contact=PARTS | {"length": 12.0}), None, None)
    assert problem.key == "mechanism.joints[2].contact.length"
