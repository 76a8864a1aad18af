"""The tables of panel, trackers and converters beyond those of every study; further to `schemas`."""

from __future__ import annotations

from pipeline.schemas import QUANTITIES
from pipeline.tables import Column, Table

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
_TRACKER = Column("tracker", "", "name of the tracker", "text")
TRACKING_RAMPS = Table(
    "tracking_ramps",
    "What each tracker captures of ramps of the irradiance, a row per tracker and ramp",
    (
        _TRACKER,
        Column("group", "", "which group of ramps", "text"),
        Column("low_w_m2", "W/m2", "irradiance at the foot"),
        Column("high_w_m2", "W/m2", "irradiance at the top"),
        Column("slope_w_m2_s", "W/m2/s", "slope of the ramp"),
        Column("repetitions", "1", "how often it goes up and down", "integer"),
        Column("available_j", "J", "energy at maximum power"),
        Column("captured_j", "J", "energy captured"),
        Column("efficiency", "1", "captured over available"),
    ),
)
TRACKING_COURSE = Table(
    "tracking_course",
    "The course of one fast ramp, a row per tracker and time",
    (
        _TRACKER,
        Column("time_s", "s", "time from the foot of the ramp"),
        Column("irradiance_w_m2", "W/m2", "irradiance"),
        Column("voltage_v", "V", "panel voltage"),
        Column("power_w", "W", "panel power, mean since the row before"),
        Column("available_w", "W", "maximum power"),
        Column("duty", "1", "duty of the boost converter"),
    ),
)
TRACKING_DAY = Table(
    "tracking_day",
    "What each tracker captures of a day, a row per tracker and sky",
    (
        _TRACKER,
        Column("sky", "", "name of the day", "text"),
        Column("available_wh", "Wh", "energy at maximum power"),
        Column("captured_wh", "Wh", "energy captured"),
        Column("efficiency", "1", "captured over available"),
    ),
)
SHADING_CURVES = Table(
    "shading_curves",
    "Current and power of the shaded panels over their voltage",
    (
        Column("scene", "", "name of the scene", "text"),
        Column("voltage_v", "V", "voltage of the panels"),
        Column("current_a", "A", "current"),
        Column("power_w", "W", "power"),
    ),
)
SHADING_ENDS = Table(
    "shading_ends",
    "Where each tracker ends when the shadow falls, a row per scene and tracker",
    (
        Column("scene", "", "name of the scene", "text"),
        _TRACKER,
        Column("voltage_v", "V", "mean voltage at the end"),
        Column("power_w", "W", "mean power at the end"),
        Column("best_w", "W", "highest power on the curve"),
        Column("share", "1", "power at the end over the highest"),
        Column("searched_s", "s", "time until it stays within 2 % of where it ends"),
    ),
)
EFFICIENCY_MAP = Table(
    "efficiency_map",
    "Both converters by their parts, a row per converter, voltage and load",
    (
        Column("converter", "", "boost or buck", "text"),
        Column("source_v", "V", "voltage at the input"),
        Column("sink_v", "V", "voltage at the output"),
        Column("power_w", "W", "power at the input"),
        Column("efficiency", "1", "output power over input power"),
        Column("conduction_efficiency", "1", "the same with the conduction losses of this load alone"),
        Column("duty", "1", "duty"),
        Column("ripple_a", "A", "ripple of the inductor current, peak to peak"),
        Column("switch_w", "W", "conduction of the switch"),
        Column("rectifier_w", "W", "conduction of the rectifier"),
        Column("winding_w", "W", "resistance of the inductor"),
        Column("capacitor_w", "W", "series resistance of the output capacitor"),
        Column("switching_w", "W", "edges, capacitance of the switch node, gate"),
        Column("core_w", "W", "core of the inductor"),
        Column("control_w", "W", "controller"),
    ),
)
SWITCHED_CHECK = Table(
    "switched_check",
    "Conduction losses of the averaged converters beside those switch by switch, a row per converter and load",
    (
        Column("converter", "", "boost or buck", "text"),
        Column("source_v", "V", "voltage at the input"),
        Column("sink_v", "V", "voltage at the output"),
        Column("power_w", "W", "power at the input"),
        Column("averaged", "1", "efficiency of the averaged converter without other losses"),
        Column("switched", "1", "the same switch by switch"),
    ),
)

ARTEFACTS: dict[tuple[str, str], tuple[str, Table]] = {
    ("panel", "fit"): ("fit.parquet", PANEL_FIT),
    ("tracking", "ramps"): ("ramps.parquet", TRACKING_RAMPS),
    ("tracking", "course"): ("course.parquet", TRACKING_COURSE),
    ("tracking", "day"): ("day.parquet", TRACKING_DAY),
    ("tracking", "shading_curves"): ("shading_curves.parquet", SHADING_CURVES),
    ("tracking", "shading_ends"): ("shading_ends.parquet", SHADING_ENDS),
    ("converters", "efficiency"): ("efficiency.parquet", EFFICIENCY_MAP),
    ("converters", "check"): ("check.parquet", SWITCHED_CHECK),
    ("converters", "quantities"): ("quantities.parquet", QUANTITIES),
    ("tracking", "quantities"): ("quantities.parquet", QUANTITIES),
}
"""(input, table) -> file and declaration, as statements and figures read them."""

FILES = {f"{of}_{name}": (file, table) for (of, name), (file, table) in ARTEFACTS.items() if table is not QUANTITIES}
"""Name under which figures read a table -> file, declaration."""
