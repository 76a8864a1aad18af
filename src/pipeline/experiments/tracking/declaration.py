"""Trackers tried on ramps, days and shadows, and the converters by their parts: steps, nodes, what others may read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pipeline.experiments.tracking.records import CONVERTER_NUMBERS, TRACKING_NUMBERS, TrackingPart
from pipeline.kernel.experiment import Effort, Experiment, Label, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.kernel.tables import NUMBERS, Column, Table, TableFile

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

TRIALS = {
    "ramps": TableFile("ramps.parquet", TRACKING_RAMPS),
    "course": TableFile("course.parquet", TRACKING_COURSE),
    "day": TableFile("day.parquet", TRACKING_DAY),
    "shading_curves": TableFile("shading_curves.parquet", SHADING_CURVES),
    "shading_ends": TableFile("shading_ends.parquet", SHADING_ENDS),
    **NUMBERS,
}
"""What the step `tracking` writes."""

CONVERTERS = {
    "efficiency": TableFile("efficiency.parquet", EFFICIENCY_MAP),
    "check": TableFile("check.parquet", SWITCHED_CHECK),
    **NUMBERS,
}
"""What the step `converters` writes."""


def _tracking_settings(config: Any) -> dict[str, Any]:
    # Titles are for readers, and changing one must compute nothing.
    return {
        "panel": config.panel.model_copy(update={"title": "panel"}),
        "boost": config.converter.switched.boost,
        "bus_voltage_v": config.converter.bus_voltage_v,
        "trackers": {name: card.model_copy(update={"title": name}) for name, card in config.trackers.items()},
        "tracking": config.tracking,
    }


def _tracking_effort(config: Any) -> Effort:
    chosen, trackers = config.tracking, config.trackers
    ramps_s = sum(
        2.0 * count * ((one.high_w_m2 - one.low_w_m2) / slope + one.dwell_s)
        for one in chosen.ramps.values()
        for slope, count in zip(one.slopes_w_m2_s, one.repetitions, strict=True)
    )
    shadows_s = len(chosen.shading.scenes) * (chosen.shading.light_s + chosen.shading.shade_s) if chosen.shading else 0
    length_s = ramps_s + shadows_s + chosen.steady_s + 86400.0 * len(chosen.skies)
    periods = sum(length_s / one.perturbation_period_s for one in trackers.values())
    ramps = [f"tracking.ramps.{name}" for name in chosen.ramps]
    return Effort(16.0 * periods, 3e-6 * periods, (*ramps, *(f"trackers.{name}" for name in trackers), "tracking"))


def _converters_settings(config: Any) -> dict[str, Any]:
    panel = config.panel
    panels = panel.panels_in_series * panel.panels_in_parallel
    return {
        "converter": config.converter.model_copy(update={"title": "converters"}),
        "panel_voltage_v": panel.string_voltage_v,
        "panel_power_w": panel.max_power_voltage_v * panel.max_power_current_a * panels,
    }


TRACKING_STEP = Step(
    "tracking",
    rule="try_trackers",
    message="Trackers: ramps, days, shadows: {chunk}",
    settings=_tracking_settings,
    effort=Footprint(_tracking_effort, node_s=6.0),
    reads=("panel", "converter.switched.boost", "converter.bus_voltage_v", "trackers", "tracking"),
    takes=("panel",),
    tables=TRIALS,
    usual_table="quantities",
    quantities=TRACKING_NUMBERS,
    target="panel",
    chunk=(1, 8),
)
CONVERTERS_STEP = Step(
    "converters",
    rule="map_converter_efficiency",
    message="Converters: efficiency over load: {chunk}",
    effort=Footprint(node_s=2.0),
    settings=_converters_settings,
    reads=(
        *("converter", "panel.max_power_voltage_v", "panel.max_power_current_a"),
        *("panel.panels_in_series", "panel.panels_in_parallel"),
    ),
    tables=CONVERTERS,
    usual_table="quantities",
    quantities=CONVERTER_NUMBERS,
    target="panel",
    chunk=(1, 8),
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield the trials, where there are trackers and the boost converter's parts; the map, where there are losses."""
    name = study.study.name
    if _tried(study):
        yield Node(TRACKING_STEP, "tracking", name, inputs={"panel": "panel"}, shown=TRACKING_STEP.places("tracking"))
    if _mapped(study):
        yield Node(CONVERTERS_STEP, "converters", name, shown=CONVERTERS_STEP.places("converters"))


def _tried(study: Any) -> bool:
    return _of_parts(study) and study.tracking is not None and bool(study.trackers)


def _mapped(study: Any) -> bool:
    return _of_parts(study) and study.converter.losses is not None


def _of_parts(study: Any) -> bool:
    chain = study.converter
    return study.panel is not None and chain is not None and chain.switched is not None


def _readable(study: Any) -> Iterable[str]:
    return [name for name, is_made in (("tracking", _tried), ("converters", _mapped)) if is_made(study)]


def _fields(study: Any) -> Mapping[str, Mapping[str, Iterable[object]]]:
    return {"tracking": {"tracker": tuple(study.trackers)}, "converters": {"converter": ("boost", "buck")}}


def _titles(config: Any) -> dict[str, Any]:
    """Return what readers of the trials need to name trackers and days."""
    skies = {} if config.tracking is None else config.tracking.skies
    return {
        "trackers": {name: card.title for name, card in config.trackers.items()},
        "skies": {name: sky.title for name, sky in skies.items()},
    }


EXPERIMENT = Experiment(
    title="trackers on ramps, days and shadows, and converters over their load",
    steps=(TRACKING_STEP, CONVERTERS_STEP),
    nodes=nodes,
    part=TrackingPart,
    parameters=("trackers", "tracking"),
    inputs=_readable,
    fields=_fields,
    labels={"tracking": Label(_titles, ("trackers", "tracking.skies"))},
)
