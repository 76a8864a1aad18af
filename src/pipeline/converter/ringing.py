"""How a current answers a step of its reference: overshoot, settling time, energy of the ringing."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

SETTLED = 0.02
"""Share of the step within which a current counts as settled."""
KINDS = {
    (0, 1): "charge begins",
    (1, 0): "charge ends",
    (1, -1): "discharge begins",
    (-1, 0): "discharge ends",
    (-1, 1): "charge begins",
    (0, -1): "discharge begins",
}


class Edge(NamedTuple):
    """A step of the reference and the answer of the current, switching ripple taken out.

    Arguments
    ---------
    period : number of the switching period at whose start the reference steps.
    kind : what begins or ends.
    before_a, after_a : reference on both sides [A].
    overshoot_a : farthest that the current goes past the new reference, in the direction of the step [A].
    settling_s : time until it stays within `SETTLED` of the step; the whole stretch where it does not [s].
    ringing_j : heat in the series resistance from what the current is off the reference once it has reached it [J].
    deviation_j : the same from the step on: also of the rise or fall itself [J].
    """

    period: int
    kind: str
    before_a: float
    after_a: float
    overshoot_a: float
    settling_s: float
    ringing_j: float
    deviation_j: float


def edges(reference_a: Array, current_a: Array, period_s: float, resistance_ohm: float) -> list[Edge]:
    """Return every step from charging, resting or discharging to another of these that has its whole answer.

    Arguments
    ---------
    reference_a, current_a : reference and mean current of each switching period, shape (n,) [A].
    period_s : length of a switching period [s].
    resistance_ohm : series resistance that the current heats [ohm].

    Returns
    -------
    One for each step but the last, whose answer the end of the run cuts off.
    """
    states = np.sign(np.where(np.abs(reference_a) < 1e-9, 0.0, reference_a)).astype(int)
    places = np.flatnonzero(np.diff(states)) + 1
    return [
        _edge(reference_a, current_a, int(first), int(last), period_s, resistance_ohm, states)
        for first, last in pairwise(places)
    ]


def _edge(
    reference: Array,
    current: Array,
    first: int,
    last: int,
    period_s: float,
    resistance: float,
    states: NDArray[np.int_],
) -> Edge:
    before, after = float(reference[first - 1]), float(reference[first])
    off = current[first:last] - reference[first:last]
    past = off if after > before else -off
    reached = np.flatnonzero(past >= 0.0)
    begin = int(reached[0]) if len(reached) else len(past)
    outside = np.flatnonzero(np.abs(off) > SETTLED * abs(after - before))
    return Edge(
        first,
        KINDS[int(states[first - 1]), int(states[first])],
        before,
        after,
        float(max(past.max(), 0.0)),
        period_s * (int(outside[-1]) + 1 if len(outside) else 0),
        resistance * period_s * float(np.sum(off[begin:] ** 2)),
        resistance * period_s * float(np.sum(off**2)),
    )
