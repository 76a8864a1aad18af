"""One run at a time in a results folder: a second one waits, and says for whom.

`results/.lock` is held by a run, `results/.jobs` is shared by its jobs, which may outlive it where it is killed. Both
are locks of the kernel (flock): they end with the processes that hold them, however these end.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import json
import os
import shlex
import socket
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from pipeline.kernel.errors import UserError
from pipeline.kernel.last_resort import remedy

RUN = ".lock"
JOBS = ".jobs"
HANDED_ON = "CHARGE_PIPELINE_LOCK"
"""Environment variable: the descriptor of a lock that the process which started this one holds for both."""

_NO_LOCKS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
# Descriptors of the locks that this process holds, by folder.
_held: dict[Path, int] = {}


def take(results: Path, say: Callable[[str], None]) -> int:
    """Take the lock of a results folder until this process ends or `release` is called; return its descriptor.

    Waits for the run that holds it, and for jobs that an earlier run has left at work. Taken again by the same
    process, or by one that it was handed on to, it is the same lock.

    Arguments
    ---------
    say : takes a line that says who is waited for.

    Raises
    ------
    UserError : the folder cannot be written to.
    """
    folder = results.absolute()
    if folder in _held:
        return _held[folder]
    try:
        results.mkdir(parents=True, exist_ok=True)
        descriptor = _inherited(results / RUN)
        if descriptor is None:
            descriptor = _wait(results / RUN, say)
            _sign(descriptor, shlex.join([Path(sys.executable).name, *sys.orig_argv[1:]]))
        else:
            _sign(descriptor, str(_signature(descriptor).get("command")))
        _await_jobs(results / JOBS, say)
    except OSError as error:
        raise UserError(remedy(error, results) or f"{results / RUN}: {error.strerror}") from None
    _held[folder] = descriptor
    return descriptor


def release(results: Path) -> None:
    """Give the lock of a results folder back."""
    descriptor = _held.pop(results.absolute(), None)
    if descriptor is not None:
        os.close(descriptor)


@contextlib.contextmanager
def held(results: Path, say: Callable[[str], None]) -> Iterator[int]:
    """Hold the lock of a results folder for a while; yields its descriptor, to be handed on."""
    mine = results.absolute() not in _held
    try:
        yield take(results, say)
    finally:
        if mine:
            release(results)


@contextlib.contextmanager
def at_work(results: Path) -> Iterator[None]:
    """Let runs that follow know that a job is at work in a results folder."""
    try:
        results.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(results / JOBS, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError:
        # Where nothing can be written, what the job writes says so.
        yield
        return
    try:
        _lock(descriptor, fcntl.LOCK_SH)
        yield
    finally:
        os.close(descriptor)


def _wait(path: Path, say: Callable[[str], None]) -> int:
    """Return a descriptor of the lock, when it is free; the file may be replaced while waiting."""
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            if not _lock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB):
                say(f"{path.parent}: in use by {_holder(descriptor)}; waiting until it ends")
                _lock(descriptor, fcntl.LOCK_EX)
            if _same(descriptor, path):
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)


def _await_jobs(path: Path, say: Callable[[str], None]) -> None:
    """Wait until no job of an earlier run is at work."""
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        if not _lock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB):
            say(f"{path.parent}: jobs of a run that was ended are still at work{_owners(path)}; waiting for them")
            _lock(descriptor, fcntl.LOCK_EX)
    finally:
        os.close(descriptor)


def _inherited(path: Path) -> int | None:
    """Return the descriptor that was handed on to this process, where it is of this lock."""
    word = os.environ.pop(HANDED_ON, "")
    if not word.isdecimal():
        return None
    descriptor = int(word)
    try:
        if not _same(descriptor, path) or not _lock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB):
            return None
        os.set_inheritable(descriptor, False)
    except OSError:
        return None
    return descriptor


def _lock(descriptor: int, how: int) -> bool:
    """Lock; return False where another process has it, True also on a file system without locks."""
    try:
        fcntl.flock(descriptor, how)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise
    return True


def _same(descriptor: int, path: Path) -> bool:
    with contextlib.suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(descriptor), path.stat())
    return False


def _sign(descriptor: int, command: str) -> None:
    """Write into the lock who holds it."""
    command = " ".join(command.split())
    signature = {
        "process": os.getpid(),
        "host": socket.gethostname(),
        "since": time.strftime("%Y-%m-%d %H:%M:%S"),
        "command": command if len(command) <= 200 else f"{command[:197]}...",
    }
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, json.dumps(signature).encode(), 0)


def _signature(descriptor: int) -> dict[str, Any]:
    """Return who holds the lock, as far as it is written there."""
    try:
        found = json.loads(os.pread(descriptor, 4096, 0))
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _holder(descriptor: int) -> str:
    found = _signature(descriptor)
    try:
        return f"process {found['process']} on {found['host']} since {found['since']} ({found['command']})"
    except KeyError:
        return "another run"


def _owners(path: Path) -> str:
    """Return the processes that share a lock, where the system tells (Linux)."""
    try:
        inode = f":{path.stat().st_ino}"
        lines = [line.split() for line in Path("/proc/locks").read_text(encoding="ascii").splitlines()]
        found = sorted({int(words[-4]) for words in lines if words[-3].endswith(inode) and "->" not in words})
    except (OSError, ValueError, IndexError):
        return ""
    return f" (process{'es' * (len(found) > 1)} {', '.join(map(str, found))})" if found else ""
