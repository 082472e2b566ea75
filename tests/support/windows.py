"""Windows as far as a POSIX system can play it: what is not there, and what open files refuse.

The stand-in for `msvcrt` locks a byte as `msvcrt.locking` does, also beside another process.
"""

import errno
import os
import signal
import sys
import tempfile
from contextlib import suppress
from types import ModuleType

with suppress(ImportError):  # there, nobody calls what is here
    import fcntl

MISSING = "geteuid getuid fork uname killpg nice statvfs set_blocking sched_getaffinity getloadavg"  # of os
MODULES = "fcntl resource pwd grp termios tty pty syslog"


def locking(file, mode, count):
    """`msvcrt.locking`: bytes from the file's place on, until the file is closed."""
    assert mode == 2
    fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB, count, os.lseek(file, 0, os.SEEK_CUR))


def msvcrt():
    """A stand-in for the module."""
    module = ModuleType("msvcrt")
    module.LK_NBLCK, module.locking = 2, locking
    return module


def pretend(patch):
    """Be Windows from here on, in this process, until the patch of pytest is undone."""
    for name in MISSING.split():
        patch.delattr(os, name)
    for name in ("pthread_kill", "SIGURG"):
        patch.delattr(signal, name)
    for name in MODULES.split():
        patch.setitem(sys.modules, name, None)  # importing it fails
    patch.setitem(sys.modules, "msvcrt", msvcrt())
    patch.setattr(tempfile, "TemporaryFile", tempfile.NamedTemporaryFile)  # as there

    plain = {name: getattr(os, name) for name in ("open", "fsync", "replace", "rename", "unlink", "remove")}

    made = os.mkdir

    def kill(process, number):
        raise AssertionError("os.kill ends a process, whatever the signal")

    def opened(path, flags, mode=0o777, **named):
        if not named and os.path.isdir(path):
            raise PermissionError(errno.EACCES, "a folder is no file", path)
        return plain["open"](path, flags, 0o666, **named)

    def fsync(file):
        if fcntl.fcntl(file, fcntl.F_GETFL) & os.O_ACCMODE == os.O_RDONLY:
            raise OSError(errno.EBADF, "only what may be written is flushed")
        plain["fsync"](file)

    def moved(name):
        def change(*paths, **named):
            for path in paths:
                if not named and in_use(path):
                    raise PermissionError(errno.EACCES, "it is open in a process", path)
            return plain[name](*paths, **named)

        return change

    os.umask(0)  # all modes say that anybody may write
    patch.setattr(os, "mkdir", lambda path, mode=0o777, **named: made(path, 0o777, **named))
    for name, stand in {"kill": kill, "open": opened, "fsync": fsync}.items():
        patch.setattr(os, name, stand)
    for name in ("replace", "rename", "unlink", "remove"):
        patch.setattr(os, name, moved(name))


def in_use(path):
    """Whether this process has a file open."""
    whole = os.path.realpath(os.fsdecode(path))
    return any(os.path.realpath(f"/proc/self/fd/{number}") == whole for number in os.listdir("/proc/self/fd"))
