"""What came of a charge, in single numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.charge.outcome import Outcome
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


def summarise(
    outcome: Outcome,
    settings: ChargeSettings,
    energy: dict[str, Any],
    drawn_j: float,
    reason: str,
    missed: str,
) -> list[Quantity]:
    """Return the quantities of a charge, in the order of the table; `missed` is empty where nothing was.

    Arguments
    ---------
    energy : its balance, as `energy.balance` returns it.
    drawn_j : energy drawn at the source for it [J].
    reason, missed : what ended it, what it did not reach.
    """
    totals, start, end = outcome.book.totals, outcome.start, outcome.run["state"]
    of_path = dict(zip(energy["path"], energy["energy_j"], strict=True))
    net_as = totals[CHARGE_IN] - totals[CHARGE_OUT]
    net_j = totals[ENERGY_IN] - totals[ENERGY_OUT]
    gained_as = (start[DEPTH] - end[DEPTH]) * outcome.cell.charge_as
    scale_j = max(totals[ENERGY_IN], totals[ENERGY_OUT], 1e-9)
    peak_k, run = outcome.book.peak_k[0], outcome.run
    # Below this is the rounding of a charger that was blocked or had no supply.
    put_in = totals[CHARGE_IN] > 1e-12 * outcome.cell.charge_as
    numbers: dict[str, float | None] = {
        "end_time_s": outcome.end_s,
        "end_soc": 1.0 - end[DEPTH],
        "charge_in_ah": totals[CHARGE_IN] / 3600,
        "charge_out_ah": totals[CHARGE_OUT] / 3600,
        "energy_in_wh": totals[ENERGY_IN] / 3600,
        "energy_out_wh": totals[ENERGY_OUT] / 3600,
        "charge_efficiency": _ratio(gained_as, net_as) if put_in else None,
        "energy_efficiency": _ratio(of_path["chemical"], net_j) if put_in else None,
        "energy_drawn_wh": drawn_j / 3600,
        "system_efficiency": _ratio(of_path["chemical"], drawn_j) if put_in else None,
        "peak_temperature_c": peak_k - ZERO_CELSIUS_K,
        "peak_temperature_rise_k": peak_k - (settings.ambient_c + ZERO_CELSIUS_K),
        "end_temperature_c": end[TEMPERATURE] - ZERO_CELSIUS_K,
        "peak_temperature_rate_k_s": _peak_rate_k_s(outcome),
        "mean_current_a": net_as / outcome.end_s if outcome.end_s else 0.0,
        "time_at_voltage_limit_s": totals[VOLTAGE_LIMITED_S],
        "time_at_supply_limit_s": totals[SUPPLY_LIMITED_S],
        "energy_balance_residual": of_path["residual"] / scale_j,
        "steps": run["steps"],
        "edges": run["edges"],
        "control_changes": run["changes"],
    }
    rows = [*_marks(outcome, settings), *(_number(name, value) for name, value in numbers.items())]
    texts = [_text("end_reason", reason), _text("missed", missed)]
    after = next(place for place, row in enumerate(rows) if row.quantity == "end_soc") + 1
    return rows[:after] + texts + rows[after:]


def _number(pattern: str, value: float | None, **named: object) -> Quantity:
    found = SUMMARY.quantity(pattern, float("nan") if value is None else value, **named)
    return Quantity(found.name, None if value is None else found.value, None, found.unit, found.description)


def _text(name: str, text: str) -> Quantity:
    return _number(name, None)._replace(text=text)


def _marks(outcome: Outcome, settings: ChargeSettings) -> list[Quantity]:
    rows: list[Quantity] = []
    for mark, (_, time_s, temperature_k) in zip(sorted(settings.soc_marks), outcome.book.marks, strict=True):
        reached, of = bool(np.isfinite(time_s)), {"mark": f"{mark:g}"}
        rise = float(temperature_k - (settings.ambient_c + ZERO_CELSIUS_K))
        rows += [
            _number("time_to_soc_{mark}_s", float(time_s) if reached else None, **of),
            _number("temperature_rise_at_soc_{mark}_k", rise if reached else None, **of),
        ]
    return rows


def _peak_rate_k_s(outcome: Outcome) -> float:
    samples = outcome.book.samples[: outcome.book.filled[0]]
    time = np.concatenate([[0.0], samples[:, 0]])
    temperature = np.concatenate([[outcome.start[TEMPERATURE]], samples[:, 8]])
    return float(np.max(np.diff(temperature) / np.diff(time))) if len(samples) else 0.0


def _ratio(above: float, below: float) -> float | None:
    """Return a quotient; None where there is nothing to divide by."""
    return float(above / below) if below > 0.0 else None
