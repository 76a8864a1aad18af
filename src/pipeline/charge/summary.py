"""What came of a charge, in single numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from typing import NamedTuple

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


class Quantity(NamedTuple):
    """A row of the summary; `value` is None where the charge did not get there or where it is text."""

    quantity: str
    value: float | None
    text: str | None
    unit: str
    description: str


def summarise(outcome: Outcome, settings: ChargeSettings, drawn_j: float) -> list[Quantity]:
    """Return the quantities of a charge, in the order of the table.

    Arguments
    ---------
    outcome : the finished run, settled.
    drawn_j : energy drawn at the source for it [J].
    """
    settled, run = outcome.settled, outcome.run
    assert settled is not None
    totals, start, end = outcome.book.totals.tolist(), outcome.start.tolist(), run["state"].tolist()
    net_as = totals[CHARGE_IN] - totals[CHARGE_OUT]
    net_j = totals[ENERGY_IN] - totals[ENERGY_OUT]
    gained_as = (start[DEPTH] - end[DEPTH]) * settled.charge_as
    scale_j = max(totals[ENERGY_IN], totals[ENERGY_OUT], 1e-9)
    peak_k = float(outcome.book.peak_k[0])
    # Below this is the rounding of a charger that was blocked or had no supply.
    put_in = totals[CHARGE_IN] > 1e-12 * settled.charge_as
    marks = sorted(settings.soc_marks)
    values = [
        *_at_marks(outcome, settings),
        outcome.end_s,
        1.0 - end[DEPTH],
        None,
        None,
        totals[CHARGE_IN] / 3600,
        totals[CHARGE_OUT] / 3600,
        totals[ENERGY_IN] / 3600,
        totals[ENERGY_OUT] / 3600,
        _ratio(gained_as, net_as) if put_in else None,
        _ratio(settled.chemical_j, net_j) if put_in else None,
        drawn_j / 3600,
        _ratio(settled.chemical_j, drawn_j) if put_in else None,
        peak_k - ZERO_CELSIUS_K,
        peak_k - (settings.ambient_c + ZERO_CELSIUS_K),
        end[TEMPERATURE] - ZERO_CELSIUS_K,
        settled.warming_k_s,
        net_as / outcome.end_s if outcome.end_s else 0.0,
        totals[VOLTAGE_LIMITED_S],
        totals[SUPPLY_LIMITED_S],
        settled.residual_j / scale_j,
        float(run["steps"]),
        float(run["edges"]),
        float(run["changes"]),
    ]
    texts: list[str | None] = [None] * len(values)
    texts[2 * len(marks) + 2], texts[2 * len(marks) + 3] = reason(outcome, -1), missed(outcome)
    names, units, descriptions = _meanings(tuple(marks))
    rows = zip(names, values, texts, units, descriptions, strict=True)
    return list(map(Quantity._make, rows))


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


def _at_marks(outcome: Outcome, settings: ChargeSettings) -> Iterator[float | None]:
    """Yield time and rise in temperature at each mark; none where it was not reached."""
    for _, time_s, temperature_k in outcome.book.marks.tolist():
        reached = math.isfinite(time_s)
        yield time_s if reached else None
        yield temperature_k - (settings.ambient_c + ZERO_CELSIUS_K) if reached else None


def _ratio(above: float, below: float) -> float | None:
    """Return a quotient; None where there is nothing to divide by."""
    return above / below if below > 0.0 else None
