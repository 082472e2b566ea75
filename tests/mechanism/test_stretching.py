"""Modes along an elastic link, and what a link that stretches cannot have."""

import math
from functools import partial

import numpy as np
import pytest

import jointplay as jp
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.parts.beam import hermites, sines
from jointplay.solver.mechanism.parts.stretch import along

SOFT = {"rod": 3e-4}


def slider_crank(clearance=0, beam=None, **changes):
    """A slider-crank whose rod stretches."""
    rigid = jp.catalog.slider_crank(clearance=clearance, inertia_centre=SOFT, **changes)
    return stretching(rigid, "rod", beam or {})


def stretching(rigid, name, beam, **fields):
    """A mechanism with a link that stretches."""
    bent = {"elastic": True, "beam": jp.Beam(**{"shapes": "sine", "modes": 2, "axial": True} | beam)}
    links = [jp.Link(**dict(link) | bent) if link.name == name else link for link in rigid.links]
    return jp.Mechanism(**dict(rigid) | {"links": links} | fields)


def test_frequencies_are_those_of_a_bar():
    """E/ρ alone makes them; two parabolas are 0.3 % and 15 % off the exact (2 n − 1) π/2."""
    link = slider_crank(beam={"modulus": 2e11, "density": 8000.0}).link("rod")
    exact = np.array([0.5, 1.5]) * math.pi * math.sqrt(2e11 / 8000.0) / link.length
    off = along(link).frequency / exact - 1
    assert off[0] == pytest.approx(0.00376, abs=1e-5)
    assert 0.15 < off[1] < 0.21


def test_a_bar_hangs_as_it_should():
    """Static stretch under its own weight, x (l − x/2) ρ g/E: a parabola, which the shapes hold."""
    modes, link = along(slider_crank().link("rod")), slider_crank().link("rod")
    tip = link.length * np.sum(modes.stretch * modes.force * 9.8 / modes.frequency**2)
    assert tip == pytest.approx(link.beam.density * 9.8 * link.length**2 / (2 * link.beam.modulus), rel=1e-12)


@pytest.mark.parametrize("family", [partial(hermites, 3, 6), partial(sines, 6)])
def test_second_moments(family):
    """∫x² φ_i dx by Gauss points of three elements."""
    node, weight = np.polynomial.legendre.leggauss(12)
    x = np.concatenate([(e + (1 + node) / 2) / 3 for e in range(3)])
    shapes = np.array([family(at).gauge for at in x])
    assert np.tile(weight / 6, 3) * x**2 @ shapes == pytest.approx(family(0.5).second, rel=1e-10)


def test_a_link_that_stretches_is_refused_where_the_equations_do_not_know_it():
    def refused(mechanism, match):
        with pytest.raises(jp.InputError, match=match):
            assemble(mechanism)

    rigid = jp.catalog.slider_crank(clearance=0, inertia_centre={"crank": 1e-4})
    refused(stretching(rigid, "crank", {}), "far end holds no other link")
    with pytest.raises(jp.InputError, match="what slides would bend an elastic one"):
        stretching(jp.catalog.quick_return(), "arm", {})
    refused(slider_crank().replace(order="paper"), "order = 'paper'")
    ends = {"from": jp.Pin(link="rod", at=0.12), "to": jp.Pin(link="ground", point=(0.3, 0.0))}
    spring = jp.Spring(name="s", stiffness=1.0, free_length=0.1, **ends)
    refused(slider_crank(springs=(spring,)), "no spring or load")
    links = [
        jp.Link(**dict(k) | {"masses": [{"at": 0.12, "mass": 0.01}]} if k.name == "rod" else dict(k))
        for k in slider_crank().links
    ]
    refused(jp.Mechanism(**dict(slider_crank()) | {"links": links}), "no point mass")
    turned = [
        jp.Joint(
            **dict(j) | {"journal": jp.Pin(link="rod"), "bearing": jp.Pin(link="slider")}
            if j.name == "B"
            else dict(j) | {"bearing": jp.Pin(link="rod", at=0.12)}
            if j.name == "A"
            else dict(j)
        )
        for j in slider_crank().joints
    ]
    refused(
        jp.Mechanism(**dict(slider_crank()) | {"joints": turned, "guess": {"crank": 0.0, "rod": math.pi}}),
        "sits at its origin",
    )
    assert assemble(slider_crank()).structure.beams[0].axial == 2
