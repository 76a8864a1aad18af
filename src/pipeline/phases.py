"""Which nodes a study has: each phase turns the parts of the configuration it uses into drafts of nodes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from pipeline.cell.records import Battery
from pipeline.charge.comparison import compared
from pipeline.charge.records import Mode
from pipeline.config.searching import VARIABLE
from pipeline.config.study import Study
from pipeline.converter.records import PowerChain
from pipeline.day_phases import days, weather_settings
from pipeline.day_phases import labels as day_labels
from pipeline.draft import Draft, needed, plain, with_found
from pipeline.function_phases import functions
from pipeline.network_phases import STEPS as NETWORK_STEPS
from pipeline.network_phases import network
from pipeline.planfile import command
from pipeline.published.records import needs
from pipeline.published.second_cell import SECOND, answered_by_charges, of_second
from pipeline.record import Record
from pipeline.search_phases import FINDERS, SECTION_OF, finders
from pipeline.staging_phases import staging, used_settings
from pipeline.switched_phases import switched
from pipeline.tracking_phases import converters, tracking, tracking_titles
from pipeline.trade_off_phases import trade_offs
from pipeline.validation_phases import headings, validation


def drafts(study: Study) -> list[Draft]:
    """Return the nodes of a study, inputs before those that read them."""
    parts = [
        *(_supply, tracking, converters, finders, network, staging),
        *(_charges, _ensemble, trade_offs, switched, days),
    ]
    # A study of the engine itself charges nothing beside its checks.
    parts = parts if study.validation is None else [validation]
    nodes = [with_found(node) for part in parts for node in part(study)]
    nodes = needed(nodes, FINDERS)
    nodes += functions(study)
    nodes += _verdicts(study, nodes)
    nodes += _figures(study, nodes)
    nodes += _page(study, nodes)
    return nodes


def charge_name(comparison: str, mode: str, second: bool = False) -> str:
    """Return the name of a charge's node, which is also the name of the input that reads it."""
    return f"{SECOND if second else 'charge'}/{comparison}/{mode}"


def compared_modes(study: Study, battery: Battery) -> Iterator[tuple[str, str, Mode]]:
    """Yield comparison, mode name and the mode as it is run there."""
    for name, comparison in study.comparisons.items():
        reference = comparison.mean_current_of
        for mode_name in study.run:
            other = None if reference is None else study.modes[reference]
            yield name, mode_name, compared(study.modes[mode_name], other, battery, comparison.stops)


def _supply(study: Study) -> Iterator[Draft]:
    if study.panel is None:
        return
    yield Draft(
        "panel",
        "panel",
        "panel",
        plain({"panel": study.panel, "curves": study.panel_curves}),
        sections=("panel",),
        shown={f"{part}.parquet": f"panel/{part}.parquet" for part in ("curves", "points", "parameters", "fit")},
    )
    yield Draft(
        "supply",
        "supply",
        "supply",
        plain(
            {
                "panel": study.panel,
                "weather": weather_settings(study),
                "converter": _averaged(study),
                "load": study.load,
            }
        ),
        inputs={"panel": "panel"},
        sections=("weather", "converter", "load"),
        shown={"supply.parquet": "supply/supply.parquet"},
    )


def _averaged(study: Study) -> PowerChain | None:
    """Return the converters without the parts that the powers of hours do not depend on."""
    if study.converter is None or study.converter.of_parts:
        return study.converter
    return study.converter.model_copy(update={"switched": None, "losses": None})


def _charges(study: Study) -> Iterator[Draft]:
    yield Draft("engine", "engine", "engine", {})
    first = _charges_of(study, study.battery)
    if study.second_battery is None:
        yield from first
        return
    # In turn, so that a job takes one of each.
    for pair in zip(first, _charges_of(study, study.second_battery, second=True), strict=True):
        yield from pair


def _charges_of(study: Study, battery: Battery, second: bool = False) -> Iterator[Draft]:
    # No figure enlarges a charge of the second battery.
    charge = study.charge.model_copy(update={"windows": []}) if second else study.charge
    parts = [*([] if second else ["waveform"]), "summary", "phases", "energy"]
    for comparison, mode_name, mode in compared_modes(study, battery):
        settings = {
            "battery": _untitled(battery, battery.name),
            "mode": _untitled(mode, mode_name),
            "charge": plain(charge),
            "engine": plain(study.engine),
        }
        place = f"{'second/' if second else ''}charge/{comparison}/{mode_name}"
        modes = (f"modes.{name}" for name in (mode_name, _reference(study, comparison)))
        yield Draft(
            "charge",
            charge_name(comparison, mode_name, second),
            f"{'second.' if second else ''}{comparison}.{mode_name}",
            settings,
            inputs=_charge_inputs(study),
            sections=("second_battery" if second else "battery", "charge", *modes),
            shown={"trace.bdf.parquet": f"{place}.bdf.parquet"}
            | {f"{part}.parquet": f"{place}.{part}.parquet" for part in parts},
        )


def _reference(study: Study, comparison: str) -> str | None:
    """Return the mode whose current sets that of the others in a comparison, if it has one."""
    return study.comparisons[comparison].mean_current_of


def _charge_inputs(study: Study) -> dict[str, str]:
    return {"engine": "engine"} | ({"supply": "supply"} if study.panel is not None else {})


def _ensemble(study: Study) -> Iterator[Draft]:
    varied = {path: source for path, source in study.sources.items() if _below(path, ("battery", "modes", "charge"))}
    ranges = {path: list(source.range) for path, source in varied.items() if source.range is not None}
    followers = {
        path: leader
        for path, source in varied.items()
        if source.same_as and (leader := f"{path.rpartition('.')[0]}.{source.same_as}") in ranges
    }
    if study.ensemble.samples == 0 or not ranges:
        return
    charge = study.charge.model_copy(update={"windows": []})
    yield Draft(
        "ensemble",
        "ensemble",
        study.study.name,
        plain(
            {
                "battery": _untitled(study.battery, study.battery.name),
                "modes": {
                    name: _slowed(_untitled(mode, name), study.ensemble.pulse_frequency_hz)
                    for name, mode in study.modes.items()
                },
                "charge": charge,
                "engine": study.engine,
                "ensemble": study.ensemble,
                "ranges": ranges,
                "followers": followers,
                "seed": study.seed,
                "run": study.run,
                "comparisons": {name: card.mean_current_of for name, card in study.comparisons.items()},
                "stops": {name: card.stops for name, card in study.comparisons.items() if card.stops is not None},
            }
        ),
        inputs=_charge_inputs(study),
        sections=("battery", "modes", "charge"),
        shown={"ensemble.parquet": "published/ensemble.parquet"},
    )


def _untitled(record: Record, name: str) -> dict[str, Any]:
    """Return a record with its name for a title: titles are for readers, and changing one must compute nothing."""
    return {**plain(record), "title": name}


def _slowed(tree: Any, frequency_hz: float) -> Any:
    """Return a mode with every pulse at one frequency: also one whose frequency is yet to be found."""
    if not isinstance(tree, dict):
        return tree
    slowed = {key: _slowed(value, frequency_hz) for key, value in tree.items()}
    return slowed | {key: frequency_hz for key in tree if key.endswith("frequency_hz")}


def _verdicts(study: Study, nodes: list[Draft]) -> Iterator[Draft]:
    if not study.published:
        return
    known = {node.name for node in nodes}
    inputs = {name: name for statement in study.published.values() for name in needs(statement) if name in known}
    inputs |= {"ensemble": "ensemble"} if "ensemble" in known else {}
    settings = {
        "statements": _named(study.published),
        "calibrated": _calibrated(
            study, nodes, {identifier: needs(statement) for identifier, statement in study.published.items()}
        ),
    }
    shown = {"verdicts.parquet": "published/verdicts.parquet"}
    if study.second_battery is not None:
        asked = {
            identifier: {of_second(name) for name in needs(statement)}
            for identifier, statement in answered_by_charges(study.published).items()
        }
        inputs |= {name: name for names in asked.values() for name in names if name in known}
        settings["second_calibrated"] = _calibrated(study, nodes, asked)
        shown["second.parquet"] = "second/verdicts.parquet"
    yield Draft("verdicts", "verdicts", study.study.name, settings, inputs=dict(sorted(inputs.items())), shown=shown)


def _calibrated(study: Study, nodes: list[Draft], asked: Mapping[str, Iterable[str]]) -> dict[str, list[str]]:
    """Return for each statement the parameters that were fitted to it and reach its answer, where there are any."""
    by_name = {node.name: node for node in nodes}
    found = {
        identifier: sorted(_fitted(study, by_name, {name for name in names if name in by_name}, identifier))
        for identifier, names in asked.items()
    }
    return {identifier: paths for identifier, paths in found.items() if paths}


def _fitted(study: Study, by_name: Mapping[str, Draft], names: set[str], statement: str) -> set[str]:
    """Return the parameters that were fitted to a statement and reach its answer through the plan's edges."""
    waiting, seen = list(names), set[str]()
    while waiting:
        name = waiting.pop()
        if name not in seen:
            seen.add(name)
            waiting.extend(by_name[name].inputs.values())
    sections = tuple(section for name in seen for section in by_name[name].sections)
    return {
        path
        for path, source in study.sources.items()
        if source.to == f"{study.study.name}.{statement}" and _below(path, sections)
    }


def _figures(study: Study, nodes: list[Draft]) -> Iterator[Draft]:
    made = {_kind(node) for node in nodes}
    for identifier, card in study.figures.items():
        if {*FINDERS, SECOND, "functions", "day"} & set(card.reads) - made:
            continue
        inputs = {node.name: node.name for node in nodes if _wanted(node, card.reads, card.comparison)}
        yield with_found(
            Draft(
                "figures",
                f"figure/{identifier}",
                identifier,
                {
                    "id": identifier,
                    "card": plain(card),
                    "settings": _configured(study, card.reads),
                    **_labels(study, knobs="modes" in card.reads),
                    **(_cells(study) if SECOND in card.reads else {}),
                },
                inputs=inputs,
                shown={f"{identifier}.{kind}": f"figures/{identifier}.{kind}" for kind in ("svg", "png")},
                view="reports",
                modules=(f"pipeline.report.figures.{card.draw}",),
            )
        )


def _wanted(node: Draft, reads: Iterable[str], comparison: str | None) -> bool:
    if _kind(node) not in reads:
        return False
    return node.step != "charge" or comparison is None or node.name.split("/")[1] == comparison


def _kind(node: Draft) -> str:
    """Return the step of a node, those that charge the second battery told from the others."""
    return SECOND if node.name.startswith(f"{SECOND}/") else node.step


def _labels(study: Study, knobs: bool = False) -> dict[str, Any]:
    """What every reader of charges needs to name them: titles, and where asked for the modes' knobs."""
    modes = [
        {"name": name, "title": study.modes[name].title, "knobs": plain(study.modes[name].knobs) if knobs else {}}
        for name in study.run
    ]
    comparisons = [{"name": name, "title": comparison.title} for name, comparison in study.comparisons.items()]
    return {"modes": modes, "comparisons": comparisons}


def _cells(study: Study) -> dict[str, Any]:
    """What a reader of both batteries' charges needs to name them."""
    both = (study.battery, study.second_battery)
    return {"cells": [battery.title for battery in both if battery is not None]}


def _configured(study: Study, reads: Iterable[str]) -> dict[str, Any]:
    """What a figure draws of the configuration itself."""
    found: dict[str, Any] = {}
    if "system" in reads:
        found["system"] = plain({"panel": study.panel, "converter": _averaged(study), "load": study.load})
        found["system"]["battery"] = {"title": study.battery.title, "capacity_ah": study.battery.capacity_ah}
        found["system"]["discharge_voltage_v"] = study.objective.discharge_voltage_v if study.objective else None
    if "algorithm" in reads and study.search is not None:
        found["algorithm"] = plain(study.search.model_copy(update={"variants": {}}))
    if "trade_off" in reads and study.trade_off is not None:
        found["trade_off"] = plain(study.trade_off)
    if "day" in reads and study.day is not None:
        found["day"] = day_labels(study)
    if "battery" in reads:
        found["battery"] = plain(study.battery)
    if "tracking" in reads:
        found["tracking"] = tracking_titles(study)
    if "stage_search" in reads:
        found["stage_search"] = used_settings(study)
    return found


def _named(records: Mapping[str, Record]) -> list[dict[str, Any]]:
    """Return records as a list: where their order counts, it must count in the key too."""
    return [{"name": name, **plain(record)} for name, record in records.items()]


_SHOWN = frozenset(
    {
        *("panel", "supply", "chaos", "objective", "tuning", "search", *NETWORK_STEPS, "functions", "charge"),
        *("weather", "day", "switched", "tracking", "converters", "validation", "trade_off", "staging_search"),
        *("staging", "front", "verdicts", "figures"),
    }
)


def _page(study: Study, nodes: list[Draft]) -> Iterator[Draft]:
    drawn = {node.label for node in nodes if node.step == "figures"}
    yield Draft(
        "page",
        "page",
        study.study.name,
        {
            "study": plain(study.study),
            "battery": study.battery.title,
            "figures": _named({name: card for name, card in study.figures.items() if name in drawn}),
            "parameters": _parameters(study, {node.step for node in nodes}),
            "command": command(study.study.name, study.overrides),
            "overrides": list(study.overrides),
            "settings": _configured(study, ("trade_off", "tracking", "day")),
            **_labels(study),
            **_searched(study, nodes),
            **(_cells(study) if study.second_battery is not None else {}),
            **headings(study),
        },
        inputs={node.name: node.name for node in nodes if node.step in _SHOWN},
        shown={"*": ""},
        view="reports",
    )


def _searched(study: Study, nodes: list[Draft]) -> dict[str, list[float]]:
    """Return the range of frequencies of a search that is run."""
    if study.search is None or "search" not in {node.step for node in nodes}:
        return {}
    limits = study.search.variables[VARIABLE]
    return {"searched": [limits.low, limits.high]}


def _parameters(study: Study, steps: set[str]) -> list[dict[str, Any]]:
    """Return every parameter with its source, without those of a search or tuning that is not run."""
    left_out = [section for section, step in SECTION_OF.items() if step not in steps]
    values = {path: value for section in study.parameter_sections() for path, value in study.parameters(section)}
    return [
        {"path": path, "value": values[path], **plain(source)}
        for path, source in study.sources.items()
        if not _below(path, left_out)
    ]


def _below(path: str, sections: Iterable[str]) -> bool:
    return any(path == section or path.startswith(section + ".") for section in sections)
