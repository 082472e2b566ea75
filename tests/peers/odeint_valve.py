"""The relief valve followed by Boost odeint (relief_valve.cpp), compiled where there is a compiler."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path

SOURCE = Path(__file__).with_name("relief_valve.cpp")
STEPPERS = ("dopri5", "bulirsch_stoer")


@dataclass(frozen=True)
class Run:
    """Section points, CPU seconds, impacts, and the last section point (time, lift, pressure)."""

    points: int
    seconds: float
    impacts: int
    last: tuple[float, float, float]


def compiled(folder: Path) -> Path | None:
    """The program, compiled into a folder; None where compiler or Boost are missing."""
    program = folder / "relief_valve"
    command = ["g++", "-O3", "-march=native", "-std=c++17", str(SOURCE), "-o", str(program)]
    try:
        done = subprocess.run(command, capture_output=True, check=False)
    except FileNotFoundError:
        return None
    return None if done.returncode else program


def follow(program: Path, stepper: str, rtol: float, duration: float, flow: float) -> Run:
    """Follow the valve from the catalog's start."""
    command = [str(program), stepper, str(rtol), str(duration), str(flow)]
    words = subprocess.run(command, capture_output=True, check=True, text=True).stdout.split()
    time, lift, pressure = map(float, words[3:])
    return Run(int(words[0]), float(words[1]), int(words[2]), (time, lift, pressure))
