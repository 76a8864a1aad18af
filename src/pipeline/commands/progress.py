"""How far a sweep is: runs, artefacts, time left; a bar where somebody watches, some lines where nobody does."""

from __future__ import annotations

import sys
import time
from collections.abc import Collection, Iterable, Iterator
from typing import Any

from pipeline.commands.workflow import say

QUIET_S = 2.0
"""What takes less shows nothing."""
_LINES = 10


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
        if now - begun > QUIET_S and now - shown > max(QUIET_S, (now - begun) / _LINES):
            shown = now
            left = (now - begun) / (number + 1) * (len(listed) - number - 1)
            say(f"planned {number + 1} of {len(listed)} runs, {left:.0f} s left")
