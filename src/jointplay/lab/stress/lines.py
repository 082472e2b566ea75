"""A scene as a study file: the lines that run it again by itself, as time histories."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from jointplay.lab.stress.scenes import Case

RECORD = ("mode", "penetration", "normal_velocity", "tangential_velocity", "normal_force", "energy_residual")


def lines(case: Case, seed: int, turns: int, rtol: float, max_steps: int) -> str:
    """Write a study of kind ``response`` that follows a scene as the stress study did.

    Parameters
    ----------
    case : Case
        The scene.
    seed, turns, rtol, max_steps
        Of the stress study.

    Returns
    -------
    str
        TOML.
    """
    record = case.mechanism.model_dump(exclude_none=True)
    title = f"Scene {case.number} of seed {seed}: {case.variant}, {case.geometry}, {case.start}"
    parts = [_table("", {"kind": "response", "title": title})]
    parts.append(_table("[mechanism]", {k: v for k, v in record.items() if not isinstance(v, tuple | dict)}))
    parts += [_table(f"[[mechanism.{key}]]", one) for key in ("links", "joints") for one in record[key]]
    parts.append(_table("[mechanism.drive]", record["drive"]))
    parts.append(_table("[integrator]", {"rtol": rtol, "max_steps": max_steps}))
    parts.append(_table("[analysis]", {"turns": turns, "record": RECORD, "initial": case.initial}))
    return "\n".join(parts)


def _table(head: str, values: Mapping[str, Any]) -> str:
    return "".join(f"{line}\n" for line in ([head] if head else []) + list(_pairs(values)))


def _pairs(values: Mapping[str, Any]) -> Iterator[str]:
    return (f"{key} = {_value(value)}" for key, value in values.items())


def _value(value: Any) -> str:
    if isinstance(value, Mapping):
        return f"{{ {', '.join(_pairs(value))} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value) if isinstance(value, float) else json.dumps(value)  # both as TOML writes them
