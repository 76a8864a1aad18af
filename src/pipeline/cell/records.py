"""A battery as its data sheet would give it: the schema of `conf/battery/*.yaml`."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Iterator
from itertools import pairwise
from typing import Self

from pydantic import Field, field_validator, model_validator

from pipeline.record import Record


class Polynomial(Record):
    """A polynomial in the depth of discharge, 1 - SOC."""

    polynomial: list[float] = Field(min_length=1, max_length=4, description="coefficients of (1 - SOC)^0, ^1, ...")


class Logarithm(Record):
    """`constant + factor ln((SOC + soc_offset) / (1 - SOC + depth_offset))`, the shape of a Nernst potential."""

    constant: float = Field(description="value where the logarithm is zero")
    factor: float = Field(description="factor of the logarithm")
    soc_offset: float = Field(ge=0, description="keeps the empty end finite [1]")
    depth_offset: float = Field(ge=0, description="keeps the full end finite; 0 makes full charge an equilibrium [1]")


class Root(Record):
    """`factor sqrt((1 - SOC)(SOC + soc_offset))`, the shape of an exchange current."""

    factor: float = Field(gt=0, description="factor of the root")
    soc_offset: float = Field(ge=0, description="keeps the empty end above zero [1]")


class Shepherd(Record):
    """`full_v - polarisation_v x / (1 - x)` with x = 1 - SOC: Shepherd's potential, without bound below when empty."""

    full_v: float = Field(description="value when full [V]")
    polarisation_v: float = Field(ge=0, description="how far it has fallen at SOC 1/2 [V]")


class Inverse(Record):
    """`factor / (1 - SOC + depth_offset)`, the shape of a polarisation resistance on charge."""

    factor: float = Field(gt=0, description="numerator; near the value when empty")
    depth_offset: float = Field(ge=0, description="how far beyond full the pole lies [1]")


MOST_POINTS = 512


class Tabulated(Record):
    """Values on a grid of SOC, joined by monotone cubics (PCHIP); a grid that reaches beyond 0 or 1 is cut there."""

    soc: list[float] = Field(min_length=3, max_length=MOST_POINTS, description="grid over 0 to 1, rising [1]")
    value: list[float] = Field(min_length=3, max_length=MOST_POINTS, description="value at each grid point")
    scale: float = Field(1.0, description="factor of every value [1]")

    @model_validator(mode="after")
    def _grid(self) -> Self:
        if len(self.soc) != len(self.value):
            raise ValueError(f"soc has {len(self.soc)} points but value has {len(self.value)}; both need the same")
        if self.soc[0] > 0.0 or self.soc[-1] < 1.0:
            raise ValueError(f"soc runs from {self.soc[0]:g} to {self.soc[-1]:g}; it must run from 0 to 1")
        if any(after <= before for before, after in zip(self.soc, self.soc[1:], strict=False)):
            raise ValueError("soc must rise from point to point")
        if len(self.inside[0]) < 3:
            raise ValueError("soc has no point between 0 and 1; give at least one")
        return self

    @property
    def outside(self) -> list[float]:
        """Return the points of the grid beyond 0 and 1, which are cut off."""
        return [soc for soc in self.soc if not 0.0 <= soc <= 1.0]

    @property
    def inside(self) -> tuple[list[float], list[float]]:
        """Return the grid from 0 to 1 and the values on it; where it is cut, an edge is on the line between two."""
        kept = [(soc, value) for soc, value in zip(self.soc, self.value, strict=True) if 0.0 < soc < 1.0]
        points = [(0.0, self.on_line(0.0)), *kept, (1.0, self.on_line(1.0))]
        return [soc for soc, _ in points], [value for _, value in points]

    def on_line(self, soc: float) -> float:
        """Return the unscaled value at an SOC on the straight line between two points of the grid."""
        after = max(1, bisect_left(self.soc, soc))
        if soc == self.soc[after] or soc == self.soc[after - 1]:
            return self.value[after if soc == self.soc[after] else after - 1]
        share = (soc - self.soc[after - 1]) / (self.soc[after] - self.soc[after - 1])
        return self.value[after - 1] + share * (self.value[after] - self.value[after - 1])


Curve = float | Polynomial | Logarithm | Root | Shepherd | Inverse | Tabulated
"""A quantity that may depend on SOC; a number is a constant."""


def value_of(curve: Curve, soc: float) -> float:
    """Return a curve's value at a state of charge; a table is read by straight lines, near enough for a check."""
    depth = 1.0 - soc
    if isinstance(curve, float | int):
        return float(curve)
    if isinstance(curve, Polynomial):
        return sum(coefficient * depth**power for power, coefficient in enumerate(curve.polynomial))
    if isinstance(curve, Logarithm):
        above, below = soc + curve.soc_offset, depth + curve.depth_offset
        if above <= 0.0:
            return -math.copysign(math.inf, curve.factor)
        return curve.constant + curve.factor * math.log(above / below) if below > 0.0 else math.inf
    if isinstance(curve, Root):
        return curve.factor * math.sqrt(depth * (soc + curve.soc_offset))
    if isinstance(curve, Shepherd):
        return curve.full_v - curve.polarisation_v * depth / soc if soc > 0.0 else -math.inf
    if isinstance(curve, Inverse):
        return curve.factor / (depth + curve.depth_offset) if depth + curve.depth_offset > 0.0 else math.inf
    return curve.scale * curve.on_line(min(max(soc, 0.0), 1.0))


class Arrhenius(Record):
    """`exp(E / R (1 / T - 1 / T_reference))`, what a resistance is multiplied by: more in the cold for E above 0."""

    activation_energy_j_mol: float = Field(ge=-2e5, le=2e5, description="activation energy E [J/mol]")
    reference_temperature_c: float = Field(
        25.0, gt=-100, le=200, description="temperature at which the factor is 1 [degC]"
    )


MOST_TEMPERATURES = 32


class Factors(Record):
    """Factors on a grid of temperatures, joined by monotone cubics (PCHIP), constant beyond its ends."""

    temperature_c: list[float] = Field(
        min_length=2, max_length=MOST_TEMPERATURES, description="grid, rising, above absolute zero [degC]"
    )
    factor: list[float] = Field(
        min_length=2, max_length=MOST_TEMPERATURES, description="what the resistance is multiplied by [1]"
    )

    @model_validator(mode="after")
    def _grid(self) -> Self:
        grid, factor = self.temperature_c, self.factor
        if len(grid) != len(factor):
            raise ValueError(f"temperature_c has {len(grid)} points but factor has {len(factor)}; both need the same")
        if grid[0] <= -273.15 or any(after <= before for before, after in pairwise(grid)):
            raise ValueError("temperature_c must rise from point to point, from above -273.15")
        if min(factor) <= 0.0:
            raise ValueError(f"factor has {min(factor):g}; each must be greater than 0")
        return self


Warmth = Arrhenius | Factors
"""How a resistance depends on temperature."""


class Pair(Record):
    """A resistor beside a capacitor; the time constant is fixed, so the capacitance follows the resistance.

    `tau dv/dt = R(s) f(T) i - v`, `C = tau / (R(s) f(T))`: what is stored, C v^2 / 2, changes with temperature too.
    """

    resistance_ohm: Curve = Field(description="resistance per cell [ohm]")
    time_constant_s: float = Field(gt=0, description="time constant [s]")
    resistance_temperature: Warmth | None = Field(None, description="factor f(T) of the resistance; none: 1")


class Acceptance(Record):
    """What the plates accept near full: a pair whose resistance is `resistance_ohm / (1 - SOC)`."""

    resistance_ohm: float = Field(gt=0, description="resistance per cell at SOC 0 [ohm]")
    time_constant_s: float = Field(gt=0, description="time constant [s]")
    resistance_temperature: Warmth | None = Field(None, description="factor f(T) of the resistance; none: 1")


class ChargeTransfer(Record):
    """Overpotential of the main reaction, `(2RT/F) asinh(i / 2 i0)`."""

    exchange_current_a: Curve = Field(description="exchange current i0 [A]")


class SideReaction(Record):
    """Gas evolution beside the main reaction, `current_a exp((V - reference_voltage_v) / V_s + k(T))`."""

    current_a: float = Field(gt=0, description="current at the reference voltage and temperature [A]")
    reference_voltage_v: float = Field(gt=0, description="voltage per cell at which it takes current_a [V]")
    voltage_scale_v: float | None = Field(None, gt=0, description="V_s, rise in voltage per factor e [V]")
    thermal_voltages: float | None = Field(None, gt=0, description="V_s in units of R T / F, instead of fixed [1]")
    temperature_coefficient_per_k: float = Field(0.0, description="k(T) per kelvin above the reference [1/K]")
    activation_energy_j_mol: float = Field(0.0, ge=0, description="Arrhenius part of k(T) [J/mol]")
    reference_temperature_c: float = Field(25.0, gt=-100, description="temperature at which k(T) is zero [degC]")
    recombination_time_constant_s: float = Field(0.0, ge=0, description="lag of recombination; 0 is at once [s]")
    gas_voltage_v: float = Field(0.0, ge=0, description="energy per charge of gas not yet recombined [V]")

    @model_validator(mode="after")
    def _scale(self) -> Self:
        if (self.voltage_scale_v is None) == (self.thermal_voltages is None):
            raise ValueError("give either voltage_scale_v or thermal_voltages")
        return self


class Thermal(Record):
    """The battery as one lump."""

    heat_capacity_j_k: float = Field(gt=0, description="heat capacity of the battery [J/K]")
    resistance_k_w: float = Field(gt=0, description="thermal resistance to the ambient [K/W]")


class Hysteresis(Record):
    """A part of the stored potential that follows the direction of the current, the exponential zone of a battery.

    It moves with the charge `q` that passes: towards `amplitude_v` while charging,
    `h = A - (A - h0) exp(-B q)`, and towards zero while discharging, `h = h0 exp(-B q)`.
    """

    amplitude_v: float = Field(gt=0, description="value A after long charging, per cell; 0 after long discharging [V]")
    rate_per_ah: float = Field(gt=0, description="rate B at which it follows the charge that passes [1/Ah]")
    initial_share: float = Field(
        0.0, ge=0, le=1, description="value at the start in units of the amplitude: 0 comes from a discharge [1]"
    )


class Battery(Record):
    """Cells in series at one temperature; every circuit value is per cell, the thermal ones per battery."""

    name: str = Field(min_length=1, description="identifier")
    title: str = Field(min_length=1, description="readable name")
    cells_in_series: int = Field(ge=1, description="number of cells in series [1]")
    capacity_ah: float = Field(gt=0, description="capacity for which the values below hold [Ah]")
    scaled_to_capacity_ah: float | None = Field(
        None, gt=0, description="capacity of the battery in use: the same cell with more or less plate area [Ah]"
    )
    open_circuit_voltage_v: Curve = Field(description="open-circuit voltage per cell at 25 degC [V]")
    entropic_coefficient_v_k: Curve = Field(0.0, description="dU/dT per cell [V/K]")
    thermoneutral_voltage_v: float | None = Field(
        None, gt=0, description="measured enthalpy per charge, used for heat instead of U - T dU/dT [V]"
    )
    series_resistance_ohm: Curve = Field(description="series resistance per cell [ohm]")
    series_resistance_temperature: Warmth | None = Field(
        None, description="factor f(T) of the series resistance; none: 1"
    )
    pairs: dict[str, Pair] = Field(default_factory=dict, max_length=6, description="pairs by name")
    acceptance: Acceptance | None = Field(None, description="acceptance pair; none where absent")
    charge_transfer: ChargeTransfer | None = Field(None, description="charge transfer; none where absent")
    side_reaction: SideReaction | None = Field(None, description="side reaction; none where absent")
    hysteresis: Hysteresis | None = Field(None, description="exponential zone; none where absent")
    thermal: Thermal = Field(description="thermal values")
    usual_c_rate: tuple[float, float] | None = Field(
        None, description="lowest and highest current it is usually charged with, over the capacity [C-rate]"
    )
    cells_in_unit: int = Field(
        1,
        ge=1,
        le=1000,
        description="electrochemical cells inside each of `cells_in_series` where a model knows only the block; what a "
        "sheet gives per cell is multiplied by both [1]",
    )

    @field_validator("usual_c_rate")
    @classmethod
    def _rising(cls, rates: tuple[float, float] | None) -> tuple[float, float] | None:
        if rates is not None and not 0.0 <= rates[0] < rates[1]:
            raise ValueError(f"{rates[0]:g} to {rates[1]:g}; allowed is a range that rises, from 0 or more")
        return rates

    @model_validator(mode="after")
    def _physical(self) -> Self:
        for fault in faults(self):
            raise ValueError(fault)
        return self

    @property
    def scale(self) -> float:
        """Return the number of cells in parallel that the scaled battery stands for, not necessarily whole."""
        return 1.0 if self.scaled_to_capacity_ah is None else self.scaled_to_capacity_ah / self.capacity_ah

    @property
    def fills(self) -> bool:
        """Tell whether a held voltage charges it to SOC 1 in finite time: no part of it has a pole there."""
        curves = (self.open_circuit_voltage_v, *(pair.resistance_ohm for pair in self.pairs.values()))
        pole = any(isinstance(curve, Logarithm | Inverse) and curve.depth_offset == 0.0 for curve in curves)
        return self.acceptance is None and not pole

    @property
    def warmths(self) -> list[Warmth | None]:
        """Return how series resistance, each pair, and the acceptance pair if there is one depend on temperature."""
        pairs = [pair.resistance_temperature for pair in self.pairs.values()]
        acceptance = [self.acceptance.resistance_temperature] if self.acceptance else []
        return [self.series_resistance_temperature, *pairs, *acceptance]

    @property
    def cells(self) -> int:
        """Return the number of electrochemical cells in series, by which what is given per cell is multiplied."""
        return self.cells_in_series * self.cells_in_unit

    @property
    def capacity_in_use_ah(self) -> float:
        """Return the capacity after scaling [Ah]."""
        return self.capacity_ah * self.scale


def curves_of(battery: Battery) -> Iterator[tuple[str, Curve]]:
    """Yield the key below the battery and the curve of everything in it that may depend on SOC."""
    yield "open_circuit_voltage_v", battery.open_circuit_voltage_v
    yield "entropic_coefficient_v_k", battery.entropic_coefficient_v_k
    yield "series_resistance_ohm", battery.series_resistance_ohm
    for name, pair in battery.pairs.items():
        yield f"pairs.{name}.resistance_ohm", pair.resistance_ohm
    if battery.charge_transfer is not None:
        yield "charge_transfer.exchange_current_a", battery.charge_transfer.exchange_current_a


def cuts(battery: Battery) -> Iterator[str]:
    """Yield a sentence for each table with points beyond SOC 0 or 1: the key below the battery, and the points."""
    for key, curve in curves_of(battery):
        if isinstance(curve, Tabulated) and curve.outside:
            points = ", ".join(f"{soc:g}" for soc in curve.outside)
            yield f"{key}.soc: SOC {points} lies outside 0 to 1 and is left out; the edges are interpolated"


def resting_voltage_v(battery: Battery, soc: float, temperature_c: float) -> float:
    """Return the open-circuit voltage of a battery [V].

    Arguments
    ---------
    soc : state of charge [1].
    temperature_c : temperature [degC].
    """
    entropic = value_of(battery.entropic_coefficient_v_k, soc) * (temperature_c - 25.0)
    return battery.cells_in_series * (value_of(battery.open_circuit_voltage_v, soc) + entropic)


_GRID = tuple(n / 100 for n in range(101))
_REFERENCE_K = 298.15


def faults(battery: Battery) -> Iterator[str]:
    """Yield what is not physical about a battery's curves: key, value, where, and what is allowed.

    Resistances may not be negative, exchange currents must be positive; the potential of a full cell must be positive,
    no lower than that of a half-full one, and larger than the share of it that is entropy.
    """
    yield from _low("series_resistance_ohm", battery.series_resistance_ohm, "ohm")
    for name, pair in battery.pairs.items():
        yield from _low(f"pairs.{name}.resistance_ohm", pair.resistance_ohm, "ohm")
    if battery.charge_transfer is not None:
        inside = [value_of(battery.charge_transfer.exchange_current_a, soc) for soc in _GRID[1:-1]]
        if min(inside) <= 0.0:
            soc = _GRID[1:-1][inside.index(min(inside))]
            key = "charge_transfer.exchange_current_a"
            yield f"{key} is {min(inside):g} A at SOC {soc:g}; it must be greater than 0"
    full, half = (value_of(battery.open_circuit_voltage_v, soc) for soc in (0.99, 0.5))
    if half <= 0.0 or full < half:
        yield (
            f"open_circuit_voltage_v is {half:g} V at SOC 0.5 and {full:g} V at SOC 0.99; "
            "it must be greater than 0 and may not fall while charging"
        )
    entropy = max((abs(value_of(battery.entropic_coefficient_v_k, soc)) for soc in _GRID[1:-1]), default=0.0)
    if half > 0.0 and entropy * _REFERENCE_K >= half:
        yield (
            f"entropic_coefficient_v_k comes to {entropy:g} V/K; allowed is less than {half / _REFERENCE_K:.3g} V/K, "
            "the potential over the temperature"
        )


def _low(key: str, curve: Curve, unit: str) -> Iterator[str]:
    grid = curve.inside[0] if isinstance(curve, Tabulated) else _GRID
    lowest, soc = min((value_of(curve, soc), soc) for soc in grid)
    if lowest < 0.0:
        yield f"{key} is {lowest:g} {unit} at SOC {soc:g}; it must be 0 or greater"
