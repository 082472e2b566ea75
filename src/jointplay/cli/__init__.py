"""The command line: errors become a message and an exit code."""

import _thread
import atexit
import gc
import os
import signal
import sys
from argparse import Action, ArgumentParser
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NoReturn

from jointplay.cli import results, selftest, studies, study_files
from jointplay.cli.verb import DONE, FAILED, VERBS
from jointplay.display.errors import InputError, did_you_mean
from jointplay.display.terminal import harmless_output
from jointplay.jobs import interrupts
from jointplay.solver.extensions import outsider

WRONG_INPUT, INTERRUPTED = 2, 130
# objects between collections; at Python's 700 a sixth of a short command's time goes there
COLLECTED = 1_000_000
GROUPS = {module.__name__: place for place, module in enumerate((studies, results, study_files, selftest))}


@harmless_output()
def main(argv: list[str] | None = None) -> int:
    """Run one verb.

    Parameters
    ----------
    argv : list of str, optional
        The words after ``jointplay``; the process's own by default.

    Returns
    -------
    int
        0 done, 1 numerical failure or a result that could not be stored, 2 wrong input, 130 interrupted.
    """
    _open_streams()
    gc.set_threshold(COLLECTED)
    atexit.register(gc.freeze)  # the last collection would walk through all that was ever loaded
    arguments = build_parser().parse_args(argv)
    with _interrupts() as pressed:
        try:
            code = arguments.verb(arguments)
            if sys.stdout is not None:
                sys.stdout.flush()  # output that cannot be written fails here, and not as Python ends
            return code
        except KeyboardInterrupt as error:
            return _interrupted(*error.args[:1])
        except BrokenPipeError:  # the reader of a pipe has left, such as `| head`
            _drop_output()
            return DONE
        except OSError as error:
            print(f"not done: {error}", file=sys.stderr)
            _drop_output()
            return FAILED
        except InputError as error:
            return _refused(error)
        except MemoryError as error:
            print(f"not enough memory: {error}; ask for fewer turns, samples or cells", file=sys.stderr)
            return FAILED
        except Exception as error:
            if pressed:  # the compiler turns an interrupt into errors of its own
                return _interrupted()
            if not (whose := outsider(error)):
                raise
            print(f"error in code of {whose}\n  {type(error).__name__}: {error}", file=sys.stderr)
            return FAILED


def _open_streams() -> None:
    """Open standard streams that the caller has closed, and write out characters that a stream cannot encode.

    Else the next file that is opened would take the number of a closed stream, and get what is printed.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def _drop_output() -> None:
    """Discard output that cannot be written, which Python would try once more as it ends."""
    try:
        sys.stdout.flush()
    except (OSError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _refused(error: InputError) -> int:
    print("wrong input:" if error.count == 1 else f"wrong input, {error.count} problems:", file=sys.stderr)
    print("\n".join(f"  {line}" for line in str(error).splitlines()), file=sys.stderr)
    return WRONG_INPUT


def _interrupted(how: str = "run the same command again to start over") -> int:
    exec("")  # Python ends as if killed when the interrupt came inside another exec: this clears its mark
    print(f"interrupted: {how}", file=sys.stderr)
    return INTERRUPTED


def _leave() -> None:
    """End the process, where compiled code goes on after Ctrl-C: no file is ever there in part."""
    interrupts.write_line("interrupted: run the same command again")
    os._exit(INTERRUPTED)


@contextmanager
def _interrupts() -> Iterator[list[bool]]:
    """Record that Ctrl-C was pressed, besides raising KeyboardInterrupt as always.

    An analysis that keeps its results so far (motion.progress) is asked to end first, and interrupted by a
    second Ctrl-C.
    """
    pressed: list[bool] = []

    def note(*_: object) -> None:
        pressed.append(True)
        progress = sys.modules.get("jointplay.solver.motion.progress")
        if progress is None or not progress.stop():
            raise KeyboardInterrupt

    def again(lost) -> None:  # an interrupt that a callback of the compiler could not pass on
        if issubclass(lost.exc_type, KeyboardInterrupt):
            _thread.interrupt_main()
        else:
            sys.__unraisablehook__(lost)

    try:
        before, hook = signal.signal(signal.SIGINT, note), sys.unraisablehook
    except ValueError:  # only a main thread takes signals
        yield pressed
        return
    sys.unraisablehook = again
    try:
        with interrupts.guarded(_leave):
            yield pressed
    finally:
        sys.unraisablehook = hook
        signal.signal(signal.SIGINT, before)


class _Version(Action):
    """Look the version up only when the option is used."""

    def __call__(self, parser, *_):
        from importlib.metadata import version

        parser.exit(message=f"jointplay {version('jointplay')}\n")


class _Parser(ArgumentParser):
    """The parser of all verbs; of one that it does not know, it says which verbs could not be loaded."""

    def error(self, message: str) -> NoReturn:
        _, _, given = message.partition("invalid choice: '")
        near = did_you_mean(given.partition("'")[0], VERBS).strip()
        lost = (f"not loaded: {point}: {why}" for point, why in VERBS.broken.items())
        super().error("; ".join([message, *[near] * bool(near), *lost]))


class _VerbParser(ArgumentParser):
    """The parser of a verb, whose options may stand anywhere among what has no name."""

    reading = False

    def parse_known_args(self, args=None, namespace=None):
        if self.reading:  # the parts into which a line with options in its midst is divided
            return super().parse_known_args(args, namespace)
        self.reading = True
        try:
            return self.parse_known_intermixed_args(args, namespace)
        finally:
            self.reading = False


def build_parser() -> ArgumentParser:
    """Make the parser of all verbs."""
    parser = _Parser(prog="jointplay", description="Dynamics of linkages with play in their joints.")
    parser.add_argument("--version", action=_Version, nargs=0, help="print the version")
    subparsers = parser.add_subparsers(title="verbs", required=True, metavar="VERB", parser_class=_VerbParser)
    for row in sorted(VERBS.values(), key=lambda row: GROUPS.get(row.function.__module__, len(GROUPS))):
        text = row.function.__doc__ or ""
        own = subparsers.add_parser(
            row.name,
            help=text[0].lower() + text[1:].rstrip("."),
            description=text,
            epilog=f"example: jointplay {row.name} {row.example}",
        )
        own.set_defaults(verb=row.function)
        for names, keywords in row.options:
            own.add_argument(*names, **keywords)
    return parser
