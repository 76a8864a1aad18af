"""What charges are fed from: the panel, its weather, the converters and the load on the bus."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from pipeline.converter import records as converters
from pipeline.converter.records import Load, PowerChain
from pipeline.errors import UserError
from pipeline.experiments.supply.named_panel import by_name
from pipeline.files.content import settings
from pipeline.files.load import check_weather
from pipeline.files.weather import told
from pipeline.kernel.draft import plain
from pipeline.kernel.experiment import Effort, Experiment, Label, Node, Step
from pipeline.kernel.tables import NOTES, Column, Table, TableFile
from pipeline.panel.database import PanelEntry
from pipeline.panel.records import (
    REFERENCE_IRRADIANCE_W_M2,
    REFERENCE_TEMPERATURE_C,
    ConstantWeather,
    Panel,
    PanelCurveSettings,
)
from pipeline.record import NOT_GIVEN, Record
from pipeline.weather.records import Weather

_IRRADIANCE = Column("irradiance_w_m2", "W/m2", "plane-of-array irradiance")
_CELL_TEMPERATURE = Column("cell_temperature_c", "degC", "temperature of the panel's cells")
PANEL_PARAMETERS = Table(
    "panel_parameters",
    "Single-diode parameters at 1000 W/m2 and 25 degC, fitted to the data sheet",
    (
        Column("photocurrent_a", "A", "light-generated current I_L"),
        Column("saturation_current_a", "A", "diode saturation current I_0"),
        Column("series_resistance_ohm", "ohm", "series resistance R_s"),
        Column("shunt_resistance_ohm", "ohm", "shunt resistance R_sh"),
        Column("modified_ideality_v", "V", "modified ideality factor a = n N_s k T / q"),
        Column("adjust_percent", "%", "adjustment of the temperature coefficients, as in the CEC model"),
        Column("fit_residual", "1", "largest relative deviation of the six fitted equations"),
    ),
)
PANEL_CURVES = Table(
    "panel_curves",
    "Current-voltage curves, from short circuit to open circuit",
    (
        _IRRADIANCE,
        _CELL_TEMPERATURE,
        Column("voltage_v", "V", "panel voltage"),
        Column("current_a", "A", "panel current"),
        Column("power_w", "W", "panel power"),
    ),
)
PANEL_POINTS = Table(
    "panel_points",
    "The characteristic points of each curve",
    (
        _IRRADIANCE,
        _CELL_TEMPERATURE,
        Column("short_circuit_current_a", "A", "I_sc"),
        Column("open_circuit_voltage_v", "V", "V_oc"),
        Column("max_power_current_a", "A", "I_mp"),
        Column("max_power_voltage_v", "V", "V_mp"),
        Column("max_power_w", "W", "P_mp = V_mp I_mp"),
    ),
)
SUPPLY = Table(
    "supply",
    "Powers from the panel to the battery's terminals, constant from each row's time to the next",
    (
        Column("time_s", "s", "start of the interval"),
        _IRRADIANCE,
        _CELL_TEMPERATURE,
        Column("panel_power_w", "W", "maximum power of the panel"),
        Column("bus_power_w", "W", "power the boost converter brings to the bus"),
        Column("load_power_w", "W", "power the master system takes from the bus"),
        Column("battery_power_w", "W", "power the buck converter can bring to the battery's terminals"),
        Column("buck_efficiency", "1", "buck output power over input power"),
        Column("boost_efficiency", "1", "boost output power over input power"),
    ),
)
PANEL_FIT = Table(
    "panel_fit",
    "The values of the data sheet beside those of the single-diode model",
    (
        Column("quantity", "", "what it is", "text"),
        Column("unit", "", "unit of both values", "text"),
        Column("data_sheet", "see unit", "value of the data sheet"),
        Column("model", "see unit", "value of the model"),
    ),
)

PANEL = {
    "curves": TableFile("curves.parquet", PANEL_CURVES),
    "points": TableFile("points.parquet", PANEL_POINTS),
    "parameters": TableFile("parameters.parquet", PANEL_PARAMETERS),
    "fit": TableFile("fit.parquet", PANEL_FIT),
}
"""What the step `panel` writes."""
SUPPLIED = {
    "supply": TableFile("supply.parquet", SUPPLY, time="time_s"),
    **NOTES,
}
"""What the step `supply` writes."""


class SupplyPart(Record):
    """The panel and what lies between it and the battery."""

    panel: Panel | None = None
    panel_curves: PanelCurveSettings = PanelCurveSettings()
    weather: Weather | None = None
    converter: PowerChain | None = None
    load: Load | None = None


def _panel_effort(config: Any) -> Effort:
    curves = config.panel_curves
    points = len(curves.irradiances_w_m2) * len(curves.cell_temperatures_c) * curves.points_per_curve
    counts = ("points_per_curve", "irradiances_w_m2", "cell_temperatures_c")
    return Effort(200.0 * points, 2e-6 * points, tuple(f"panel_curves.{name}" for name in counts))


PANEL_STEP = Step(
    "panel",
    rule="fit_panel",
    message="Panel: parameters, curves, maximum power: {chunk}",
    settings=lambda config: {"panel": config.panel, "curves": config.panel_curves},
    effort=_panel_effort,
    reads=("panel", "panel_curves"),
    tables=PANEL,
    usual_table="points",
    target="panel",
    chunk=(1, 16),
)


def _supply_settings(config: Any) -> dict[str, Any]:
    return {
        "panel": config.panel,
        "weather": settings(config.weather, config.weather.title),
        "converter": config.converter.averaged(),
        "load": config.load,
    }


SUPPLY_STEP = Step(
    "supply",
    rule="power_supply",
    message="Supply: power at the battery's terminals: {chunk}",
    settings=_supply_settings,
    reads=("panel", "weather", "converter", "load"),
    takes=("panel",),
    tables=SUPPLIED,
    usual_table="supply",
    target="panel",
    chunk=(1, 64),
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield the panel and the supply of a study that has them."""
    if study.panel is not None:
        yield Node(PANEL_STEP, "panel", "panel", shown=PANEL_STEP.places("panel"))
        yield Node(SUPPLY_STEP, "supply", "supply", inputs={"panel": "panel"}, shown=SUPPLY_STEP.places("supply"))


def check(study: Any) -> None:
    """Refuse a supply that can never charge, or that lacks a part.

    Raises
    ------
    UserError : with the key path, the value and what is allowed.
    """
    if study.weather is not None:
        check_weather("weather", study.weather)
    if study.panel is None:
        return
    if study.weather is None or study.converter is None or study.load is None:
        raise UserError("panel: a study with a panel needs weather, converter and load")
    power_w = study.panel.approximate_power_w(*_brightest(study.weather))
    voltage_v = study.panel.max_power_voltage_v * study.panel.panels_in_series
    converters.check(power_w, voltage_v, study.converter, study.load)


def _remarks(study: Any, kinds: Collection[str]) -> Iterator[str]:
    """Yield what a weather's file was taken for, and which values of the panel stand on no data sheet."""
    if study.panel is None:
        return
    yield from (f"weather: {note}" for note in told(study.weather))
    for path, source in study.sources.items():
        if path.startswith("panel.") and source.ref.startswith(NOT_GIVEN):
            yield f"{path}: {getattr(study.panel, path.removeprefix('panel.')):.4g}, {source.ref}"


def _brightest(weather: Weather) -> tuple[float, float]:
    """Return irradiance [W/m2] and cell temperature [degC] of the brightest moment, about."""
    if isinstance(weather, ConstantWeather):
        return weather.irradiance_w_m2, weather.cell_temperature_c
    return REFERENCE_IRRADIANCE_W_M2, REFERENCE_TEMPERATURE_C


def _system(config: Any) -> dict[str, Any]:
    """Return the system from the panel to the battery, for diagrams."""
    return {
        "panel": plain(config.panel),
        "converter": None if config.converter is None else plain(config.converter.averaged()),
        "load": plain(config.load),
        "battery": {"title": config.battery.title, "capacity_in_use_ah": config.battery.capacity_in_use_ah},
        "discharge_voltage_v": config.objective.discharge_voltage_v if config.objective else None,
    }


EXPERIMENT = Experiment(
    title="the panel, and the power that it brings to the battery",
    steps=(PANEL_STEP, SUPPLY_STEP),
    nodes=nodes,
    part=SupplyPart,
    parameters=("panel", "weather", "converter", "load"),
    written={"panel": PanelEntry},
    prepare=by_name,
    checks=(check,),
    remarks=_remarks,
    inputs=lambda study: ("panel", "supply") if study.panel is not None else (),
    labels={
        "system": Label(
            _system,
            (
                *("panel", "converter", "load", "objective.discharge_voltage_v", "battery.title"),
                *("battery.capacity_ah", "battery.scaled_to_capacity_ah"),
            ),
        )
    },
)
