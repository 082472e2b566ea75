"""Names of the quantities and parameters of derivatives and their checks; derivatives of multipliers.

A multiplier mu is an eigenvalue of DP, the derivative of a section map at its fixed point x, which moves by
dx/dp = (I - DP)^-1 dP/dp (analysis.orbits.section_map). With both eigenvectors, DP v = mu v, w^H DP = mu w^H,

    dmu/dp = w^H (dDP/dp) v / (w^H v),    d(ln|mu|/T)/dp = Re(mu'/mu)/T - ln|mu| T'/T^2.

dDP/dp has second derivatives of the flow in it. It is the central difference of sixth order
(directions.slope) of DP, which is exact, along the tangent to the orbits, (x + h dx/dp, p + h); so is T'. Of
several steps h, each a third of the one before, that is taken whose quotient differs least from the one
before: by the error that is told. Validity: simple multipliers. Equal ones, as where a pair meets the real
axis, have no derivative; that of |mu| at 0 is one-sided. Reference: Magnus, Econometric Theory 1 (1985)
179-191.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from jointplay.analysis.orbits.family import map_derivative
from jointplay.analysis.orbits.section_map import SectionMap
from jointplay.analysis.orbits.shooting import Orbit, descending, exponents
from jointplay.analysis.quantities import BALANCE, WORDS, WORK, owners
from jointplay.display.errors import NOTHING, InputError, Problem, strangers, unknown, with_keys
from jointplay.solver.mechanism.directions import AT_ZERO, SIDES, slope
from jointplay.solver.mechanism.parameters import EXAMPLE, INITIAL, NAMED, Parameter
from jointplay.solver.mechanism.paths import parts_of
from jointplay.solver.mechanism.records import Mechanism, TestSystem
from jointplay.solver.method.codes import Status

T = TypeVar("T", bound=Any)
POINTS = ("end", "largest", "smallest")
DISCRETE = ("mode", "contact_angle", *BALANCE, "energy", "state_value")

MULTIPLIERS = {  # what is asked of one, by its number: units
    "multiplier": "1",
    "multiplier_imaginary": "1",
    "multiplier_modulus": "1",
    "exponent": "s-1",
}
LONGEST, SHORTER, STEPS = 2e-2, 1 / 3, 7  # first step, of the parameter; the next in each; how many
SHARPER, FINEST = 1e-2, 1e-13  # tolerance of the runs in that of the orbit's; the least
NEUTRAL = 1e-9  # distance of a multiplier from 1 that is rounding
GROWN = 10.0  # errors, in the least of longer steps, at which no shorter one is tried


def reached(found: T) -> T:
    """The motion that was followed; `ArithmeticError` with its status where that did not get to its end."""
    if found.status:
        raise ArithmeticError(found.status)
    return found


class Neutral(ArithmeticError):
    """An orbit that lies in a family of orbits: which of them a parameter leads to, nothing says."""


def moves_of(image: Any) -> np.ndarray:
    """Derivative of a fixed point, dx/dp = (I - DP)^-1 dP/dp; `Neutral` where there is none."""
    if np.min(np.abs(np.linalg.eigvals(image.derivative) - 1), initial=1.0) < NEUTRAL:
        raise Neutral(int(Status.NOT_CONVERGED))
    return np.linalg.solve(np.eye(len(image.derivative)) - image.derivative, image.along)


@dataclass(frozen=True)
class Quantity:
    """A number of a motion: ``end:angle:rocker``, ``largest:normal_force:B``, ``work:drive``, ``time``.

    Parameters
    ----------
    name : str
        As it was asked for.
    how : str
        Its first word.
    key : str
        Of what is looked at, as the equations call it; of a work, its name.
    units : str
        As in a dataset.
    """

    name: str
    how: str
    key: str
    units: str

    @property
    def noun(self) -> str:
        """Its name, as ``largest normal contact force, B`` or ``work of the drive``."""
        word, _, label = self.key.partition(":")
        if self.how not in POINTS:
            return " ".join(
                [self.how.replace("_", " "), *["of the"] * (self.how == "work"), self.key]
            ).strip()
        what = WORDS[word].long_name if word in WORDS else "state"
        what = f"{what} at the end" if self.how == "end" else f"{self.how} {what}"
        return f"{what}, {label}" if label else what


def quantity(name: str) -> Quantity:
    """The quantity of this name, which is a right one."""
    how, _, key = name.partition(":")
    units = {"time": "s", "work": "J"} | MULTIPLIERS
    word = WORDS.get(key.partition(":")[0])
    return Quantity(name, how, key, units.get(how) or (word.units if word else "1"))


def known_quantities(mechanism: Mechanism | TestSystem, orbit: bool = False) -> list[str]:
    """Names of all quantities of a mechanism, and of the multipliers of a periodic orbit."""
    from jointplay.analysis.starts import crank_place, state_names
    from jointplay.solver.mechanism.assemble import assemble

    model = assemble(mechanism)
    states = state_names(model)
    fixed = (isinstance(mechanism, TestSystem) and mechanism.period is None) or crank_place(model) is not None
    numbers = range(1, 1 + len(states) - fixed) if orbit else ()
    of_orbit = [f"{word}:{number}" for word in MULTIPLIERS for number in numbers]
    if isinstance(mechanism, TestSystem):
        keys = [f"state:{name}" for name in states]
        return [f"{how}:{key}" for how in POINTS for key in keys] + ["time", *of_orbit]
    labels = owners(mechanism)
    words = [name for name in WORDS if name not in DISCRETE]
    keys = [f"{name}:{label}".rstrip(":") for name in words for label in labels[WORDS[name].of]]
    works = [word for word, there in _works(mechanism).items() if there]
    return [f"{how}:{key}" for how in POINTS for key in keys] + [
        "time",
        *(f"work:{word}" for word in works),
        *of_orbit,
    ]


def _works(mechanism: Mechanism) -> dict[str, bool]:
    """Names of all works, and whether the mechanism has each."""
    parts = {"links": mechanism.elastic_links, "springs": mechanism.springs, "loads": mechanism.loads}
    return {word: bool(parts.get(word, True)) for word in WORK}


def _rigid(joint) -> bool:
    from jointplay.solver.equations.laws import LAWS

    return LAWS[joint.contact.law].rigid


def usual_quantities(mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Quantities that are differentiated by default."""
    if isinstance(mechanism, TestSystem):
        return tuple(name for name in known_quantities(mechanism) if name.startswith("end:"))
    soft = [name for joint in mechanism.clearance_joints if not _rigid(joint) for name in joint.contacts]
    return (*(f"largest:normal_force:{name}" for name in soft), "work:drive", "time")


def largest_forces(mechanism: Mechanism | TestSystem) -> dict[str, str]:
    """Quantities of the largest force by joint, those that bear on their contacts first."""
    names = () if isinstance(mechanism, TestSystem) else known_quantities(mechanism)
    heads = ("largest:normal_force:", "largest:reaction:")
    rigid = {} if not names else {n for j in mechanism.clearance_joints if _rigid(j) for n in j.contacts}
    found = {n.rpartition(":")[2]: n for head in heads for n in names if n.startswith(head)}
    return {joint: name for joint, name in found.items() if joint not in rigid}


def usual_parameters(mechanism: Mechanism | TestSystem) -> tuple[str, ...]:
    """Default parameters: joints' clearances and contacts, friction, links' masses, the drive."""
    if isinstance(mechanism, TestSystem):
        return tuple(each.key for each in Parameter.of(mechanism))
    keys = []
    for joint in mechanism.clearance_joints:
        keys += [f"joints.{joint.name}.clearance"]
        keys += [f"joints.{joint.name}.contact.{word}" for word in ("stiffness", "damping")]
        keys += [f"joints.{joint.name}.friction.coefficient"]
    keys += [f"links.{link.name}.mass" for link in mechanism.links] + ["gear_ratio", "speed"]
    return tuple(key for key in keys if Parameter(mechanism, key).value)


def quantities_fit(
    mechanism: Mechanism | TestSystem, of: tuple[str, ...] | None, orbit: bool
) -> Iterator[Problem]:
    """Yield the problems of quantities that the mechanism has not."""
    known = known_quantities(mechanism, orbit) if of else ()
    return strangers(with_keys("of", of), known, "quantity")


def parameters_fit(
    mechanism: Mechanism | TestSystem, by: tuple[str, ...] | None, states: tuple[str, ...]
) -> Iterator[Problem]:
    """Yield the problems of parameters that the mechanism has not, or whose value is no number."""
    for i, key in enumerate(by or ()):
        place = f"by[{i}]"
        if key.startswith(INITIAL):
            name = key.removeprefix(INITIAL)
            if name not in states:
                yield unknown(place, key, name, states, "state")
            continue
        wrong = [problem for part in parts_of(key) for problem in _part_fits(mechanism, part, place)]
        yield from wrong
        if not wrong and not Parameter(mechanism, key).uniform:
            accepted = f"a parameter that has a single value here, or a path such as {EXAMPLE}, is accepted"
            yield Problem(place, key, accepted)


def _part_fits(mechanism: Mechanism | TestSystem, key: str, place: str) -> Iterator[Problem]:
    try:
        parameter = Parameter.named(mechanism, key, place)
    except InputError as error:
        yield from (replace(problem, given=key) for problem in error.problems)
        return
    if not parameter.smooth:
        also = f", one of {', '.join(NAMED)} or a path," if isinstance(mechanism, Mechanism) else ""
        given = NOTHING if parameter.value is None else parameter.value
        yield Problem(place, key, f"a parameter that has a value here{also} is accepted, not {given!r}")


class Change(NamedTuple):
    """Derivatives of DP and of the duration T in a parameter, and their errors."""

    DP: np.ndarray
    T: float
    DP_error: np.ndarray
    T_error: float


def change(orbit: Orbit, maps: Callable[[float], SectionMap], value: float, key: str) -> Change:
    """Derivatives of DP and of the duration of periodic orbits in a parameter.

    Parameters
    ----------
    orbit : Orbit
        At the parameter's value.
    maps : callable
        A map of the section at a value of the parameter.
    value : float
        Where.
    key : str
        Name of the parameter in messages.

    Raises
    ------
    ArithmeticError
        With the status, if the orbit could not be followed.
    """
    like = replace(orbit.map, rtol=max(SHARPER * orbit.map.rtol, FINEST), units=orbit.map.scale)

    def at(p: float) -> SectionMap:
        return replace(like, model=maps(p).model)

    here = reached(map_derivative(at, value, orbit.state, key=key))
    moves = moves_of(here)[:, 0]
    x = like.unknowns(orbit.state)

    def listed(p: float) -> np.ndarray:
        image = at(p).image(like.state(x + (p - value) * moves))
        if image.status:
            return np.full(moves.size**2 + 1, np.nan)
        return np.append(image.derivative, image.time)

    found, error = _differentiated(listed, value)
    return Change(
        found[:-1].reshape(here.derivative.shape),
        found[-1],
        error[:-1].reshape(here.derivative.shape),
        error[-1],
    )


def _differentiated(listed: Callable[[float], np.ndarray], value: float) -> tuple[np.ndarray, np.ndarray]:
    """Quotient with the best of several steps, and its error; none is tried beyond where errors grow."""
    step = LONGEST * abs(value) or AT_ZERO
    about = listed(value), SIDES[:1]
    before, best, least = slope(listed, value, step, *about), (), np.inf
    for i in range(1, STEPS):
        now = slope(listed, value, step * SHORTER**i, *about)
        error = np.nan_to_num(np.abs(now - before), nan=np.inf)
        size = float(error[:-1].max())
        if not best or size < least:
            best, least = (now, error), size
        elif size > GROWN * least:
            break
        before = now
    return best


def derivatives(
    orbit: Orbit, changes: Sequence[Change], multipliers: Sequence[tuple[str, int]]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, bool]:
    """Numbers of multipliers, their derivatives and errors; whether a wanted one is not simple.

    Parameters
    ----------
    orbit : Orbit
        Whose multipliers.
    changes : sequence of Change
        Of each parameter.
    multipliers : sequence of (str, int)
        Word of `MULTIPLIERS`, and number of the multiplier, counted from 1 as the largest.
    """
    from scipy.linalg import eig  # takes long to import, and names are checked without

    mu, left, right = eig(orbit.image.derivative, left=True, right=True)
    order, T = descending(mu), orbit.image.time
    mu, left, right = mu[order], left[:, order], right[:, order]
    across = np.einsum("ij,ij->j", left.conj(), right)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes, errors = (
            np.array([np.einsum("ij,ik,kj->j", w, each, v) / over for each in parts])
            for w, v, over, parts in (
                (left.conj(), right, across, [each.DP for each in changes]),
                (np.abs(left), np.abs(right), np.abs(across), [each.DP_error for each in changes]),
            )
        )
        size = np.abs(mu)
        turned = slopes * np.exp(-1j * np.angle(mu))  # real part: along the multiplier
        rate, times = exponents(mu, T), np.array([[each.T, each.T_error] for each in changes])
        parts = {
            "multiplier": (mu.real, slopes.real, errors),
            "multiplier_imaginary": (mu.imag, slopes.imag, errors),
            "multiplier_modulus": (size, np.where(size > 0, turned.real, np.abs(slopes)), errors),
            "exponent": (
                rate,
                turned.real / size / T - rate * times[:, :1] / T,
                errors / size / T + np.abs(rate) * times[:, 1:] / T,
            ),
        }
    columns = [tuple(part[..., number - 1] for part in parts[word]) for word, number in multipliers]
    values, found, error = (np.array(each) for each in zip(*columns, strict=True))
    # an error of DP parts two equal ones, and both their eigenvectors, by its root
    simple = all(abs(across[number - 1]) > np.sqrt(orbit.map.rtol) for _, number in multipliers)
    return values, found, error, not simple
