"""What came of a charge, in single numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.cell.records import Battery
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

MISSED = "what it was to reach and did not, and why"


class Quantity(NamedTuple):
    """A row of the summary; `value` is None where the charge did not get there or where it is text."""

    quantity: str
    value: float | None
    text: str | None
    unit: str
    description: str


def summarise(
    outcome: Outcome,
    battery: Battery,
    settings: ChargeSettings,
    energy: dict[str, Any],
    reason: str,
    missed: str | None,
) -> list[Quantity]:
    """Return the quantities of a charge, in the order of the table; what it missed only where it missed something."""
    totals, start, end = outcome.book.totals, outcome.start, outcome.run["state"]
    of_path = dict(zip(energy["path"], energy["energy_j"], strict=True))
    net_as = totals[CHARGE_IN] - totals[CHARGE_OUT]
    net_j = totals[ENERGY_IN] - totals[ENERGY_OUT]
    gained_as = (start[DEPTH] - end[DEPTH]) * outcome.cell.charge_as
    scale_j = max(totals[ENERGY_IN], totals[ENERGY_OUT], 1e-9)
    peak_k, run = outcome.book.peak_k[0], outcome.run

    def number(name: str, value: float, unit: str, description: str) -> Quantity:
        return Quantity(name, float(value), None, unit, description)

    return [
        *_marks(outcome, settings),
        number("end_time_s", outcome.end_s, "s", "time at which the charge ended"),
        number("end_soc", 1.0 - end[DEPTH], "1", "state of charge at the end"),
        Quantity("end_reason", None, reason, "", "what ended the charge"),
        *([Quantity("missed", None, missed, "", MISSED)] if missed is not None else []),
        number("charge_in_ah", totals[CHARGE_IN] / 3600, "Ah", "charge put in, discharge pulses not subtracted"),
        number("charge_out_ah", totals[CHARGE_OUT] / 3600, "Ah", "charge taken out by discharge pulses"),
        number("energy_in_wh", totals[ENERGY_IN] / 3600, "Wh", "energy put in, discharge pulses not subtracted"),
        number("energy_out_wh", totals[ENERGY_OUT] / 3600, "Wh", "energy taken out by discharge pulses"),
        number("charge_efficiency", _ratio(gained_as, net_as), "1", "charge gained (SOC) over net charge put in"),
        number(
            "energy_efficiency",
            _ratio(of_path["chemical"], net_j),
            "1",
            "stored chemical energy H(SOC) gained over net electrical energy put in; what discharge pulses "
            "give up outside the battery is not counted as lost",
        ),
        number("peak_temperature_c", peak_k - ZERO_CELSIUS_K, "degC", "highest battery temperature"),
        number("peak_temperature_rise_k", peak_k - start[TEMPERATURE], "K", "highest rise over the ambient"),
        number("end_temperature_c", end[TEMPERATURE] - ZERO_CELSIUS_K, "degC", "battery temperature at the end"),
        number(
            "peak_temperature_rate_k_s",
            _peak_rate_k_s(outcome),
            "K/s",
            "highest rate of the battery temperature, over a sampling interval",
        ),
        number("mean_current_a", _ratio(net_as, outcome.end_s), "A", "net charge put in over time"),
        number("time_at_voltage_limit_s", totals[VOLTAGE_LIMITED_S], "s", "time with the voltage held at its limit"),
        number("time_at_supply_limit_s", totals[SUPPLY_LIMITED_S], "s", "time with the supply at its limit"),
        number("energy_balance_residual", of_path["residual"] / scale_j, "1", "first law's residual over energy in"),
        number("steps", run["steps"], "1", "steps integrated, rejected ones and those of root finding included"),
        number("edges", run["edges"], "1", "segments of the waveform begun"),
        number("control_changes", run["changes"], "1", "changes between current, voltage and supply limit"),
    ]


def _marks(outcome: Outcome, settings: ChargeSettings) -> list[Quantity]:
    rows: list[Quantity] = []
    for mark, (_, time_s, temperature_k) in zip(sorted(settings.soc_marks), outcome.book.marks, strict=True):
        reached = bool(np.isfinite(time_s))
        rise = float(temperature_k - outcome.start[TEMPERATURE])
        rows += [
            Quantity(
                f"time_to_soc_{mark:g}_s",
                float(time_s) if reached else None,
                None,
                "s",
                f"time at which SOC {mark:g} was first reached",
            ),
            Quantity(
                f"temperature_rise_at_soc_{mark:g}_k",
                rise if reached else None,
                None,
                "K",
                f"rise over the ambient when SOC {mark:g} was first reached",
            ),
        ]
    return rows


def _peak_rate_k_s(outcome: Outcome) -> float:
    samples = outcome.book.samples[: outcome.book.filled[0]]
    time = np.concatenate([[0.0], samples[:, 0]])
    temperature = np.concatenate([[outcome.start[TEMPERATURE]], samples[:, 8]])
    return float(np.max(np.diff(temperature) / np.diff(time))) if len(samples) else 0.0


def _ratio(above: float, below: float) -> float:
    return float(above / below) if below else 0.0
