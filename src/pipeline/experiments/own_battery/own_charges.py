"""Measurement: the fitted card in; its charges in every mode, with the uncertainty of the fit, out."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pipeline.cell.records import Battery, resting_voltage_v
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Charge, Task, simulate_many
from pipeline.errors import EngineError, UserError
from pipeline.experiments.own_battery.numbers import with_values
from pipeline.kernel.artefacts import Inputs, Output

QUANTITIES = (
    "end_time_s",
    "end_soc",
    "peak_temperature_rise_k",
    "charge_efficiency",
    "energy_efficiency",
    "energy_in_wh",
)
HEAT = "heat_wh"


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Charge the fitted battery, and every draw from the fit's distribution."""
    with (inputs["own_fit"] / "found.json").open(encoding="utf-8") as file:
        found = json.load(file)
    best = Battery.model_validate(found["card"])
    drawn = list(_drawn(best, inputs.table("own_fit", "samples")))
    charge = ChargeSettings.model_validate(settings["charge"])
    engine = EngineSettings.model_validate(settings["engine"])
    rows: list[tuple[Any, ...]] = []
    notes = list(_outside(found["valid"], best, settings["modes"], charge))
    for name, sheet in settings["modes"].items():
        volts = sheet.get("voltage_v_cell", sheet.get("absorption_v_cell"))
        half = resting_voltage_v(best, 0.5, charge.ambient_c) / best.cells
        if isinstance(volts, int | float) and volts <= half:
            notes.append(
                f"{name}: not charged, since {volts:g} V a cell is no more than the {half:.3g} V that it rests at half "
                "full; own_battery.charge_voltage_v_cell says another"
            )
            continue
        mode = Mode.model_validate(sheet)
        first = _charged([best], mode, charge, engine)[0]
        if isinstance(first, str):
            notes.append(f"{name}: {first}")
            continue
        others = [one for one in _charged(drawn, mode, charge, engine) if not isinstance(one, str)]
        if len(others) < len(drawn):
            notes.append(f"{name}: {len(drawn) - len(others)} of {len(drawn)} draws could not be charged")
        for quantity in (*QUANTITIES, HEAT):
            values = np.array([_number(one, quantity)[0] for one in others])
            values = values[np.isfinite(values)]
            value, unit = _number(first, quantity)
            ends = np.percentile(values, [2.5, 97.5]).tolist() if len(values) >= 2 else [None, None]
            rows.append((name, quantity, unit, value if math.isfinite(value) else None, *ends, len(values)))
    output.rows("charges", rows)
    output.write("notes", {"note": notes})


def _drawn(best: Battery, samples: Mapping[str, Any]) -> Iterator[Battery]:
    """Yield the card of each draw; one that is no battery is left out."""
    for number in sorted(set(samples["sample"].tolist())):
        own = samples["sample"] == number
        values = dict(zip(samples["path"][own].tolist(), samples["value"][own].tolist(), strict=True))
        try:
            yield with_values(best, values)
        except ValueError:
            continue


def _charged(
    cells: Sequence[Battery], mode: Mode, charge: ChargeSettings, engine: EngineSettings
) -> list[Charge | str]:
    """Return the charge of every card, or why there is none."""
    tasks = [Task(one, mode, BENCH, charge, engine) for one in cells]
    try:
        return list(simulate_many(tasks))
    except (UserError, EngineError):
        pass
    found: list[Charge | str] = []
    for task in tasks:
        try:
            found += simulate_many([task], 1)
        except (UserError, EngineError) as error:
            found.append(str(error))
    return found


def _number(charge: Charge, quantity: str) -> tuple[float, str]:
    if quantity == HEAT:
        losses = charge.energy["energy_j"][np.array(charge.energy["role"]) == "loss"]
        return float(losses.sum()) / 3600.0, "Wh"
    row = next(one for one in charge.summary if one.quantity == quantity)
    return (math.nan if row.value is None else float(row.value)), row.unit


def _outside(
    valid: Mapping[str, Sequence[float]], best: Battery, modes: Mapping[str, Any], charge: ChargeSettings
) -> Iterator[str]:
    """Yield where the charges leave what the measurement covered."""
    low, high = valid["soc"]
    if charge.initial_soc < low - 0.02 or high < 0.9:
        yield (
            f"outside the measurement: charges run from a state of charge of {charge.initial_soc:.2f} upwards, and it "
            f"covers {low:.2f} to {high:.2f}"
        )
    cold, warm = valid["temperature_c"]
    if not cold - 3.0 <= charge.ambient_c <= warm + 3.0:
        yield (
            f"outside the measurement: charges run at {charge.ambient_c:g} degC, and it covers {cold:.1f} to "
            f"{warm:.1f} degC"
        )
    for name, sheet in modes.items():
        rate = sheet.get("max_current_c_rate")
        if isinstance(rate, int | float) and rate > 1.05 * valid["c_rate"][1]:
            yield f"outside the measurement: {name} charges at {rate:g}C, and it covers up to {valid['c_rate'][1]:.2g}C"
