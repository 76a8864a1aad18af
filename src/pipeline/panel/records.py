"""What a panel's data sheet, the weather and a set of curves are; light to import."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, model_validator

from pipeline.record import Record

REFERENCE_IRRADIANCE_W_M2 = 1000.0
REFERENCE_TEMPERATURE_C = 25.0

Irradiance = Annotated[float, Field(gt=0, le=2000, description="plane-of-array irradiance [W/m2]")]
CellTemperature = Annotated[float, Field(ge=-60, le=120, description="temperature of the panel's cells [degC]")]


DatabaseName: TypeAlias = Literal["cec", "sandia"]
"""The databases in which panels are known by name."""


class SingleDiodeCard(Record):
    """Parameters of the single-diode model of one panel, where they are known and not fitted to the data sheet."""

    photocurrent_a: float = Field(gt=0, description="light-generated current I_L [A]")
    saturation_current_a: float = Field(gt=0, description="diode saturation current I_0 [A]")
    series_resistance_ohm: float = Field(ge=0, description="series resistance R_s [ohm]")
    shunt_resistance_ohm: float = Field(gt=0, description="shunt resistance R_sh [ohm]")
    modified_ideality_v: float = Field(gt=0, description="modified ideality factor a = n N_s k T / q [V]")
    adjust_percent: float = Field(description="adjustment of the temperature coefficients, as in the CEC model [%]")


class Panel(Record):
    """A panel as its data sheet gives it, at 1000 W/m2, AM 1.5 and 25 degC."""

    title: str = Field(min_length=1, description="name of the panel, for people")
    max_power_w: float = Field(gt=0, description="maximum power as printed, which the sheet rounds [W]")
    max_power_voltage_v: float = Field(gt=0, description="voltage at maximum power [V]")
    max_power_current_a: float = Field(gt=0, description="current at maximum power [A]")
    open_circuit_voltage_v: float = Field(gt=0, description="open-circuit voltage [V]")
    short_circuit_current_a: float = Field(gt=0, description="short-circuit current [A]")
    alpha_isc_a_per_k: float = Field(description="temperature coefficient of the short-circuit current [A/K]")
    beta_voc_v_per_k: float = Field(lt=0, description="temperature coefficient of the open-circuit voltage [V/K]")
    gamma_pmp_percent_per_k: float = Field(lt=0, description="temperature coefficient of the maximum power [%/K]")
    cells_in_series: int = Field(ge=1, description="cells in series in one panel [1]")
    panels_in_series: int = Field(default=1, ge=1, description="panels in series [1]")
    panels_in_parallel: int = Field(default=1, ge=1, description="strings of panels in parallel [1]")

    single_diode: SingleDiodeCard | None = Field(default=None, description="model of one panel; fitted where not given")

    @model_validator(mode="after")
    def _possible(self) -> Panel:
        if self.max_power_voltage_v >= self.open_circuit_voltage_v:
            raise ValueError(
                f"max_power_voltage_v is {self.max_power_voltage_v:g} V; it must lie below "
                f"open_circuit_voltage_v, {self.open_circuit_voltage_v:g} V"
            )
        if self.max_power_current_a >= self.short_circuit_current_a:
            raise ValueError(
                f"max_power_current_a is {self.max_power_current_a:g} A; it must lie below "
                f"short_circuit_current_a, {self.short_circuit_current_a:g} A"
            )
        product_w = self.max_power_voltage_v * self.max_power_current_a
        if abs(product_w / self.max_power_w - 1.0) > 0.05:
            raise ValueError(
                f"max_power_w is {self.max_power_w:g} W, but max_power_voltage_v x max_power_current_a is "
                f"{product_w:g} W; the two may differ by 5 %"
            )
        return self

    @property
    def string_voltage_v(self) -> float:
        """Return the voltage of all panels at maximum power [V], as the boost converter sees it."""
        return self.max_power_voltage_v * self.panels_in_series

    def approximate_power_w(self, irradiance_w_m2: float, cell_temperature_c: float) -> float:
        """Return the maximum power by the data sheet's coefficients alone, for checks that must be quick.

        Arguments
        ---------
        irradiance_w_m2 : plane-of-array irradiance [W/m2].
        cell_temperature_c : temperature of the panel's cells [degC].

        Returns
        -------
        Power of all panels [W], proportional to irradiance and linear in temperature.
        """
        panels = self.panels_in_series * self.panels_in_parallel
        reference_w = self.max_power_voltage_v * self.max_power_current_a * panels
        rise = self.gamma_pmp_percent_per_k / 100.0 * (cell_temperature_c - REFERENCE_TEMPERATURE_C)
        return max(0.0, reference_w * irradiance_w_m2 / REFERENCE_IRRADIANCE_W_M2 * (1.0 + rise))


class ConstantWeather(Record):
    """The same irradiance and cell temperature all the time."""

    kind: Literal["constant"] = "constant"
    title: str = Field(min_length=1, description="name of the weather, for people")
    irradiance_w_m2: Irradiance
    cell_temperature_c: CellTemperature


Weather: TypeAlias = ConstantWeather
"""Every kind of weather there is; further kinds join as a union told apart by `kind`."""


class PanelCurveSettings(Record):
    """The grid over which the panel's curves are drawn."""

    irradiances_w_m2: tuple[Irradiance, ...] = Field(
        default=(200.0, 400.0, 600.0, 800.0, 1000.0), min_length=1, description="irradiances [W/m2]"
    )
    cell_temperatures_c: tuple[CellTemperature, ...] = Field(
        default=(0.0, 25.0, 50.0, 75.0), min_length=1, description="cell temperatures [degC]"
    )
    points_per_curve: int = Field(default=151, ge=11, le=10_001, description="points of each curve [1]")

    @model_validator(mode="after")
    def _increasing(self) -> PanelCurveSettings:
        for name in ("irradiances_w_m2", "cell_temperatures_c"):
            values = getattr(self, name)
            if list(values) != sorted(set(values)):
                raise ValueError(f"{name} is {list(values)}; it must increase from each value to the next")
        return self
