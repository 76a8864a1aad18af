"""What came of a charge, in single numbers."""

from __future__ import annotations

import math
from functools import cache
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
    return [
        *_marks(outcome, settings),
        _number("end_time_s", outcome.end_s),
        _number("end_soc", 1.0 - end[DEPTH]),
        _text("end_reason", reason(outcome, -1)),
        _text("missed", missed(outcome)),
        _number("charge_in_ah", totals[CHARGE_IN] / 3600),
        _number("charge_out_ah", totals[CHARGE_OUT] / 3600),
        _number("energy_in_wh", totals[ENERGY_IN] / 3600),
        _number("energy_out_wh", totals[ENERGY_OUT] / 3600),
        _number("charge_efficiency", _ratio(gained_as, net_as) if put_in else None),
        _number("energy_efficiency", _ratio(settled.chemical_j, net_j) if put_in else None),
        _number("energy_drawn_wh", drawn_j / 3600),
        _number("system_efficiency", _ratio(settled.chemical_j, drawn_j) if put_in else None),
        _number("peak_temperature_c", peak_k - ZERO_CELSIUS_K),
        _number("peak_temperature_rise_k", peak_k - (settings.ambient_c + ZERO_CELSIUS_K)),
        _number("end_temperature_c", end[TEMPERATURE] - ZERO_CELSIUS_K),
        _number("peak_temperature_rate_k_s", settled.warming_k_s),
        _number("mean_current_a", net_as / outcome.end_s if outcome.end_s else 0.0),
        _number("time_at_voltage_limit_s", totals[VOLTAGE_LIMITED_S]),
        _number("time_at_supply_limit_s", totals[SUPPLY_LIMITED_S]),
        _number("energy_balance_residual", settled.residual_j / scale_j),
        _number("steps", run["steps"]),
        _number("edges", run["edges"]),
        _number("control_changes", run["changes"]),
    ]


@cache
def _meaning(pattern: str, mark: str | None) -> tuple[str, str, str]:
    """Return name, unit and description of a quantity."""
    found = SUMMARY.quantity(pattern, float("nan"), **({} if mark is None else {"mark": mark}))
    return found.name, found.unit, found.description


def _number(pattern: str, value: float | None, mark: str | None = None) -> Quantity:
    name, unit, description = _meaning(pattern, mark)
    return Quantity(name, None if value is None else float(value), None, unit, description)


def _text(name: str, text: str) -> Quantity:
    return _number(name, None)._replace(text=text)


def _marks(outcome: Outcome, settings: ChargeSettings) -> list[Quantity]:
    rows: list[Quantity] = []
    for mark, (_, time_s, temperature_k) in zip(sorted(settings.soc_marks), outcome.book.marks.tolist(), strict=True):
        reached, of = math.isfinite(time_s), f"{mark:g}"
        rise = temperature_k - (settings.ambient_c + ZERO_CELSIUS_K)
        rows += [
            _number("time_to_soc_{mark}_s", time_s if reached else None, of),
            _number("temperature_rise_at_soc_{mark}_k", rise if reached else None, of),
        ]
    return rows


def _ratio(above: float, below: float) -> float | None:
    """Return a quotient; None where there is nothing to divide by."""
    return above / below if below > 0.0 else None
