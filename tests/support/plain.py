"""Generated modules as plain Python: the same text without numba, so that it also takes complex numbers."""

from __future__ import annotations

import re
from collections import defaultdict
from functools import cache
from types import ModuleType

import numpy as np

from jointplay.solver.codegen import module
from jointplay.solver.codegen.dynamics import Dynamics
from jointplay.solver.codegen.elimination import Plan
from jointplay.solver.codegen.variants import variants
from jointplay.solver.equations.write import system
from jointplay.solver.method import sparse
from jointplay.solver.method.lanes import lanewise

IMPORTS = re.compile(
    r"^from (?:jointplay\.solver\.method(?:\.lanes)?|)\.(?:interface|lanewise) import .*$", re.MULTILINE
)
PRETENCE = {
    "compiled": lambda f: f,
    "inner": lambda f: f,
    "inlined": lambda f: f,
    "entry": lambda *_: lambda f: f,
    "handed": None,
    "lanewise": lanewise.lanewise,
    "SIGNATURES": defaultdict(type(None)),
}


def run(source) -> ModuleType:
    """What a generated text defines, uncompiled."""
    source = IMPORTS.sub("", source).replace("from math import", "from numpy import")
    scope = PRETENCE | {"sparse": sparse}
    exec(source.replace("from jointplay.solver.method import sparse", ""), scope)
    scope["copysign"] = lambda size, x: np.copysign(size, np.real(x))
    return _module(scope)


def _module(scope) -> ModuleType:
    found = ModuleType("plain")
    vars(found).update(scope)
    return found


@cache
def text(structure) -> str:
    """Source of a structure's module."""
    return module.text(system(structure))


@cache
def plain(structure) -> ModuleType:
    """The functions of a structure's module, uncompiled; of many unknowns, also its `plans` by variant."""
    found = run(text(structure))
    if found.SIZES["planned"]:
        equations = system(structure)
        found.plans = [Plan.of(Dynamics(equations, variant)) for variant in variants(equations)]
    return found


VARIANTS = {"free": 0, "released": 0, "slip+": 1, "slip-": 1, "contact": 1, "stick": 2}


class Point:
    """A module's functions at one base point (t, positions, speeds), with given modes and kind of number."""

    def __init__(self, functions, numbers, state, modes, kind=float, t=0.0):
        self.f, self.sizes, self.kind = functions, functions.SIZES, kind
        self.p = np.array(numbers, dtype=float)
        self.s = np.concatenate([[t], state, np.zeros(2 * self.sizes["angles"])]).astype(kind)
        self.variant = max([VARIANTS[mode] for mode in modes], default=0)
        self.m = masks(modes)
        self.f.trig(self.s, self.p)
        self.w = np.zeros(8 * self.sizes["rows"], dtype=kind)

    @property
    def lanes(self) -> np.ndarray:
        """Rows of eight, from the increment of time on; a view."""
        return self.w.reshape(-1, 8)[self.sizes["first"] :]

    def rate(self, increments=None) -> np.ndarray:
        """Rates in eight lanes, shape (speeds, 8), at increments (1 + state, 8) of time and state."""
        n_x = self.sizes["positions"] + self.sizes["speeds"]
        self.lanes[: 1 + n_x] = 0.0 if increments is None else increments
        self.f.rate(self.variant, self.w, self.s, self.p, self.m)
        return self.lanes[1 + n_x : 1 + n_x + self.sizes["speeds"]].copy()

    def watched(self) -> np.ndarray:
        """Rows after the rates: guards (four a contact), resets, section, powers."""
        n_x, n = self.sizes["positions"] + self.sizes["speeds"], self.sizes["speeds"]
        return self.lanes[1 + n_x + n :].copy()

    def values(self) -> np.ndarray:
        """What `jacobian` writes: d rate / d state row by row, or the values of a plan."""
        out = np.zeros(self.sizes["jacobian"], dtype=self.kind)
        self.f.jacobian(self.variant, self.s, self.p, self.m, out)
        return out

    def jacobian(self) -> np.ndarray:
        """d rate / d state, shape (speeds, positions + speeds)."""
        if self.sizes["planned"]:
            M, B = self.matrices()
            return np.linalg.solve(M, B)
        return self.values().reshape(self.sizes["speeds"], -1)

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """M, and the derivatives of Q - M a by positions and speeds, from the values of a plan."""
        n, n_q, plan = self.sizes["speeds"], self.sizes["positions"], self.f.plans[self.variant]
        M, B, values = np.zeros((n, n), self.kind), np.zeros((n, n_q + n), self.kind), self.values()
        for matrix, places, shift in ((M, plan.mass, 0), (B, plan.pull, 0), (B, plan.rate, n_q)):
            for (i, j), at in places.items():
                matrix[i, shift + j] = values[at]
        return M, B

    def contacts(self) -> np.ndarray:
        """u, v_n, v_t, F_n (the law's), F_t, v_t' of each contact, shape (contacts, 6)."""
        out = np.zeros(6 * self.sizes["contacts"], dtype=self.kind)
        self.f.contacts(max(self.variant, 1), self.s, self.p, self.m, out)
        return out.reshape(-1, 6)


def masks(modes) -> np.ndarray:
    """Touch, slip and stick of each contact."""
    rows = [
        (mode not in ("free", "released"), {"slip+": 1, "slip-": -1}.get(mode, 0), mode == "stick")
        for mode in modes
    ]
    return np.array(rows or [(0, 0, 0)], dtype=float).ravel()
