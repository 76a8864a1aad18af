"""The switches as a state machine: off, Mode 1, Mode 2, ended.

After section 2.1 of Chen, Yau, Lu 2015: in Mode 1 switches 2 and 3 are on and 4 is off; in Mode 2 switch 4 joins the
discharge resistor to the battery while 3 is off, for the short negative part of each period, and 3 is on for the
charging part; the text says of neither mode what happens without sun, for which all three are off here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.bus.records import Switching

OFF, MODE_1, MODE_2, ENDED = "off", "mode_1", "mode_2", "ended"
STATES = (OFF, MODE_1, MODE_2, ENDED)


class Span(NamedTuple):
    """A stretch of time [s]."""

    start_s: float
    end_s: float


class Closed(NamedTuple):
    """Share of the time for which each switch is closed [1]."""

    s2: float
    s3: float
    s4: float


class Change(NamedTuple):
    """A change of state: when, from what to what, why, and the switches from then on."""

    time_s: float
    before: str
    after: str
    reason: str
    closed: Closed
    pulses_hz: float


def charging_spans(
    time_s: NDArray[np.float64], power_w: NDArray[np.float64], end_s: float, switching: Switching
) -> list[Span]:
    """Return when the surplus lets the charger draw, with hysteresis.

    Arguments
    ---------
    time_s, power_w : power left for the battery, constant from each time to the next, shape (n,).
    end_s : end of the last row [s].
    """
    found: list[Span] = []
    since: float | None = None
    for at_s, power in zip(time_s.tolist(), power_w.tolist(), strict=True):
        if since is None and power >= switching.start_power_w:
            since = at_s
        elif since is not None and power < switching.stop_power_w:
            found.append(Span(since, at_s))
            since = None
    return found if since is None else [*found, Span(since, end_s)]


def closed(state: str, charge_share: float = 1.0, discharge_share: float = 0.0) -> Closed:
    """Return how the switches stand in a state.

    Arguments
    ---------
    charge_share, discharge_share : shares of a period of the pulses, for Mode 2.
    """
    if state == MODE_1:
        return Closed(1.0, 1.0, 0.0)
    if state == MODE_2:
        return Closed(1.0, charge_share, discharge_share)
    return Closed(0.0, 0.0, 0.0)


def state_at(changes: Sequence[Change], time_s: NDArray[np.float64]) -> list[str]:
    """Return the state at each time."""
    starts = [change.time_s for change in changes]
    rows = np.searchsorted(starts, time_s, side="right") - 1
    return [changes[row].after if row >= 0 else OFF for row in rows.tolist()]
