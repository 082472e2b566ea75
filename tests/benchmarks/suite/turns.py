"""What a turn of a model costs, and how many turns and cells a core does."""

import time
from statistics import median

import jointplay as jp

from .scenes import SCENES, measured

SPEEDS = ("plain", "one elastic link", "three elastic links", "one exponent", "all exponents")
CELL_TURNS, CELLS = 200, 20


class Scenes:
    """What a turn at rtol 1e-8 costs a core, part by part; the counts are of one state each."""

    params = (list(SCENES), ["evaluations", "attempts", "events"])
    param_names = ("model", "of a turn")

    def setup_cache(self):
        return measured()

    setup_cache.timeout = 1800

    def track_counts(self, found, model, quantity):
        return found[model][quantity]

    track_counts.unit = "a turn"

    def track_cpu(self, found, model, quantity):
        return _rounded(found[model][quantity])

    track_cpu.params = (list(SCENES), ["CPU µs", "of plain"])
    track_cpu.unit = ""

    def track_revolutions_a_second(self, found, model):
        return _rounded(1e6 / found[model]["CPU µs"])

    track_revolutions_a_second.params = (list(SPEEDS),)
    track_revolutions_a_second.param_names = ("model",)
    track_revolutions_a_second.unit = "a second"


class Sweep:
    """Cells with assembling and all that a cell does: section points of the second half of the turns."""

    timeout = 1800

    def setup(self):
        _cell(0)

    def track_cells_an_hour(self):
        return _rounded(3600 / median(_cell(number) for number in range(1, CELLS + 1)))

    track_cells_an_hour.unit = "an hour"


def _cell(number):
    mechanism = jp.catalog.chunmei2002(gear_ratio=3.0, clearance=2.9e-5 + 1e-7 * number)
    began = time.process_time()
    jp.poincare(mechanism, turns=CELL_TURNS // 2, transient=CELL_TURNS // 2, rtol=1e-7)
    return time.process_time() - began


def _rounded(number):
    return float(f"{number:.3g}")
