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

ARTEFACTS: dict[tuple[str, str], tuple[str, Table]] = {
    ("panel", "fit"): ("fit.parquet", PANEL_FIT),
    ("tracking", "ramps"): ("ramps.parquet", TRACKING_RAMPS),
    ("tracking", "course"): ("course.parquet", TRACKING_COURSE),
    ("tracking", "day"): ("day.parquet", TRACKING_DAY),
    ("tracking", "shading_curves"): ("shading_curves.parquet", SHADING_CURVES),
    ("tracking", "shading_ends"): ("shading_ends.parquet", SHADING_ENDS),
    ("tracking", "quantities"): ("quantities.parquet", QUANTITIES),
}
"""(input, table) -> file and declaration, as statements and figures read them."""

FILES = {
    name if of in name else f"{of}_{name}": (file, table)
    for (of, name), (file, table) in ARTEFACTS.items()
    if table is not QUANTITIES
}
"""Name under which figures read a table -> file, declaration."""
