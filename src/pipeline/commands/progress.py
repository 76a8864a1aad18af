"""How far a sweep is: runs, artefacts, time left; bars where somebody watches, some lines where nobody does."""

from __future__ import annotations

import re
import sys
import threading
import time
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pipeline.commands.workflow import say
from pipeline.kernel import receipts
from pipeline.kernel.experiment import kind_of

QUIET_S = 2.0
"""What takes less shows nothing."""
_LINES = 10
_LOOK_S = 0.5
_KEY = re.compile(r"\b[0-9a-f]{12}\b")


def through(runs: Iterable[Any]) -> Iterator[Any]:
    """Yield the runs that are planned, and show how far that is."""
    listed = runs if isinstance(runs, Collection) else list(runs)
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import track

        console = Console(stderr=True)
        yield from track(listed, "planning", console=console, transient=True, disable=len(listed) < 2)
        return
    begun = shown = time.monotonic()
    for number, run in enumerate(listed):
        yield run
        now = time.monotonic()
        if number == 0:  # takes longer than any other
            begun = now
        elif now - begun > QUIET_S and now - shown > max(QUIET_S, (now - begun) / _LINES):
            shown = now
            left = (now - begun) / number * (len(listed) - number - 1)
            say(f"planned {number + 1} of {len(listed)} runs, {left:.0f} s left")


class Made:
    """What of a sweep's plan is made, as far as receipts and the logs of its jobs say.

    Arguments
    ---------
    plan : the plan.
    results : the results folder.
    """

    def __init__(self, plan: Mapping[str, Any], results: Path) -> None:
        self._chunks = {
            results / "logs" / chunk["step"] / f"{name}.log": (receipts.path_of(results, chunk["step"], name), chunk)
            for name, chunk in plan["chunks"].items()
            if "nodes" in chunk
        }
        self._begun = time.time()
        self._read: dict[Path, int] = {}
        self._waits: dict[str, list[str]] = {}
        self._open: dict[str, int] = {}
        for number, run in enumerate(plan["runs"]):
            for name, node in run["nodes"].items():
                own = kind_of(name)
                if own in run["sweep"] and node["key"] in plan["nodes"]:
                    self._waits.setdefault(node["key"][:12], []).append(f"{number}/{own}")
                    self._open[f"{number}/{own}"] = self._open.get(f"{number}/{own}", 0) + 1
        self._done: set[str] = set()
        self.nodes, self.runs = len(plan["nodes"]), len(self._open)
        for receipt, chunk in self._chunks.values():
            if receipt.is_file():
                self._note(key[:12] for key in chunk["nodes"])

    @property
    def done(self) -> tuple[int, int]:
        """Return how many runs and how many artefacts are made."""
        return sum(count == 0 for count in self._open.values()), len(self._done)

    def look(self) -> None:
        """Read on in the logs."""
        for log in self._chunks:
            try:
                if log.stat().st_mtime < self._begun - 1.0:
                    continue
                with log.open("rb") as file:
                    file.seek(self._read.get(log, 0))
                    text = file.read()
            except OSError:
                continue
            whole = text[: text.rfind(b"\n") + 1]
            self._read[log] = self._read.get(log, 0) + len(whole)
            self._note(_KEY.findall(whole.decode("utf-8", "replace")))

    def _note(self, keys: Iterable[str]) -> None:
        for key in keys:
            if key not in self._done:
                self._done.add(key)
                for run in self._waits.get(key, ()):
                    self._open[run] -= 1


@contextmanager
def shown(plan: Mapping[str, Any], results: Path) -> Iterator[Made]:
    """Show how far a sweep is while its jobs run."""
    made = Made(plan, results)
    ended = threading.Event()
    showing = _bars if sys.stderr.isatty() else _lines
    thread = threading.Thread(target=showing, args=(made, ended), daemon=True)
    thread.start()
    try:
        yield made
    finally:
        ended.set()
        thread.join()
        made.look()


def _bars(made: Made, ended: threading.Event) -> None:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description:>9}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    runs, nodes = made.done
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        bars = [progress.add_task("runs", total=made.runs, completed=runs)]
        bars.append(progress.add_task("artefacts", total=made.nodes, completed=nodes))
        while not ended.wait(_LOOK_S):
            made.look()
            for bar, done in zip(bars, made.done, strict=True):
                progress.update(bar, completed=done)


def _lines(made: Made, ended: threading.Event) -> None:
    begun = told = time.monotonic()
    _, first = made.done
    last = first
    while not ended.wait(_LOOK_S):
        made.look()
        now = time.monotonic()
        runs, nodes = made.done
        if nodes > last and now - told > max(5.0, (now - begun) / _LINES):
            told, last = now, nodes
            left = (now - begun) / (nodes - first) * (made.nodes - nodes)
            say(f"{runs} of {made.runs} runs, {nodes} of {made.nodes} artefacts, {left:.0f} s left")
