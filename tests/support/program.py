"""The program as a user starts it, in a process of its own."""

import subprocess
import sys


def jointplay(*words, **options):
    """Run ``jointplay`` with these words; what it said and its exit code."""
    command = [sys.executable, "-m", "jointplay", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, **options)


def ended_process():
    """Number of a process that has been, and is no more."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid
