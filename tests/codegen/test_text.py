"""The text of a module: the same in every process, and its parameters in the catalog's order."""

from __future__ import annotations

import os
import re
import subprocess
import sys

import pytest

from jointplay.solver.codegen import cache, place
from jointplay.solver.equations.parameters import parameter_names
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
from jointplay.solver.mechanism.own.systems import SYSTEMS
from jointplay.solver.mechanism.parts.beam import Beam
from tests.support.plain import plain, text

from .samples import ARGUMENTS, oscillator

SCRIPT = """
import hashlib
from jointplay.solver.codegen.algebra import text as algebra
from jointplay.solver.codegen.module import text
from jointplay.solver.equations.write import system
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.assemble import assemble
two = assemble(catalog.chunmei2002(clearance={"B": 1e-5, "C": 1e-5}), powers=True, section="angle:crank")
loop = assemble(catalog.chunmei2002(clearance=0, elastic=("coupler",)))
ball = assemble(catalog.soft_impact_pair(1.0, 50.0, 2.0))
texts = [text(system(model.structure)) for model in (two, loop, ball)] + [algebra(3, 3)]
print(two.structure, hashlib.sha256("".join(texts).encode()).hexdigest())
"""


@pytest.mark.nightly
def test_the_text_does_not_depend_on_the_hash_seed():
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", SCRIPT],
            env=os.environ | {"PYTHONHASHSEED": seed},
            stdout=subprocess.PIPE,
            text=True,
        )
        for seed in ("1", "2")
    ]
    found = [process.communicate(timeout=120)[0] for process in processes]
    assert found[0] == found[1] != ""


@pytest.mark.parametrize("name", SYSTEMS)
def test_numbers_of_an_oscillator_are_in_the_order_of_its_equations(name):
    model, system = oscillator(name), catalog.NAMES[name](**ARGUMENTS.get(name, {}))
    parameters = plain(model.structure).PARAMETERS
    assert list(model.numbers) == [float(system.parameters[key]) for key in parameters]


@pytest.mark.parametrize(
    ("joints", "elastic"), [("B", ()), ("BC", ()), ("B", ("coupler",)), ("", ()), ("", ("coupler", "rocker"))]
)
def test_parameters_of_a_linkage_are_in_the_order_of_the_structure(joints, elastic):
    model = assemble(catalog.chunmei2002(clearance=dict.fromkeys(joints, 1e-5), elastic=elastic))
    assert parameter_names(model.structure) == plain(model.structure).PARAMETERS
    assert len(model.numbers) == len(parameter_names(model.structure))


def test_a_part_that_a_scene_lacks_leaves_no_trace():
    bare = catalog.chunmei2002(friction=0, gravity=0.0, drive=None)
    assert "variant == 2" not in text(assemble(bare, {"crank_speed": 5.0}).structure)  # no sticking variant
    assert "variant == 2" in text(assemble(catalog.chunmei2002()).structure)


def test_a_rigid_link_costs_nothing():
    """Its beam is no part of structure or numbers; beside a link that bends, it has no symbol of bending."""
    rigid = catalog.chunmei2002()
    stiff = tuple(link.model_copy(update={"beam": Beam(modulus=1e9, elements=5)}) for link in rigid.links)
    here, there = assemble(rigid), assemble(rigid.model_copy(update={"links": stiff}))
    assert here.structure == there.structure
    assert list(here.numbers) == list(there.numbers)
    assert here.structure == assemble(rigid.replace(elastic=("coupler",)).replace(elastic=())).structure
    assert not re.search(r"\bd?eta_", text(here.structure))
    bent = assemble(rigid.replace(elastic=("coupler",)))
    names = local_names(bent)
    words = ("eta", "deta", "S", "I", "k", "c", "start", "end", "gauge")
    assert {name for name in names if name.startswith(tuple(f"{word}_coupler_" for word in words))}
    assert not {name for name in names if re.fullmatch(rf"({'|'.join(words)})_(crank|rocker)_\d", name)}


def test_undamped_links_have_no_damping():
    bent = assemble(catalog.chunmei2002(elastic=("coupler",), damping_ratio=0.0))
    assert "c_coupler_0" not in local_names(bent)
    assert "c_coupler_0" in local_names(assemble(catalog.chunmei2002(elastic=("coupler",))))


def local_names(model):
    """Names that functions of a model's module assign, without the number of the variant."""
    return {name.split("__")[0] for name in re.findall(r"^ +(\w+) =", text(model.structure), re.MULTILINE)}


def test_a_module_once_loaded_is_kept_and_no_file_of_it_is_looked_at_again(monkeypatch):
    """Sweeps make the structure anew at every point, and each step of an analysis asks for its module."""
    read, believed = [], place.believed
    monkeypatch.setattr(place, "believed", lambda path: read.append(path.name) or believed(path))
    cache._module.cache_clear()
    found = []
    for clearance in (1e-5, 2e-5, 3e-5):
        found.append(cache.structure_module(assemble(catalog.chunmei2002(clearance=clearance)).structure))
        if len(found) == 1:
            assert read
            read.clear()
    assert not read
    assert found[0] is found[1] is found[2]
    assert cache.structure_module(assemble(catalog.chunmei2002(clearance=0.0)).structure) is not found[0]
