"""What came of a charge, in single numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.charge.outcome import Outcome, missed, reason
from pipeline.charge.record_keeping import (
    CHARGE_IN,
    CHARGE_OUT,
    ENERGY_IN,
    ENERGY_OUT,
    SUPPLY_LIMITED_S,
    VOLTAGE_LIMITED_S,
)
from pipeline.charge.records import ChargeSettings
from pipeline.charge.state import DEPTH, TEMPERATURE
from pipeline.charge.vocabulary import SUMMARY

Array = NDArray[np.float64]


class Quantity(NamedTuple):
    """A row of the summary; `value` is None where the charge did not get there or where it is text."""

    quantity: str
    value: float | None
    text: str | None
    unit: str
    description: str


class Ends(NamedTuple):
    """What charges came to, a row each.

    totals, start, state : sums as in the book, and the states, (n, ...).
    peak_k, end_s, drawn_j, ambient_k : highest temperature, time at the end, energy drawn at the source, (n,).
    settled, counts : the numbers of `Settled`; steps, edges and changes of control, (n, 4) and (n, 3).
    """

    totals: Array
    start: Array
    state: Array
    peak_k: Array
    end_s: Array
    drawn_j: Array
    ambient_k: Array
    settled: Array
    counts: Array


def summarise(outcome: Outcome, settings: ChargeSettings, drawn_j: float) -> list[Quantity]:
    """Return the quantities of a charge, in the order of the table.

    Arguments
    ---------
    outcome : the finished run, settled.
    drawn_j : energy drawn at the source for it [J].
    """
    run, book = outcome.run, outcome.book
    assert outcome.settled is not None
    ends = Ends(
        book.totals[None],
        outcome.start[None],
        run["state"][None],
        book.peak_k[:1],
        np.array([outcome.end_s]),
        np.array([drawn_j]),
        np.array([settings.ambient_c]) + ZERO_CELSIUS_K,
        np.array([outcome.settled]),
        np.array([[run["steps"], run["edges"], run["changes"]]], dtype=np.float64),
    )
    return quantities(settings, book.marks, numbers(ends)[0].tolist(), reason(outcome, -1), missed(outcome))


def numbers(ends: Ends) -> Array:
    """Return the numbers of charges, a row each, in the order of the table; NaN where there is none, or text."""
    totals, state = ends.totals, ends.state
    chemical_j, residual_j, charge_as, warming_k_s = ends.settled.T
    net_as = totals[:, CHARGE_IN] - totals[:, CHARGE_OUT]
    net_j = totals[:, ENERGY_IN] - totals[:, ENERGY_OUT]
    gained_as = (ends.start[:, DEPTH] - state[:, DEPTH]) * charge_as
    scale_j = np.maximum(np.maximum(totals[:, ENERGY_IN], totals[:, ENERGY_OUT]), 1e-9)
    # Below this is the rounding of a charger that was blocked or had no supply.
    put_in = totals[:, CHARGE_IN] > 1e-12 * charge_as
    nothing = np.full(len(totals), np.nan)
    columns = (
        ends.end_s,
        1.0 - state[:, DEPTH],
        nothing,
        nothing,
        totals[:, CHARGE_IN] / 3600.0,
        totals[:, CHARGE_OUT] / 3600.0,
        totals[:, ENERGY_IN] / 3600.0,
        totals[:, ENERGY_OUT] / 3600.0,
        _ratio(gained_as, net_as, put_in),
        _ratio(chemical_j, net_j, put_in),
        ends.drawn_j / 3600.0,
        _ratio(chemical_j, ends.drawn_j, put_in),
        ends.peak_k - ZERO_CELSIUS_K,
        ends.peak_k - ends.ambient_k,
        state[:, TEMPERATURE] - ZERO_CELSIUS_K,
        warming_k_s,
        np.where(ends.end_s > 0.0, net_as / np.where(ends.end_s > 0.0, ends.end_s, 1.0), 0.0),
        totals[:, VOLTAGE_LIMITED_S],
        totals[:, SUPPLY_LIMITED_S],
        residual_j / scale_j,
        *ends.counts.T,
    )
    return np.column_stack(columns)


def quantities(
    settings: ChargeSettings, marks: Array, row: Sequence[float], ended: str, not_reached: str
) -> list[Quantity]:
    """Return the quantities of a charge, in the order of the table.

    Arguments
    ---------
    marks : as in its book.
    row : of `numbers`.
    ended, not_reached : what ended it, and what it did not reach, in words.
    """
    values = [*_at_marks(marks, settings), *(value if value == value else None for value in row)]
    texts: list[str | None] = [None] * len(values)
    texts[2 * len(marks) + 2], texts[2 * len(marks) + 3] = ended, not_reached
    names, units, descriptions = _meanings(tuple(sorted(settings.soc_marks)))
    return list(map(Quantity._make, zip(names, values, texts, units, descriptions, strict=True)))


_AT_MARKS = ("time_to_soc_{mark}_s", "temperature_rise_at_soc_{mark}_k")
_OF_CHARGE = (
    "end_time_s",
    "end_soc",
    "end_reason",
    "missed",
    "charge_in_ah",
    "charge_out_ah",
    "energy_in_wh",
    "energy_out_wh",
    "charge_efficiency",
    "energy_efficiency",
    "energy_drawn_wh",
    "system_efficiency",
    "peak_temperature_c",
    "peak_temperature_rise_k",
    "end_temperature_c",
    "peak_temperature_rate_k_s",
    "mean_current_a",
    "time_at_voltage_limit_s",
    "time_at_supply_limit_s",
    "energy_balance_residual",
    "steps",
    "edges",
    "control_changes",
)


@lru_cache(maxsize=1024)
def _meanings(marks: tuple[float, ...]) -> tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]:
    """Return names, units and descriptions of the quantities, in the order of the table."""
    nothing = float("nan")
    found = [SUMMARY.quantity(pattern, nothing, mark=f"{mark:g}") for mark in marks for pattern in _AT_MARKS]
    found += [SUMMARY.quantity(pattern, nothing) for pattern in _OF_CHARGE]
    return tuple(one.name for one in found), tuple(one.unit for one in found), tuple(one.description for one in found)


def _at_marks(marks: Array, settings: ChargeSettings) -> Iterator[float | None]:
    """Yield time and rise in temperature at each mark; none where it was not reached."""
    for _, time_s, temperature_k in marks.tolist():
        reached = math.isfinite(time_s)
        yield time_s if reached else None
        yield temperature_k - (settings.ambient_c + ZERO_CELSIUS_K) if reached else None


def _ratio(above: Array, below: Array, there: NDArray[np.bool_]) -> Array:
    """Return quotients; NaN where there is nothing to divide by."""
    fine = there & (below > 0.0)
    return np.where(fine, above / np.where(fine, below, 1.0), np.nan)
