"""The converters switch by switch: the step, its node, what others may read of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pipeline.converter.records import BOOST
from pipeline.experiments.switched.choices import check
from pipeline.kernel.draft import plain, untitled
from pipeline.kernel.experiment import FOUND, Experiment, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.kernel.tables import NUMBERS, Column, Table, TableFile
from pipeline.published.ensemble import ANSWERS, NAME, asked, estimates

_CHARGE = (
    Column("comparison", "", "name of the comparison", "text"),
    Column("mode", "", "name of the charging mode", "text"),
    Column("window", "1", "number of the charge's window, from 0", "integer"),
)
_EDGE = (
    Column("edge", "1", "number of the step in the window, from 0", "integer"),
    Column("kind", "", "what begins or ends", "text"),
)

SWITCHED_PERIODS = Table(
    "switched_periods",
    "The buck converter in a charge's windows, a row per switching period",
    (
        *_CHARGE,
        Column("time_s", "s", "start of the period, since the start of the charge"),
        Column("reference_a", "A", "current asked for: that of the charge"),
        Column("duty", "1", "share of the period for which the switch is on"),
        Column("inductor_mean_a", "A", "mean inductor current"),
        Column("battery_mean_a", "A", "mean current into the battery"),
        Column("battery_min_a", "A", "least current into the battery"),
        Column("battery_max_a", "A", "largest current into the battery"),
        Column("voltage_mean_v", "V", "mean terminal voltage"),
        Column("voltage_min_v", "V", "least terminal voltage"),
        Column("voltage_max_v", "V", "largest terminal voltage"),
    ),
)
SWITCHED_WAVEFORM = Table(
    "switched_waveform",
    "Samples within the switching periods about the last step of each kind in a window",
    (
        *_CHARGE,
        *_EDGE,
        Column("time_s", "s", "time since the step"),
        Column("inductor_a", "A", "inductor current"),
        Column("battery_a", "A", "current into the battery"),
        Column("voltage_v", "V", "terminal voltage"),
    ),
)
SWITCHED_EDGES = Table(
    "switched_edges",
    "How the battery's current answers each step of the pulses, means over switching periods",
    (
        *_CHARGE,
        *_EDGE,
        Column("time_s", "s", "time of the step, since the start of the charge"),
        Column("before_a", "A", "current asked for before it"),
        Column("after_a", "A", "current asked for after it"),
        Column("overshoot_a", "A", "farthest that the current goes past the new one"),
        Column("settling_s", "s", "time until it stays within 2 % of the step"),
        Column("ringing_j", "J", "heat in the series resistance of what it is off once it has reached the new one"),
        Column("deviation_j", "J", "the same from the step on, with the rise or fall itself"),
    ),
)
SWITCHED_MODES = Table(
    "switched_modes",
    "What the steps of a mode come to, a row per charge and window",
    (
        *_CHARGE,
        Column("pulses_hz", "Hz", "pulses a second; empty without pulses", optional=True),
        Column("ripple_a", "A", "largest ripple of the battery's current at the switching frequency, peak to peak"),
        Column(
            "conduction_efficiency", "1", "energy into the battery over energy from the bus, conduction losses alone"
        ),
        Column("overshoot_a", "A", "largest overshoot of the kinds of steps; 0 without steps"),
        Column("settling_s", "s", "longest settling time of the kinds of steps; 0 without steps"),
        Column("ringing_j", "J", "ringing of a period of the pulses: one step of each kind; 0 without steps"),
        Column("ringing_w", "W", "the same over the length of a period of the pulses; 0 without steps"),
    ),
)

SWITCHED = {
    "periods": TableFile("periods.parquet", SWITCHED_PERIODS, time="time_s"),
    "waveform": TableFile("waveform.parquet", SWITCHED_WAVEFORM),
    "edges": TableFile("edges.parquet", SWITCHED_EDGES),
    "modes": TableFile("modes.parquet", SWITCHED_MODES),
    **NUMBERS,
}
"""What the step `switched` writes."""


def _settings(config: Any, charges: list[tuple[str, str]]) -> dict[str, Any]:
    return {
        # Titles are for readers, and changing one must compute nothing.
        "battery": untitled(config.battery, config.battery.name),
        "switched": config.converter.switched,
        "bus_voltage_v": config.converter.bus_voltage_v,
        "panel_voltage_v": config.panel.string_voltage_v,
        "panel_current_a": config.panel.max_power_current_a * config.panel.panels_in_parallel,
        "charges": charges,
    }


SWITCHED_STEP = Step(
    "switched",
    rule="switch_converters",
    message="Converters, switch by switch: {chunk}",
    settings=_settings,
    reads=(
        *("battery", "converter.switched", "converter.bus_voltage_v", "panel.max_power_voltage_v"),
        *("panel.panels_in_series", "panel.max_power_current_a", "panel.panels_in_parallel"),
    ),
    takes=("charge",),
    tables=SWITCHED,
    usual_table="quantities",
    quantities=BOOST,
    target="charges",
    chunk=(1, 12),
)


def _ensemble_settings(
    config: Any, charges: list[tuple[str, str]], modes: list[str], estimated: Mapping[str, Any], **_: Any
) -> dict[str, Any]:
    return {
        "battery": untitled(config.battery, config.battery.name),
        "modes": {name: {**plain(config.modes[name]), "title": name} for name in modes},
        "charge": config.charge,
        "engine": config.engine,
        "switched": config.converter.switched,
        "bus_voltage_v": config.converter.bus_voltage_v,
        "charges": charges,
        "comparisons": {name: config.comparisons[name].level() for name, _ in charges},
        "points": config.ensemble.slow_points,
        "estimated": estimated,
        "seed": config.seed,
        "asked": asked(config, (SWITCHED_STEP.name,)),
    }


SAMPLED = Step(
    "switched_ensemble",
    rule="switch_over_estimates",
    message="Converters, switch by switch, over the ranges of estimated parameters: {chunk}",
    effort=Footprint(node_s=4.0),
    settings=_ensemble_settings,
    reads=(
        *("battery", "modes.{modes}", "charge", "engine", "converter.switched", "converter.bus_voltage_v"),
        *("comparisons", "ensemble", "seed", "published", "answer"),
    ),
    takes=("engine", "supply", FOUND),
    tables=ANSWERS,
    priority=1,
    shown=False,
)


def _ensemble(study: Any, charges: list[tuple[str, str]]) -> Iterator[Node]:
    """Yield the first window of the charges that statements read, over the ranges of the estimated parameters."""
    read = asked(study, (SWITCHED_STEP.name,))
    rows = [one["where"] for one in read if "where" in one]
    own = [pair for pair in charges if any((row["comparison"], row["mode"]) == pair for row in rows)]
    references = {study.comparisons[comparison].reference for comparison, _ in own} - {None}
    modes = sorted({mode for _, mode in own} | references)
    parts = ("battery", "charge", "converter.switched", *(f"modes.{mode}" for mode in modes))
    estimated = estimates(study.sources, parts)
    if not (study.ensemble.slow_points and study.charge.windows and own and estimated["ranges"]):
        return
    inputs = {"engine": "engine", "supply": "supply"}
    shown = {"ensemble.parquet": "published/ensemble_of_switches.parquet"}
    which = {"charges": own, "modes": modes, "estimated": estimated}
    yield Node(SAMPLED, f"{NAME}/switched", study.study.name, which, inputs, shown)


def nodes(study: Any) -> Iterator[Node]:
    """Yield the node, where the study's converters are given switch by switch."""
    if study.converter is None or study.converter.switched is None or study.panel is None:
        return
    charges = [(comparison, mode) for comparison in study.comparisons for mode in study.run]
    names = [f"charge/{comparison}/{mode}" for comparison, mode in charges]
    yield Node(
        SWITCHED_STEP,
        "switched",
        study.study.name,
        {"charges": charges},
        inputs={name: name for name in names},
        shown=SWITCHED_STEP.places("switched"),
    )
    yield from _ensemble(study, charges)


EXPERIMENT = Experiment(
    title="the steps of the pulses at the resolution of the converters' switches",
    steps=(SWITCHED_STEP, SAMPLED),
    nodes=nodes,
    checks=(check,),
    inputs=lambda study: ("switched",) if study.converter is not None else (),
    fields=lambda study: {"switched": {}},
)
