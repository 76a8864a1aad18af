"""What is charged: steps, nodes, checks and what others may read of them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from pipeline.charge.comparison import compared, level_of, peak_current_a, scale
from pipeline.charge.effort import effort
from pipeline.charge.vocabulary import SUMMARY
from pipeline.config.compose import options
from pipeline.config.sources import beyond
from pipeline.experiments.charges.records import ChargesPart, check_modes, prepare, remarks_on_modes
from pipeline.experiments.charges.tables import CHARGE, SECOND
from pipeline.kernel.draft import plain, untitled
from pipeline.kernel.experiment import FOUND, Effort, Experiment, Label, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.published.ensemble import ANSWERS, NAME, asked, estimates

_TEMPERATURES = ("charge.ambient_c", "charge.initial_temperature_c")


def _charge_settings(config: Any, cell: str, comparison: str, mode: str, reference: str | None) -> dict[str, Any]:
    battery, card = getattr(config, cell), config.comparisons[comparison]
    run = compared(config.modes[mode], level_of(card.level(), config.modes), battery, card.stops)
    # No figure enlarges a charge of the second battery.
    charge = config.charge if cell == "battery" else config.charge.model_copy(update={"windows": []})
    return {
        "battery": untitled(battery, battery.name),
        "mode": untitled(run, mode),
        "charge": charge,
        "engine": config.engine,
    }


def _ensemble_settings(
    config: Any, estimated: Mapping[str, Any], charges: list[tuple[str, str]], modes: list[str]
) -> dict[str, Any]:
    comparisons = {comparison for comparison, _ in charges}
    cards = {name: card for name, card in config.comparisons.items() if name in comparisons}
    return {
        "battery": untitled(config.battery, config.battery.name),
        "modes": {name: untitled(config.modes[name], name) for name in modes},
        "charge": config.charge.model_copy(update={"windows": []}),
        "engine": config.engine,
        "points": config.ensemble.points,
        "estimated": estimated,
        "seed": config.seed,
        "asked": asked(config, ("charge",)),
        "charges": charges,
        "tables": {name: file.plain() for name, file in CHARGE.items()},
        "comparisons": {name: card.level() for name, card in cards.items()},
        "stops": {name: card.stops for name, card in cards.items() if card.stops is not None},
    }


_GROWS = ("charge.sample_interval_s", "charge.windows", "engine.maximum_step_s", "engine.maximum_steps")


def _charge_effort(config: Any, cell: str, comparison: str, mode: str, reference: str | None) -> Effort:
    memory_b, time_s = effort(config.modes[mode], config.charge, config.engine)
    return Effort(memory_b, time_s, (*_GROWS, f"modes.{mode}"))


def _ensemble_effort(config: Any, charges: list[tuple[str, str]], **_: Any) -> Effort:
    modes = [config.modes[mode] for _, mode in charges]
    whole_s = config.ensemble.points * sum(effort(mode, config.charge, config.engine)[1] for mode in modes)
    return Effort(1e4 * config.ensemble.points * len(charges), whole_s, ("ensemble.points", *_GROWS))


ENGINE = Step(
    "engine",
    rule="compile_engine",
    message="Engine: compiling the kernels (once for each version of their code): {chunk}",
    shown=False,
)
CHARGED = Step(
    "charge",
    rule="charge_battery",
    message="Charge: {chunk}",
    settings=_charge_settings,
    effort=Footprint(_charge_effort, node_s=0.015, together=48),
    reads=("{cell}", "charge", "engine", "comparisons.{comparison}", "modes.{mode}", "modes.{reference}"),
    takes=("engine", "supply", FOUND),
    tables=CHARGE,
    usual_table="summary",
    quantities=SUMMARY,
    target="charges",
    chunk=(4, 12),  # loading the kernels takes as long as a charge or two
    swept=True,
    swept_on_demand=(SECOND,),
)
SAMPLED = Step(
    "ensemble",
    rule="charge_ensemble",
    message="Charges over the ranges of estimated parameters: {chunk}",
    settings=_ensemble_settings,
    effort=Footprint(_ensemble_effort, memory_mb=480.0, node_s=8.0),
    reads=("battery", "modes.{modes}", "charge", "engine", "ensemble", "seed", "comparisons", "published", "answer"),
    takes=("engine", "supply", FOUND),
    tables=ANSWERS,
    priority=1,
    shown=False,
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield the compiled engine, every charge, and the charges over the ranges of the estimated parameters."""
    yield Node(ENGINE, "engine", "engine")
    first = _charges(study, "battery")
    if study.second_battery is None:
        yield from first
    else:
        # In turn, so that a job takes one of each.
        for pair in zip(first, _charges(study, "second_battery"), strict=True):
            yield from pair
    yield from _ensemble(study)


def _ensemble(study: Any) -> Iterator[Node]:
    """Yield the charges over the ranges of the estimated parameters: those that statements read, where they vary."""
    if not study.ensemble.points:
        return
    read = {value["artefact"] for one in asked(study, ("charge",)) for value in _values(one)}
    charges = [
        (comparison, mode)
        for comparison in study.comparisons
        for mode in study.run
        if f"charge/{comparison}/{mode}" in read
    ]
    references = {study.comparisons[comparison].reference for comparison, _ in charges} - {None}
    modes = sorted({mode for _, mode in charges} | references)
    estimated = estimates(study.sources, ("battery", "charge", *(f"modes.{mode}" for mode in modes)))
    if charges and estimated["ranges"]:
        which = {"estimated": estimated, "charges": charges, "modes": modes}
        shown = {"ensemble.parquet": "published/ensemble_of_charges.parquet"}
        yield Node(SAMPLED, f"{NAME}/charge", study.study.name, which, _inputs(study), shown)


def _values(asked_for: Any) -> Iterator[Mapping[str, Any]]:
    """Yield the values in operands as plain data."""
    if isinstance(asked_for, Mapping) and "artefact" in asked_for:
        yield asked_for
    elif isinstance(asked_for, Mapping | list | tuple):
        for part in asked_for.values() if isinstance(asked_for, Mapping) else asked_for:
            yield from _values(part)


def _charges(study: Any, cell: str) -> Iterator[Node]:
    kind, prefix = ("charge", "") if cell == "battery" else (SECOND, "second")
    for comparison, card in study.comparisons.items():
        for mode in study.run:
            place = "/".join(part for part in (prefix, "charge", comparison, mode) if part)
            files = [one.file for name, one in CHARGE.items() if not prefix or name != "waveform"]
            yield Node(
                CHARGED,
                f"{kind}/{comparison}/{mode}",
                ".".join(part for part in (prefix, comparison, mode) if part),
                {"cell": cell, "comparison": comparison, "mode": mode, "reference": card.reference},
                inputs=_inputs(study),
                shown={file: f"{place}.{file.removeprefix('trace.')}" for file in files},
            )


def _inputs(study: Any) -> dict[str, str]:
    return {"engine": "engine"} | ({"supply": "supply"} if study.panel is not None else {})


def _readable(study: Any) -> Iterable[str]:
    return (f"charge/{comparison}/{mode}" for comparison in study.comparisons for mode in options("modes"))


def _fields(study: Any) -> dict[str, dict[str, Iterable[object]]]:
    return {"charge": {"mark": [f"{mark:g}" for mark in study.charge.soc_marks]}}


def _knobs(config: Any) -> dict[str, Any]:
    return {name: plain(config.modes[name].knobs) for name in config.run}


def _scaled(config: Any) -> dict[str, Any]:
    """Return, by comparison and mode, what a comparison made of the currents of a mode, in words."""
    found: dict[str, dict[str, str]] = {}
    for comparison, card in config.comparisons.items():
        level = level_of(card.level(), config.modes)
        if level is None:
            continue
        for name in config.run:
            factor = scale(config.modes[name], level, config.battery)
            if factor != 1.0:
                own = peak_current_a(config.modes[name], config.battery) or 0.0
                told = f"all currents times {factor:.4g}, the largest from {own:.4g} A to {factor * own:.4g} A"
                found.setdefault(comparison, {})[name] = f"{told}, to match {level.reference.title}"
    return found


def _beyond(config: Any) -> dict[str, Any]:
    """Return where the charges leave what the battery was fitted to, in sentences."""
    return {"said": beyond(config.sources_below("battery"), config.charge.initial_soc, config.charge.ambient_c)}


def _remarks(study: Any, kinds: Collection[str]) -> Iterator[str]:
    yield from remarks_on_modes(study, second=SECOND in kinds)
    own = {path: source for path, source in study.sources.items() if path.startswith("battery.")}
    yield from (f"charge: {told}" for told in beyond(own, study.charge.initial_soc, study.charge.ambient_c))


def _cells(config: Any) -> dict[str, Any]:
    both = (config.battery, config.second_battery)
    return {"titles": [battery.title for battery in both if battery is not None]}


EXPERIMENT = Experiment(
    title="charges of a battery in every mode and comparison",
    steps=(ENGINE, CHARGED, SAMPLED),
    nodes=nodes,
    part=ChargesPart,
    parameters=("battery", "second_battery", "modes.*", "charge.initial_soc", *_TEMPERATURES),
    refers={
        "run": "modes",
        "comparisons.*.peak_current_of": "modes",
        "comparisons.*.mean_current_of": "modes",
    },
    prepare=prepare,
    checks=(check_modes,),
    remarks=_remarks,
    inputs=_readable,
    fields=_fields,
    labels={
        "modes": Label(_knobs, ("run", "modes")),
        "battery": Label(lambda config: plain(config.battery), ("battery",)),
        "scaled": Label(_scaled, ("run", "modes", "comparisons", "battery")),
        "beyond": Label(_beyond, ("battery", "charge.initial_soc", "charge.ambient_c")),
        "cells": Label(_cells, ("battery.title", "second_battery.title")),
    },
    tells="telling",
)
