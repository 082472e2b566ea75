"""Fits of ISO 286: how far a hole and a shaft of one nominal size may lie from it, and the clearance between.

Reference: ISO 286-1:2010, tables 1 to 3: widths of tolerance and fundamental deviations up to 500 mm, in µm.
Those of shafts are the tables below; holes follow from them by its rules: C to H mirror c to h; K, M, N up to
grade 8 and P up to grade 7 mirror their shafts and lie higher by Δ, the difference of the grade from the next
finer one, above 3 mm. One exception, M6 from 250 to 315 mm, is the standard's own. Left out are a and b,
intermediate letters as cd, and those of press fits, r and beyond.

A drawing's clearance is that of diameters. The program's, of a joint, is radial: half of it.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from dataclasses import dataclass
from typing import Annotated

from jointplay.display.errors import refuse
from jointplay.solver.mechanism.base import Name, Positive, accepts, unit
from jointplay.solver.mechanism.signature import checked

LARGEST = 500.0  # mm
_DIGITS = 10  # of a clearance in m: parts of a µm, without the rounding of differences
_STEPS = (3, 6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500)  # mm, the end of each range of sizes
_GRADES = {  # the finest serves Δ alone
    4: (3, 4, 4, 5, 6, 7, 8, 10, 12, 14, 16, 18, 20),
    5: (4, 5, 6, 8, 9, 11, 13, 15, 18, 20, 23, 25, 27),
    6: (6, 8, 9, 11, 13, 16, 19, 22, 25, 29, 32, 36, 40),
    7: (10, 12, 15, 18, 21, 25, 30, 35, 40, 46, 52, 57, 63),
    8: (14, 18, 22, 27, 33, 39, 46, 54, 63, 72, 81, 89, 97),
    9: (25, 30, 36, 43, 52, 62, 74, 87, 100, 115, 130, 140, 155),
    10: (40, 48, 58, 70, 84, 100, 120, 140, 160, 185, 210, 230, 250),
    11: (60, 75, 90, 110, 130, 160, 190, 220, 250, 290, 320, 360, 400),
    12: (100, 120, 150, 180, 210, 250, 300, 350, 400, 460, 520, 570, 630),
    13: (140, 180, 220, 270, 330, 390, 460, 540, 630, 720, 810, 890, 970),
}
# c has ranges of its own: their ends, mm
_FINER = tuple(sorted({*_STEPS, 40, 65, 100, 140, 160, 200, 225, 280, 355, 450}))
_C = (60, 70, 80, 95, 110, 120, 130, 140, 150, 170, 180, 200, 210, 230, 240, 260, 280, 300, 330, 360, 400)
_BELOW = {  # how far the upper limit of a shaft lies below the nominal size
    "c": (*_C, 440, 480),
    "d": (20, 30, 40, 50, 65, 80, 100, 120, 145, 170, 190, 210, 230),
    "e": (14, 20, 25, 32, 40, 50, 60, 72, 85, 100, 110, 125, 135),
    "f": (6, 10, 13, 16, 20, 25, 30, 36, 43, 50, 56, 62, 68),
    "g": (2, 4, 5, 6, 7, 9, 10, 12, 14, 15, 17, 18, 20),
    "h": (0,) * 13,
}
_ABOVE = {  # how far the lower limit of a shaft lies above it; of k in grades 4 to 7
    "k": (0, 1, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5),
    "m": (2, 4, 6, 7, 8, 9, 11, 13, 15, 17, 20, 21, 23),
    "n": (4, 8, 10, 12, 15, 17, 20, 23, 27, 31, 34, 37, 40),
    "p": (6, 12, 15, 18, 22, 26, 32, 37, 43, 50, 56, 62, 68),
}
_LETTERS = (*_BELOW, "js", *_ABOVE)
_WITH_DELTA = {"K": 8, "M": 8, "N": 8, "P": 7}  # up to which grade
_WRITTEN = re.compile(r"([A-Z]{1,2})(\d{1,2})/([a-z]{1,2})(\d{1,2})")
ACCEPTED = (
    "a fit of ISO 286 such as 'H7/f7' is accepted: "
    f"a hole of {', '.join(each.upper() for each in _LETTERS)} and a shaft of {', '.join(_LETTERS)}, "
    "grades 5 to 13 (K to 8)"
)


@dataclass(frozen=True)
class Fit:
    """A fit at a nominal size: limits in m.

    Parameters
    ----------
    name : str
        As ``H7/f7``.
    diameter : float
        Nominal size, m.
    hole, shaft : tuple of float, shape (2,)
        Lower and upper deviation of each diameter from it, m.
    """

    name: str
    diameter: float
    hole: tuple[float, float]
    shaft: tuple[float, float]

    @property
    def least(self) -> float:
        """Least radial clearance, m; negative: the largest shaft is larger than the smallest hole."""
        return round((self.hole[0] - self.shaft[1]) / 2, _DIGITS)

    @property
    def most(self) -> float:
        """Largest radial clearance, m."""
        return round((self.hole[1] - self.shaft[0]) / 2, _DIGITS)

    @property
    def clearance(self) -> float:
        """Radial clearance in the middle between least and largest, m."""
        return round((self.least + self.most) / 2, _DIGITS)

    def __str__(self) -> str:
        low, high = 2e6 * self.least, 2e6 * self.most
        return f"{self.name} at {1e3 * self.diameter:g} mm: diameters differ by {low:g} to {high:g} µm"


def deviations(letter: str, grade: int, size: float) -> tuple[float, float]:
    """Lower and upper deviation of a tolerance class at a nominal size in mm, in µm.

    Parameters
    ----------
    letter : str
        As ``H`` of a hole, ``f`` of a shaft.
    grade : int
        As 7 of IT7.
    size : float
        Nominal size, mm.
    """
    step, small = bisect_left(_STEPS, size), letter.lower()
    width = _GRADES[grade][step]
    if small == "js":
        return -width / 2, width / 2
    if small in _BELOW:
        off = _BELOW[small][bisect_left(_FINER, size) if small == "c" else step]
        return (-off - width, -off) if letter == small else (off, off + width)
    off = _ABOVE[small][step]
    if letter == small:
        low = off if small != "k" or grade <= 7 else 0
        return low, low + width
    if (letter, grade) == ("M", 6) and 250 < size <= 315:
        return -9 - width, -9
    delta = width - _GRADES[grade - 1][step] if size > 3 else 0
    high = delta - off if grade <= _WITH_DELTA[letter] else 0 if letter == "N" and size > 3 else -off
    return high - width, high


def _known(letter: str, grade: int) -> bool:
    return letter.lower() in _LETTERS and 5 <= grade <= (8 if letter == "K" else 13)


@checked()
def fit(
    name: Annotated[Name, accepts("a fit such as 'H7/f7'")],
    diameter: Annotated[Positive, unit("diameter", "m")],
) -> Fit:
    """Give the limits and the clearance of a fit of ISO 286 at a nominal diameter.

    Parameters
    ----------
    name : str
        Hole and shaft, as ``H7/f7``: letters c to p, grades 5 to 13.
    diameter : float
        Nominal diameter of pin and hole, up to 0.5 m.

    Returns
    -------
    Fit
        With ``clearance``, ``least`` and ``most``, all radial, m: half the difference of the diameters.

    Raises
    ------
    InputError
        Where ISO 286 has no such fit, or it leaves no clearance on average.
    """
    return limits(name, diameter, "name")


def limits(name: str, diameter: float, key: str = "") -> Fit:
    """The same for a record, which names the key of the fit."""
    found, size = _WRITTEN.fullmatch(name.replace(" ", "")), round(1e3 * diameter, 9)
    classes = [(found[1], int(found[2])), (found[3], int(found[4]))] if found else []
    if not classes or not all(_known(*each) for each in classes):
        raise refuse(name, ACCEPTED, key)
    if size > LARGEST:
        text = f"a diameter up to {LARGEST:g} mm is accepted with a fit, and this is {size:g} mm"
        raise refuse(diameter, text, "diameter")
    hole, shaft = (tuple(each / 1e6 for each in deviations(*one, size)) for one in classes)
    made = Fit("/".join(f"{letter}{grade}" for letter, grade in classes), diameter, hole, shaft)
    if not made.clearance > 0:
        raise refuse(
            name, f"a fit with clearance, such as 'H7/f7', is accepted; {made}: negative is interference", key
        )
    return made
