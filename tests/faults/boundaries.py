"""Counts what a process does to files, and strikes at one of these boundaries: kills it there, or fills the disk.

Patched are the functions that Python code calls, so that writes of Parquet and of figures are counted as well.
"""

from __future__ import annotations

import builtins
import errno
import io
import os
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import pyarrow.parquet as pq

HOWS = ("before", "half", "after")
"""When a process is killed: before what it does, in the middle of it (a write alone has one), behind it."""
FULL = "full"
"""From this boundary on, no byte goes to disk: half a write does, then the system says so."""


class Boundaries:
    """The boundaries that a process has reached.

    Arguments
    ---------
    root : only what happens below it counts.
    at : number of the boundary to strike at, from one; none with zero.
    how : one of `HOWS`, or `FULL`.
    """

    def __init__(self, root: Path, at: int = 0, how: str = "before") -> None:
        self.root = f"{root.resolve()}/"
        self.at = at
        self.how = how
        self.reached: list[str] = []

    def reach(self, kind: str, place: str, act: Callable[[], Any], half: Callable[[], Any] | None = None) -> Any:
        """Do something to a file, unless it is where the process is struck."""
        parts = place.removeprefix(self.root).split("/")
        self.reached.append("receipt" if "receipts" in parts and kind in ("rename", "unlink") else kind)
        number = len(self.reached)
        if self.how == FULL and 0 < self.at <= number and kind in ("write", "open", "mkdir", "link", "fsync"):
            if half is not None and number == self.at:
                half()
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), place)
        if number == self.at and self.how == "before":
            _end()
        if number == self.at and self.how == "half" and half is not None:
            half()
            _end()
        try:
            return act()
        finally:
            # What was refused has been reached as well.
            if number == self.at and self.how in ("after", "half"):
                _end()

    def place(self, name: Any, folder: int | None = None) -> str | None:
        """Return the absolute path of what is acted on, where it is below the root."""
        try:
            path = Path(f"/proc/self/fd/{name}").readlink() if isinstance(name, int) else Path(os.fsdecode(name))
            if folder is not None:
                path = Path(f"/proc/self/fd/{folder}").readlink() / path
        except (OSError, TypeError):
            return None
        # Not resolved: a link is acted on itself.
        found = str(path.absolute())
        return found if found.startswith(self.root) else None

    def install(self) -> None:
        """Patch this process, for good."""
        for name, kind, which in (
            ("replace", "rename", 1),
            ("rename", "rename", 1),
            ("link", "link", 1),
            ("unlink", "unlink", 0),
            ("remove", "unlink", 0),
            ("rmdir", "unlink", 0),
            ("mkdir", "mkdir", 0),
            ("chmod", "chmod", 0),
            ("utime", "utime", 0),
            ("fsync", "fsync", 0),
            ("pwrite", "write", 0),
        ):
            self._wrap(name, kind, which)
        plain = io.open

        def opened(file: Any, mode: str = "r", buffering: int = -1, *rest: Any, **more: Any) -> Any:
            place = self.place(file)
            if place is None or not set(mode) & set("wax+"):
                return plain(file, mode, buffering, *rest, **more)
            raw = self.reach("open", place, lambda: _Counted(self, place, file, mode.replace("b", "").replace("t", "")))
            buffered = io.BufferedRandom(raw) if "+" in mode else io.BufferedWriter(raw)
            return buffered if "b" in mode else io.TextIOWrapper(buffered, *rest, **more)

        write = pq.write_table

        def written(table: Any, where: Any, *rest: Any, **more: Any) -> None:
            if not isinstance(where, str | os.PathLike):  # in memory: its bytes reach the disk by another call
                write(table, where, *rest, **more)
                return
            with opened(where, "wb") as file:
                write(table, file, *rest, **more)

        io.open = builtins.open = opened  # type: ignore[assignment]
        pq.write_table = written

    def _wrap(self, name: str, kind: str, which: int) -> None:
        plain = getattr(os, name)

        def wrapped(*words: Any, **more: Any) -> Any:
            place = self.place(words[which], more.get("dir_fd"))
            if place is None:
                return plain(*words, **more)
            half = (lambda: plain(words[0], words[1][: len(words[1]) // 2], *words[2:])) if kind == "write" else None
            return self.reach(kind, place, lambda: plain(*words, **more), half)

        setattr(os, name, wrapped)
        # Modules that ask which functions take a folder's descriptor are told as before.
        for known in (os.supports_dir_fd, os.supports_follow_symlinks, os.supports_fd):
            if plain in known:
                known.add(wrapped)


class _Counted(io.FileIO):
    """A file whose writes are boundaries."""

    def __init__(self, boundaries: Boundaries, place: str, file: Any, mode: str) -> None:
        super().__init__(file, mode)
        self._boundaries = boundaries
        self._place = place

    def write(self, data: Any) -> int:
        """Write, or be struck."""
        content = bytes(data)
        plain = super().write
        written: int = self._boundaries.reach(
            "write", self._place, lambda: plain(content), lambda: plain(content[: len(content) // 2])
        )
        return written


def _end() -> NoReturn:
    os.kill(os.getpid(), signal.SIGKILL)
    raise AssertionError("killed")
