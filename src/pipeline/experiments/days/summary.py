"""What came of a day in single numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pipeline.bus.flows import ENDED, Available, flows, state_at
from pipeline.converter.records import PowerChain
from pipeline.day.charge import DayCharge
from pipeline.day.sunlight import Sunlight
from pipeline.experiments.days.numbers import DAY_NUMBERS, STAGES
from pipeline.quantity import Quantity

Columns = dict[str, Any]
_columns_JOULE_PER_WH = 3600.0
# What a current of nothing but rounding takes out.
_ROUNDING_W = 1e-9


def trace(charge: DayCharge, sun: Sunlight, chain: PowerChain, clock_s: float) -> Columns:
    """Return the columns of the trace.

    Arguments
    ---------
    charge, sun : the day, with its battery and without.
    chain : the converters.
    clock_s : local time at time 0 [s].
    """
    engine = charge.trace
    end_s = engine["Test Time / s"]
    interval_s = np.diff(end_s, prepend=0.0)
    start_s = end_s - interval_s

    def mean_w(name: str) -> Any:
        return np.diff(engine[name], prepend=0.0) * _columns_JOULE_PER_WH / interval_s

    edges_s = np.append(sun.time_s, sun.time_s[-1] + sun.interval_s[-1])

    def mean(of: Any) -> Any:
        passed = np.append(0.0, np.cumsum(of * sun.interval_s))
        return (np.interp(end_s, edges_s, passed) - np.interp(start_s, edges_s, passed)) / interval_s

    could = Available(*(mean(part) for part in sun.could))
    discharge_w = mean_w("Discharging Energy / Wh")
    did = flows(
        mean_w("Charging Energy / Wh"),
        np.where(discharge_w > _ROUNDING_W, discharge_w, 0.0),
        could,
        chain,
        mean(sun.panel_voltage_v),
    )
    return {
        "time_s": end_s,
        "clock_s": end_s + clock_s,
        "interval_s": interval_s,
        "state": state_at(charge.changes, 0.5 * (start_s + end_s)),
        "irradiance_w_m2": mean(sun.irradiance_w_m2),
        "cell_temperature_c": mean(sun.cell_temperature_c),
        "ambient_c": mean(sun.ambient_c),
        "reference_w": mean(sun.reference_w),
        "panel_w": could.panel_w,
        "tracked_w": could.tracked_w,
        "drawn_w": did.drawn_w,
        "curtailed_w": did.curtailed_w,
        "bus_w": did.bus_w,
        "load_w": could.load_w,
        "served_w": could.served_w,
        "buck_w": did.buck_w,
        "available_w": could.battery_w,
        "charge_w": did.charge_w,
        "discharge_w": did.discharge_w,
        "current_a": engine["Current / A"],
        "voltage_v": engine["Voltage / V"],
        "soc": engine["soc"],
        "temperature_c": engine["Surface Temperature / degC"],
        "supply_limited_share": engine["supply_limited_share"],
        "voltage_limited_share": engine["voltage_limited_share"],
    }


def switching(charge: DayCharge, clock_s: float) -> Columns:
    """Return the columns of the switchings."""
    changes = charge.changes
    return {
        "time_s": [change.time_s for change in changes],
        "clock_s": [change.time_s + clock_s for change in changes],
        "before": [change.before for change in changes],
        "after": [change.after for change in changes],
        "reason": [change.reason for change in changes],
        "s2_share": [change.closed.s2 for change in changes],
        "s3_share": [change.closed.s3 for change in changes],
        "s4_share": [change.closed.s4 for change in changes],
        "pulses_hz": [change.pulses_hz for change in changes],
    }


class Stage(NamedTuple):
    """A part of the sun's energy."""

    stage: str
    role: str
    energy_j: float
    description: str


def stages(found: Columns, charge: DayCharge) -> list[Stage]:
    """Return where the energy goes; all after the first add up to the first.

    Arguments
    ---------
    found : the columns of the trace.
    charge : the day's battery; what its first law leaves over counts among its heat.
    """
    of_path = dict(zip(charge.energy["path"], charge.energy["energy_j"], strict=True))

    def energy(name: str) -> float:
        return float(np.sum(found[name] * found["interval_s"]))

    stored = float(of_path["chemical"])
    energies = {
        "sun": energy("reference_w"),
        "panel": energy("reference_w") - energy("panel_w"),
        "tracker": energy("panel_w") - energy("tracked_w"),
        "curtailed": energy("curtailed_w"),
        "boost": energy("drawn_w") - energy("bus_w"),
        "load": energy("served_w"),
        "buck": energy("buck_w") - energy("charge_w"),
        "resistor": energy("discharge_w"),
        "battery": energy("charge_w") - energy("discharge_w") - stored,
        "stored": stored,
    }
    return [Stage(stage, role, energies[stage], words) for stage, (role, words) in STAGES.items()]


_JOULE_PER_WH = 3600.0


def quantities(charge: DayCharge, found: Columns, parts: Sequence[Stage]) -> list[Quantity]:
    """Return the named numbers of a day.

    Arguments
    ---------
    charge : the battery's day.
    found : the columns of the trace.
    parts : the stages from sun to battery.
    """
    energy = {part.stage: part.energy_j for part in parts}
    whole_j = max(energy["sun"], 1.0)
    ended = [change.time_s for change in charge.changes if change.after == ENDED]
    unserved = float(np.sum((found["load_w"] - found["served_w"]) * found["interval_s"]))
    clock_s = float(found["clock_s"][0] - found["time_s"][0])
    residual_j = float(charge.energy["energy_j"][list(charge.energy["path"]).index("residual")])
    values = {
        "end_soc": charge.end_soc,
        "ended_s": ended[0] if ended else np.nan,
        "ended_clock_s": ended[0] + clock_s if ended else np.nan,
        "charging_s": charge.charging_s,
        "current_limited_s": charge.current_limited_s,
        "voltage_limited_s": charge.voltage_limited_s,
        "supply_limited_s": charge.supply_limited_s,
        "charge_in_ah": charge.charge_in_ah,
        "charge_out_ah": charge.charge_out_ah,
        "peak_temperature_c": charge.peak_temperature_c,
        "end_temperature_c": charge.end_temperature_c,
        "switchings": len(charge.changes) - 1,
        **{f"{part.stage}_wh": part.energy_j / _JOULE_PER_WH for part in parts},
        "unserved_wh": unserved / _JOULE_PER_WH,
        "most_above_available_w": float(np.max(found["charge_w"] - found["available_w"])),
        "energy_balance_residual": residual_j / whole_j,
        "steps": charge.steps,
    }
    return [DAY_NUMBERS.quantity(name, value) for name, value in values.items()]
