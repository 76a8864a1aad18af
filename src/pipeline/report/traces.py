"""Curves over time for the explorer of a page: thinned, and written as a script that any page can load."""

from __future__ import annotations

import heapq
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MOST_POINTS = 600
"""Points of a curve that a page shows, at most."""
Series = NDArray[np.float64]


@dataclass(frozen=True)
class Trace:
    """What was recorded of a charge, or of anything else that runs over time.

    Arguments
    ---------
    name, title : identifier, and what it is called.
    group : what it is one of, `same peak current` say.
    mark : number of its colour and line style; the same for what is one mode.
    time_s : times, increasing [s].
    quantities : name with unit -> values at these times.
    """

    name: str
    title: str
    group: str
    mark: int
    time_s: Series
    quantities: Mapping[str, Series]


def thinned(time: Series, columns: Sequence[Series], most: int = MOST_POINTS) -> NDArray[np.int64]:
    """Return which points to keep so that straight lines between them follow all columns as closely as may be.

    The point farthest from its line, in shares of its column's range, is taken next (Ramer 1972; Douglas and Peucker
    1973), until there are enough or all lie on the lines.

    Arguments
    ---------
    time : times, increasing.
    columns : values at these times.
    most : how many points to keep, at least two.
    """
    if len(time) <= most:
        return np.arange(len(time))
    scaled = np.array([(column - column.min()) / (np.ptp(column) or 1.0) for column in columns])
    kept = {0, len(time) - 1}
    waiting: list[tuple[float, int, int, int]] = []

    def split(first: int, last: int) -> None:
        if last - first < 2:
            return
        part = (time[first + 1 : last] - time[first]) / ((time[last] - time[first]) or 1.0)
        line = scaled[:, first, None] + part * (scaled[:, last] - scaled[:, first])[:, None]
        off = np.abs(scaled[:, first + 1 : last] - line).max(axis=0)
        worst = int(off.argmax())
        if off[worst] > 1e-6:
            heapq.heappush(waiting, (-float(off[worst]), first, first + 1 + worst, last))

    split(0, len(time) - 1)
    while waiting and len(kept) < most:
        _, first, middle, last = heapq.heappop(waiting)
        kept.add(middle)
        split(first, middle)
        split(middle, last)
    return np.array(sorted(kept))


def script(traces: Sequence[Trace]) -> str:
    """Return the traces as a script that gives them to the page; to five digits, so that it stays small.

    Raises
    ------
    ValueError : a value that is not a number.
    """
    listed = []
    for trace in traces:
        places = thinned(trace.time_s, list(trace.quantities.values()))
        listed.append(
            {
                "name": trace.name,
                "title": trace.title,
                "group": trace.group,
                "mark": trace.mark,
                "time": _rounded(trace.time_s[places], 7),
                "quantities": {name: _rounded(values[places], 5) for name, values in trace.quantities.items()},
            }
        )
    # A page may hold the script itself, which a closing tag in a title would end.
    text = json.dumps(listed, ensure_ascii=False, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    return f"window.TRACES = {text};\n"


def _rounded(values: Series, digits: int) -> list[float]:
    found = (float(f"{value:.{digits}g}") for value in values.tolist())
    return [int(value) if value.is_integer() else value for value in found]
