"""The common model, what every peer can compute: U(SOC), R0, two pairs, one temperature; and its exact solution.

The numbers are those of `conf/battery/lead_acid_12v7ah.yaml` without its acceptance, side reaction and entropy, with
the series resistance of SOC 1/2. Voltages, resistances and heat are the battery's, not a cell's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchmarks.sheets import FREQUENCY_HZ, load
from pipeline.cell.records import Battery
from pipeline.charge.records import Mode

KELVIN = 273.15


class Pair(NamedTuple):
    """A resistor [ohm] beside a capacitor, by its time constant [s]."""

    resistance_ohm: float
    time_constant_s: float


class Model(NamedTuple):
    """U = full_v + slope_v (1 - SOC), R0, two pairs, one lump at a temperature."""

    capacity_as: float
    full_v: float
    slope_v: float
    series_ohm: float
    fast: Pair
    slow: Pair
    heat_capacity_j_k: float
    thermal_k_w: float
    ambient_k: float


class Pulses(NamedTuple):
    """Reflex: charge, discharge, rest, from a state of charge at equilibrium and at the ambient's temperature."""

    period_s: float
    charge_a: float
    charge_s: float
    discharge_a: float
    discharge_s: float
    seconds: float
    initial_soc: float

    @property
    def segments(self) -> tuple[tuple[float, float], ...]:
        """Return current [A] and length [s] of the parts of a period."""
        rest_s = self.period_s - self.charge_s - self.discharge_s
        return (self.charge_a, self.charge_s), (-self.discharge_a, self.discharge_s), (0.0, rest_s)

    @property
    def periods(self) -> int:
        """Return the number of whole periods."""
        return round(self.seconds / self.period_s)


class End(NamedTuple):
    """State at the end: SOC, voltages of the pairs [V], temperature [K], energy put in less taken out [J]."""

    soc: float
    fast_v: float
    slow_v: float
    temperature_k: float
    energy_j: float = math.nan


def battery() -> Battery:
    """Return the common model as this project's record, a cell of six."""
    sheet = load("battery/lead_acid_12v7ah.yaml")
    kept = ("cells_in_series", "capacity_ah", "open_circuit_voltage_v", "pairs", "thermal")
    constant, slope = sheet["series_resistance_ohm"]["polynomial"]
    own = {"name": "common", "title": "Common model", "series_resistance_ohm": constant + 0.5 * slope}
    return Battery(**({key: sheet[key] for key in kept} | own))


def model(record: Battery, ambient_k: float = 25.0 + KELVIN) -> Model:
    """Return the numbers of the common model, from the record that our engine takes."""
    cells = record.cells_in_series
    full_v, slope_v = record.open_circuit_voltage_v.polynomial  # type: ignore[union-attr]
    fast, slow = (
        Pair(cells * pair.resistance_ohm, pair.time_constant_s)  # type: ignore[operator]
        for pair in record.pairs.values()
    )
    return Model(
        3600.0 * record.capacity_ah, cells * full_v, cells * slope_v,
        cells * record.series_resistance_ohm,  # type: ignore[operator]
        fast, slow, record.thermal.heat_capacity_j_k, record.thermal.resistance_k_w, ambient_k,
    )  # fmt: skip


def pulses(mode: Mode, seconds: float, initial_soc: float, frequency_hz: float = FREQUENCY_HZ) -> Pulses:
    """Return the waveform of a Reflex sheet in seconds."""
    knobs, period_s = mode.knobs, 1.0 / frequency_hz
    return Pulses(
        period_s, float(knobs["charge_a"]), float(knobs["charge_share"]) * period_s, float(knobs["discharge_a"]),
        float(knobs["discharge_share"]) * period_s, seconds, initial_soc,
    )  # fmt: skip


def exact(m: Model, p: Pulses, stored_is_heat: bool = False) -> End:
    """Return the exact end of whole periods, segment by segment in closed form.

    Arguments
    ---------
    stored_is_heat : count i v of a pair as its heat, as PyBaMM's Thevenin model does, instead of v^2 / R.
    """
    x, fast_v, slow_v, warmer, energy = 1.0 - p.initial_soc, 0.0, 0.0, 0.0, 0.0
    cooling = 1.0 / (m.thermal_k_w * m.heat_capacity_j_k)
    for _ in range(p.periods):
        for current, length in p.segments:
            middle = m.full_v + m.slope_v * (x - 0.5 * current * length / m.capacity_as)
            energy += current * length * (middle + current * m.series_ohm)
            # Heat is a sum of exponentials, as (size [W], rate [1/s]).
            heat = [(current * current * m.series_ohm, 0.0)]
            ends = []
            for pair, before in ((m.fast, fast_v), (m.slow, slow_v)):
                settled, rate = current * pair.resistance_ohm, 1.0 / pair.time_constant_s
                gap = before - settled
                left = math.exp(-length * rate)
                energy += current * (settled * length + gap * (1.0 - left) / rate)
                if stored_is_heat:
                    heat += [(current * settled, 0.0), (current * gap, rate)]
                else:
                    heat += [
                        (settled * settled / pair.resistance_ohm, 0.0),
                        (2.0 * settled * gap / pair.resistance_ohm, rate),
                        (gap * gap / pair.resistance_ohm, 2.0 * rate),
                    ]
                ends.append(settled + gap * left)
            warmer *= math.exp(-cooling * length)
            for size, rate in heat:
                # (exp(-b t) - exp(-a t)) / (a - b), without cancellation.
                apart = (rate - cooling) * length
                warmer += (
                    size / m.heat_capacity_j_k * math.exp(-cooling * length) * -math.expm1(-apart) / apart * length
                )
            x -= current * length / m.capacity_as
            fast_v, slow_v = ends
    return End(1.0 - x, fast_v, slow_v, m.ambient_k + warmer, energy)


def error(found: End, expected: End) -> float:
    """Return the largest relative error of SOC and of the pairs' voltages; temperature is told apart."""
    return max(abs(got / want - 1.0) for got, want in zip(found[:3], expected[:3], strict=True))


def temperature_error(found: End, expected: End, ambient_k: float) -> float:
    """Return the error of the rise in temperature, relative."""
    return abs((found.temperature_k - expected.temperature_k) / (expected.temperature_k - ambient_k))
