"""Tests in processes that may run without end or eat all memory.

They are forked from one that has imported what all of them need, but nothing of the package: importing that
takes longer than most tests.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import resource
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

MEMORY = 8 * 2**30  # bytes a process
IMPORTED = [
    *("pytest", "hypothesis", "numpy", "scipy.integrate", "scipy.interpolate", "scipy.optimize", "numba"),
    *("sympy", "xarray", "netCDF4", "joblib", "pydantic", "jsonschema", "matplotlib.pyplot"),
]
_start = multiprocessing.get_context("forkserver")
_start.set_forkserver_preload(IMPORTED)


def call(command: list[str], folder: Path, told: dict[str, str]) -> None:
    """Run a command in a folder and let it speak for itself."""
    subprocess.run(command, cwd=folder, env=told, check=False)


def tested(options: list[str], folder: Path, told: dict[str, str], limit: float) -> tuple[int | None, str]:
    """Exit code of pytest, None where the limit in seconds was reached, and output; nothing of it runs on."""
    output = Path(told["TMPDIR"]) / "output"
    child = _start.Process(target=_test, args=(options, folder, told, output))
    child.start()
    child.join(limit)
    code = child.exitcode
    _end(child.pid)
    child.join()
    _end_strays(told["TMPDIR"])
    return code, output.read_text(errors="replace") if output.exists() else ""


def _test(options, folder, told, output):
    os.setsid()
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    written = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    os.dup2(written, 1)
    os.dup2(written, 2)
    os.environ.clear()
    os.environ.update(told)
    os.chdir(folder)
    tempfile.tempdir, sys.dont_write_bytecode = None, False
    sys.path[:0] = [str(folder), told["PYTHONPATH"]]
    for name in [name for name in sys.modules if name.partition(".")[0] in ("tests", "jointplay")]:
        del sys.modules[name]
    import numba
    import pytest

    numba.core.config.reload_config()
    code = int(pytest.main(options))
    sys.stdout.flush()
    os._exit(code)  # a usual exit would wait for worker processes that tests have left behind


def _end_strays(place: str) -> None:
    """End what has left its group, as workers of a cluster do: known by the folder for temporary files."""
    for entry in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            if f"TMPDIR={place}".encode() in (entry / "environ").read_bytes().split(b"\0"):
                os.kill(int(entry.name), signal.SIGKILL)


def _end(group: int) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(group, signal.SIGKILL)
