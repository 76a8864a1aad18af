"""What the terminal says at the end: what the sheets of days asked for and the days did not bring."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from pipeline.experiments.days.declaration import DAY
from pipeline.kernel.publish import made


def lines(run: Mapping[str, Any], steps: Collection[str], results: Path) -> Iterator[str]:
    """Yield a line for each day of a run that is in the store and missed something.

    Arguments
    ---------
    run : as the plan holds it.
    steps : those that were asked for.
    """
    for name, columns in made(run, "day", DAY["missed"], results) if "day" in steps else ():
        for text in columns["missed"]:
            yield f"{run['study']}/{run['name']} {name}: {text}"
