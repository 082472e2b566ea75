"""Parts of a linkage: the plan from which its equations are written.

A structure holds no numbers; every number it needs is a parameter named here in one place, so that a sweep
over numbers changes no equation. Cut at every clearance joint, a linkage is a forest of open chains. No SymPy
here: a structure whose equations have been written before needs none.
"""

from dataclasses import dataclass

from .friction import FRICTIONS
from .laws import LAWS
from .own.written import Oscillator

# Corners of a slider in its guide: +1 ahead of the journal's point or -1, on the upper face +1 or -1.
CORNERS = {"upper_front": (1, 1), "upper_rear": (-1, 1), "lower_front": (1, -1), "lower_rear": (-1, -1)}


@dataclass(frozen=True)
class Clearance:
    """A joint with play: the links of journal and bearing ("ground" if fixed), and the terms of its vector r.

    `arms` are the links whose e_k enters r = const + sum_k D_k e_k; `bases` the floating chains whose base
    point enters, as (chain, sign). `ends` are the ends ("start", "end") at which journal and bearing sit.
    Of a prismatic joint each `corner` of the slider is one of these, with the numbers of its `joint`.
    """

    name: str
    journal: str
    bearing: str
    arms: tuple[str, ...]
    bases: tuple[tuple[int, int], ...] = ()
    law: str = "kelvin_voigt"
    tension: bool = True
    friction: str = "none"
    viscous: bool = False
    ends: tuple[str, str] = ("", "")
    joint: str = ""
    corner: tuple[int, int] | None = None

    @property
    def owner(self) -> str:
        """The joint by whose name its numbers are called."""
        return self.joint or self.name

    @property
    def face(self) -> str:
        """Common name of the corners on one face of a guide; empty of a bearing."""
        return f"{self.owner} {self.corner[1]}" if self.corner else ""

    @property
    def sizes(self) -> tuple[str, ...]:
        """Letters of its sizes: clearance; journal's radius, or directions and half sizes of a slider."""
        return ("e", "dc", "ds", "jc", "js", "ha", "hb") if self.corner else ("e", "R")

    @property
    def remembers(self) -> bool:
        """Whether its law remembers the speed with which a contact began."""
        return bool(LAWS[self.law].floor)

    @property
    def bends(self) -> bool:
        """Whether its law of friction has bristles, whose deflection is a state."""
        return self.friction in FRICTIONS and FRICTIONS[self.friction].bristles is not None

    @property
    def falls(self) -> bool:
        """Whether its friction falls with the sliding speed somewhere, and may excite vibrations."""
        return self.friction in FRICTIONS and not FRICTIONS[self.friction].rises

    @property
    def rough(self) -> bool:
        """Whether slopes of its forces are not smooth within contact, or up to its beginning and end."""
        return (self.friction in FRICTIONS and FRICTIONS[self.friction].kinks) or not LAWS[self.law].smooth


@dataclass(frozen=True)
class Beam:
    """An elastic link: its number of modes, and the links (`arms`) or floating chain that move its origin.

    `modes` are those across; `axial` more stretch it, and move its far end along (equations.stretch).
    """

    link: str
    modes: int
    arms: tuple[str, ...]
    chain: int | None
    damped: bool
    axial: int = 0

    @property
    def stretches(self) -> list[tuple[None, str, int]]:
        """Its modes along, among the freedoms."""
        return [(None, self.link, a) for a in range(self.axial)]


@dataclass(frozen=True)
class Slide:
    """An ideal prismatic joint in a chain: `link` roots a chain of its own, whose base runs along `guide`.

    base = r0 + sum_k D_k e_k (k in `arms`, from the base of chain `inner`, or a fixed point) + sign s d, with
    d along the guide, which turns with the link `guide` ("ground": not at all).
    """

    name: str
    link: str
    guide: str
    chain: int
    sign: int
    arms: tuple[str, ...]
    inner: int | None = None

    @property
    def freedom(self) -> tuple[None, str]:
        """Its slide s among the freedoms."""
        return None, self.name


@dataclass(frozen=True)
class Closure:
    """An ideal revolute joint at which a loop is cut.

    From bearing to journal 0 = r0 + sum_k D_k e_k + sum_s sign s d; `slides` are (joint, sign). `unknowns`
    are the freedoms that follow from it and from those that close together with it, two of each: angles of
    links by name, slides as (None, joint).
    """

    name: str
    journal: str
    bearing: str
    arms: tuple[str, ...]
    slides: tuple[tuple[str, int], ...]
    unknowns: tuple[str | tuple[None, str], ...]


@dataclass(frozen=True)
class Pin:
    """Ideal joint in a chain: `arms`, `links` move beyond it; `sign` +1: the outer link holds the bearing.

    `bases` are the chains, other than grounded ones, of links beyond it, with the name of their mass there.
    """

    name: str
    sign: int
    arms: tuple[str, ...]
    bases: tuple[tuple[int, str], ...]
    links: tuple[str, ...]


@dataclass(frozen=True)
class Span:
    """A vector const + sum_k D_k e_k + bases: `arms` and `bases` as in `Clearance`, `name` its numbers'."""

    name: str
    arms: tuple[str, ...] = ()
    bases: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True)
class Spring:
    """A spring between two `links` ("ground" if it moves not): along its `span`, or twisting the angles."""

    span: Span
    links: tuple[str, str]
    twists: bool
    damped: bool


@dataclass(frozen=True)
class Course:
    """A value that varies with time (`timed`), with the angle of `link`, or not: orders of harmonics."""

    name: str
    orders: tuple[int, ...] = ()
    timed: bool = False
    link: str = ""


@dataclass(frozen=True)
class Load:
    """A load on `link`: a force on the point of a `span` along a direction that may turn, or a torque."""

    course: Course
    link: str
    span: Span | None = None
    turning: bool = False


@dataclass(frozen=True)
class Linkage:
    """Links, the pairs coupled in the mass matrix, floating chains, joints, drive, and recorded quantities.

    `driven` is the crank; `drive` says how, a key of `equations.drives.DRIVES`; `course` is its own, if
    prescribed, and `fed` what a servo feeds forward: names and expressions, the torque's name empty.
    `section` names a quantity whose level crossings are wanted, as word:label; `powers` asks for the work
    integrals of the energy balance. `order` says which inertia terms of the `beams` are kept, "consistent"
    or "paper" (equations.beam); `relaxed` makes the modes' motion numbers, given from outside.
    `tilted`: gravity does not point along -y.
    """

    links: tuple[str, ...]
    couplings: tuple[tuple[str, str], ...]
    floats: tuple[tuple[str, ...], ...]
    joints: tuple[Clearance, ...]
    pins: tuple[Pin, ...]
    driven: str
    drive: str
    gravity: bool
    section: str | None = None
    powers: bool = False
    beams: tuple[Beam, ...] = ()
    slides: tuple[Slide, ...] = ()
    closures: tuple[Closure, ...] = ()
    order: str = "consistent"
    relaxed: bool = False
    tilted: bool = False
    springs: tuple[Spring, ...] = ()
    loads: tuple[Load, ...] = ()
    course: Course | None = None
    fed: tuple[tuple[str, str], ...] = ()

    @property
    def soft_joints(self) -> tuple[Clearance, ...]:
        """Joints with play whose law gives a force."""
        return tuple(joint for joint in self.joints if not LAWS[joint.law].rigid)

    @property
    def rigid_joints(self) -> tuple[Clearance, ...]:
        """Joints with play whose law is an impact's; they come after the others."""
        return tuple(joint for joint in self.joints if LAWS[joint.law].rigid)

    @property
    def loops(self) -> tuple[tuple[Closure, ...], ...]:
        """Groups of closures that determine unknowns together: one of a dyad, several of a larger group."""
        found = dict.fromkeys(closure.unknowns for closure in self.closures)
        return tuple(tuple(each for each in self.closures if each.unknowns == led) for led in found)

    @property
    def guessed(self) -> tuple[str | tuple[None, str], ...]:
        """Angles and slides of larger groups, of which nearby values are remembered."""
        return tuple(unknown for loop in self.loops if len(loop) > 1 for unknown in loop[0].unknowns)

    @property
    def held(self) -> bool:
        """Whether a prescribed speed is that of an unknown without acceleration: all else may follow it."""
        return self.drive == "speed" and bool(self.closures) and not self.joints

    @property
    def dependent(self) -> set[str | tuple[None, str]]:
        """Angles and slides that follow from the closures, and angles of links on guides."""
        found = {unknown for closure in self.closures for unknown in closure.unknowns}
        return found | {slide.link for slide in self.slides}

    @property
    def floating(self) -> tuple[int, ...]:
        """Chains whose base is free."""
        led = {slide.chain for slide in self.slides}
        return tuple(f for f in range(len(self.floats)) if f not in led)

    def frame(self, link: str) -> str:
        """The link with whose angle a link turns: itself, except on guides."""
        return self._turning(link)[-1]

    def turns_with(self, link: str, other: str) -> bool:
        """Whether a link turns with another: it is that, or on a guide that turns with it."""
        return other in self._turning(link)

    def _turning(self, link: str) -> list[str]:
        guides, found = {slide.link: slide.guide for slide in self.slides}, [link]
        while found[-1] in guides:
            found.append(guides[found[-1]])
        return found


def powers(structure: Linkage | Oscillator) -> list[str]:
    """Name the powers whose integrals close a linkage's energy balance, in order."""
    if isinstance(structure, Oscillator):
        return []
    present = {"links": structure.beams, "springs": structure.springs, "loads": structure.loads}
    return ["drive", "joints", *(word for word, parts in present.items() if parts)]
