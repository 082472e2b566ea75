"""Stiffness of a contact against Hertz's closed form."""

import math

import pytest

import jointplay as jp


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
