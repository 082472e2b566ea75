"""Codes of modes, events and statuses: numbers in kernels and records, words in datasets.

Kernels take them as plain integers, since a member would be a type of its own to compile for: `numbers` gives
these where a kernel's module is read.
"""

from enum import IntEnum


class Code(IntEnum):
    """A number and the word for it, which is its name in small letters."""

    @property
    def word(self) -> str:
        """The word for it."""
        return self.name.lower()

    @classmethod
    def words(cls) -> tuple[str, ...]:
        """The words of all codes, in order from 0 on."""
        return tuple(code.word for code in cls)

    @classmethod
    def numbers(cls) -> tuple[int, ...]:
        """All codes as plain integers."""
        return tuple(map(int, cls))


class Mode(Code):
    """Mode of a contact; of a rigid wall FREE or REST."""

    FREE = 0
    RELEASED = 1  # the gap is closed, and the force gone: of laws that do not pull
    SLIP_POSITIVE = 2
    SLIP_NEGATIVE = 3
    STICK = 4
    CONTACT = 5  # without Coulomb friction
    REST = 6  # on a rigid wall


class Variant(Code):
    """Form of a structure's equations: no contact touches, none sticks, or one does."""

    FREE = 0
    SLIP = 1
    STICK = 2


class Event(Code):
    """Kind of event, where a guard leaves its side."""

    CONTACT = 0
    SEPARATION = 1
    REOPENING = 2  # of a gap whose force had gone before
    SLIP_REVERSAL = 3
    STICK_ONSET = 4
    SLIP_ONSET = 5
    IMPACT = 6
    REST = 7


class Section(Code):
    """Kind of section of a run: none, a level of a quantity, events of one kind."""

    NONE = 0
    LEVEL = 1
    EVENT = 2


class Row(Code):
    """Kind of log row: a step, an event, a section point, a closest approach, a coarse step."""

    STEP = 0
    EVENT = 1
    SECTION = 2
    MISS = 3
    COARSE = 4


class Status(Code):
    """End of a run: its `meaning` in a sentence, and a `remedy` to try."""

    meaning: str
    remedy: str

    def __new__(cls, number: int, meaning: str, remedy: str):
        """Make a member of its number and sentences."""
        made = int.__new__(cls, number)
        made._value_, made.meaning, made.remedy = number, meaning, remedy
        return made

    OK = 0, "it came to its end", "nothing"
    DIVERGED = (
        1,
        "the motion grew without bound",
        "check the initial state, the masses and the contact stiffness; try a smaller integrator.rtol",
    )
    STEP_LIMIT = (
        2,
        "the limit on the number of steps was reached",
        "raise integrator.max_steps, ask for fewer turns, or loosen integrator.rtol",
    )
    CHATTER = (
        3,
        "events followed each other too closely to be told apart",
        "try a smaller integrator.rtol, or give the contact more damping",
    )
    NOT_CONVERGED = (
        4,
        "a step could not be solved to the tolerance, however short",
        "loosen integrator.rtol; check that masses, inertias and stiffnesses are of a sensible size",
    )
    BAD_PARAMETERS = (
        5,
        "these parameters give no finite accelerations at the start",
        "check masses, inertias, lengths and the initial state",
    )
    CRASHED = (
        6,
        "the computation stopped before it could answer",
        "run it again; please report it if it repeats",
    )
    NOT_RUN = 7, "nothing was computed", "run the study"
    INTERRUPTED = 8, "it was stopped before its end", "run it again; this is what was computed up to there"
    NO_DERIVATIVE = (
        9,
        "no derivative: rigid faces met at once, a restitution was lowered, or a jump ended beyond a guard",
        "start tilted a little, give faces a stiffness, end jumps within guards, or ask for the motion alone",
    )
    JAMMED = (
        10,
        "rigid contacts had no answer: more than six met at once, or friction wedged one",
        "give some of these contacts a law with stiffness, or a smaller friction coefficient",
    )


COUNTERS = {  # of a run, in order
    "n_steps": "accepted steps",
    "n_rejected": "rejected steps",
    "n_failed": "steps that did not converge",
    "n_evaluations": "evaluations of the accelerations",
    "n_events": "events",
}
