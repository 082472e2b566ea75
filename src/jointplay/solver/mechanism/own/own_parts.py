"""Parts of systems of somebody's own equations: contacts, friction, switches, walls and jumps.

Expressions are text of a small grammar (`jointplay.solver.equations.own.grammar`), or expressions of SymPy.
"""

from __future__ import annotations

import sys
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from jointplay.solver.mechanism.base import Flag, Name, Record, accepts, named


def written(given: Any) -> Any:
    """A number, or an expression of SymPy, as text; all else stays as it is."""
    if type(given).__module__.partition(".")[0] == "sympy":
        from jointplay.solver.equations.own.own import as_text

        return as_text(given)
    plain = isinstance(given, int | float) and not isinstance(given, bool)
    return repr(given) if plain and abs(given) <= sys.float_info.max else given


Text = Annotated[
    str,
    BeforeValidator(written, json_schema_input_type=str | float),
    accepts("an expression, as text or of SymPy,"),
]


class Touch(Record):
    """A contact that a force pushes apart where ``depth`` is above zero.

    Parameters
    ----------
    name : str
        Its name.
    depth : str
        Penetration, of positions; below zero the contact is open.
    force : str
        Normal force, with the names ``depth`` and ``speed`` (the depth's rate); it acts against the depth.
    tension : bool or str
        False: contact ends where the force reaches zero; the name of a parameter that is true or false.
    """

    name: Name = named("name of the contact")
    depth: Text
    force: Text
    tension: Flag | Name = True


class Rubbing(Record):
    """Dry friction with true sticking.

    Parameters
    ----------
    name : str
        Its name.
    speed : str
        Sliding speed, against whose slopes by the speeds the friction acts.
    normal : str
        Normal force.
    coefficient : str
        Friction coefficient while it slides, which may depend on ``speed``.
    static : str, optional
        Coefficient up to which it sticks; that of sliding if left out.
    """

    name: Name = named("name of the friction")
    speed: Text
    normal: Text
    coefficient: Text
    static: Text | None = None


class Switch(Record):
    """A number, 0 or 1, in the equations: 1 from where ``on`` rises through zero until ``off`` does.

    With both it is a state too, which begins at 1 where ``off`` is not above zero, unless it is given.

    Parameters
    ----------
    name : str
        Its name in the equations.
    on : str
        Guard that rises through zero where the switch goes to 1.
    off : str, optional
        Guard that rises through zero where it goes to 0; where ``on`` falls if left out.
    slides : bool
        Whether it lies between 0 and 1, such that ``on`` stays zero, where both modes lead back to that
        (Filippov's motion); rates are straight in it, and nothing else depends on it.
    """

    name: Name = named("name of the switch")
    on: Text
    off: Text | None = None
    slides: Flag = False


class Exit(Record):
    """A way out of a mode, where ``guard`` falls through zero.

    Parameters
    ----------
    to : str
        The mode that follows.
    guard : str
        Above zero while the mode lasts.
    jump : dict of str to str
        New values of states, of the old ones; the others go on.
    """

    to: Name
    guard: Text
    jump: dict[Name, Text] = Field(default={})


class Impact(Record):
    """A rigid wall, on which a body can come to rest.

    Parameters
    ----------
    name : str
        Its name.
    gap : str
        Of positions and time; above zero where the wall is not touched.
    restitution : str, optional
        Newton's: the gap opens so many times as fast as it closed.
    jump : dict of str to str
        In the place of a restitution: new values of speeds.
    """

    name: Name = named("name of the wall")
    gap: Text
    restitution: Text | None = None
    jump: dict[Name, Text] = Field(default={})


class Jump(Record):
    """A jump of the state where ``guard`` falls through zero.

    Parameters
    ----------
    name : str
        Its name.
    guard : str
        Above zero before the jump, and after it.
    jump : dict of str to str
        New values of states, of the old ones.
    """

    name: Name = named("name of the jump")
    guard: Text
    jump: dict[Name, Text]
