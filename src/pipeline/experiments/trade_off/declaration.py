"""Charge time against peak temperature: is the network worth it?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import Field

from pipeline.charge.effort import ROW_B
from pipeline.experiments.trade_off.records import TRADE_OFF_NUMBERS, TradeOff, fields
from pipeline.kernel.draft import plain, untitled
from pipeline.kernel.experiment import FOUND, Effort, Experiment, Label, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.kernel.tables import NUMBERS, Column, Table, TableFile
from pipeline.published.ensemble import ANSWERS, NAME, asked, estimates
from pipeline.record import Record


class TradeOffPart(Record):
    """Charge time against peak temperature."""

    trade_off: TradeOff | None = Field(default=None, description="charge time against peak temperature")


TRADE_OFF = Table(
    "trade_off",
    "Charge time and peak temperature, a row per charge",
    (
        Column("law", "", "constant_current, or the name of the mode", "text"),
        Column("c_rate", "1", "constant current [C-rate]; empty for a mode", optional=True),
        Column("stop", "", "name of what stops a constant current; empty for a mode, which has its own", "text"),
        Column("condition", "", "name of the condition", "text"),
        Column("sensor", "", "name of the sensor a mode sees through, own for that of its sheet", "text"),
        Column("time_to_full_s", "s", "time until charged; empty where the charge ended before", optional=True),
        Column("peak_temperature_c", "degC", "highest battery temperature of the whole charge"),
        Column("end_time_s", "s", "time at which the charge ended"),
        Column("end_soc", "1", "state of charge at the end"),
        Column("charge_in_share", "1", "charge put in over the capacity"),
        Column("end_reason", "", "what ended the charge", "text"),
    ),
)

WEIGHED = {"trade_off": TableFile("trade_off.parquet", TRADE_OFF), **NUMBERS}
"""What the step `trade_off` writes."""


def _settings(config: Any, modes: list[str]) -> dict[str, Any]:
    return {
        "trade_off": _untitled(plain(config.trade_off)),
        "battery": untitled(config.battery, config.battery.name),
        "modes": {name: {**plain(config.modes[name]), "title": name} for name in modes},
        "charge": config.charge.model_copy(update={"windows": [], "soc_marks": []}),
        "engine": config.engine,
    }


def _untitled(chosen: dict[str, Any]) -> dict[str, Any]:
    """Return the settings with names for titles: changing what only readers see must compute nothing."""
    named = {
        part: {name: one | {"title": name} for name, one in chosen[part].items()} for part in ("conditions", "sensors")
    }
    return chosen | named


def _ensemble_settings(config: Any, modes: list[str], estimated: Mapping[str, Any]) -> dict[str, Any]:
    return {
        **_settings(config, modes),
        "points": config.ensemble.slow_points,
        "estimated": estimated,
        "seed": config.seed,
        "asked": asked(config, (WEIGH.name,)),
    }


def _effort(config: Any, modes: list[str]) -> Effort:
    chosen, engine = config.trade_off, config.engine
    whole_s = 3600.0 * max(chosen.give_up_share, chosen.timer_share) / min(chosen.c_rates)
    tries = len(chosen.conditions) * len(chosen.c_rates) * (1 + len(chosen.stops) + len(chosen.sensors))
    fastest_s = min([sensor.sample_interval_s for sensor in chosen.sensors.values()], default=60.0)
    rows, steps = whole_s / min(config.charge.sample_interval_s, fastest_s), whole_s / engine.maximum_step_s
    sensors = [f"trade_off.sensors.{name}.sample_interval_s" for name in chosen.sensors]
    paths = (*sensors, "trade_off.c_rates", "charge.sample_interval_s", "engine.maximum_step_s")
    return Effort(ROW_B * rows, 1e-6 * tries * (rows + steps), paths)


WEIGH = Step(
    "trade_off",
    rule="weigh_time_against_temperature",
    message="Charge time against peak temperature: {chunk}",
    settings=_settings,
    effort=_effort,
    reads=("trade_off", "battery", "modes.{modes}", "charge", "engine"),
    takes=("engine", FOUND),
    tables=WEIGHED,
    quantities=TRADE_OFF_NUMBERS,
    target="charges",
    chunk=(1, 4),
)


SAMPLED = Step(
    "trade_off_ensemble",
    rule="weigh_over_estimates",
    message="Charge time against peak temperature over the ranges of estimates: {chunk}",
    effort=Footprint(node_s=10.0),
    settings=_ensemble_settings,
    reads=(*WEIGH.reads, "ensemble", "seed", "published", "answer"),
    takes=("engine", FOUND),
    tables=ANSWERS,
    priority=1,
    shown=False,
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield the trade-off of a study that has one, with those of its two modes that are charged."""
    chosen = study.trade_off
    if chosen is None:
        return
    which: dict[str, Any] = {"modes": [name for name in study.run if name in (chosen.candidate, chosen.rule)]}
    shown = WEIGH.places("trade_off")
    yield Node(WEIGH, "trade_off", study.study.name, which, {"engine": "engine"}, shown)
    parts = ("battery", "charge", "trade_off", *(f"modes.{name}" for name in which["modes"]))
    estimated = estimates(study.sources, parts)
    if study.ensemble.slow_points and estimated["ranges"] and asked(study, (WEIGH.name,)):
        shown = {"ensemble.parquet": "published/ensemble_of_trade_off.parquet"}
        varied = {**which, "estimated": estimated}
        yield Node(SAMPLED, f"{NAME}/trade_off", study.study.name, varied, {"engine": "engine"}, shown)


def _fields(study: Any) -> dict[str, Any]:
    return {} if study.trade_off is None else {WEIGH.name: fields(study.trade_off)}


def _label(config: Any) -> dict[str, Any]:
    return {} if config.trade_off is None else dict(plain(config.trade_off))


EXPERIMENT = Experiment(
    title="charge time against peak temperature",
    steps=(WEIGH, SAMPLED),
    nodes=nodes,
    part=TradeOffPart,
    parameters=("trade_off",),
    inputs=lambda study: () if study.trade_off is None else (WEIGH.name,),
    fields=_fields,
    labels={"trade_off": Label(_label, ("trade_off",))},
)
