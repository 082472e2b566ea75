"""Exponents of many motions in lanes of vectors, against one by one."""

from statistics import median

from jointplay.analysis.exponents.frame_growth import Stretch, grown, grown_together
from jointplay.solver.motion.trajectory import Request

from . import ensembles

MEASURED = 60  # turns over which exponents are measured


class Exponents:
    """Exponents of each motion, together against one by one: CPU time, alternating, medians."""

    params = (list(ensembles.LOADS), [1e-5, 1e-7], [1, 2, 6])
    param_names = ("load", "rtol", "exponents")
    unit = "times as fast"
    timeout = 1800

    def track_exponents(self, load, rtol, exponents):
        scenes = ensembles._scenes(*ensembles.LOADS[load][:4])
        asked = [Stretch(Request(MEASURED * each.period, rtol), exponents, 0.0) for each in scenes]
        grown_together(scenes[:1], asked[:1])
        pairs = list(zip(scenes, asked, strict=True))[::8]
        grown(*pairs[0])
        gains = []
        for _ in range(ensembles.AGAIN):
            alone = ensembles._seconds(lambda: [grown(*pair) for pair in pairs])
            gains.append(8 * alone / ensembles._seconds(lambda: grown_together(scenes, asked)))
        return float(f"{median(gains):.3g}")
