"""What a run is told in: the verdicts on a paper's statements, the figures, the page."""

from __future__ import annotations

import shlex
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any

from pydantic import Field

from pipeline.config.compose import options
from pipeline.config.naming import run_name
from pipeline.config.units import unit_of
from pipeline.errors import UserError, best_matches
from pipeline.experiments.reporting.verdicts import SECOND, answered_by_charges, of_second
from pipeline.kernel import registry
from pipeline.kernel.draft import paths, plain, reads_behind
from pipeline.kernel.experiment import EVERYTHING, Draft, Experiment, Node, Step
from pipeline.kernel.footprint import Footprint
from pipeline.kernel.planfile import command
from pipeline.kernel.scope import below
from pipeline.kernel.tables import TableFile
from pipeline.published.answer import ANSWER, Choice
from pipeline.published.ensemble import NAME as ENSEMBLE
from pipeline.published.evaluate import VERDICTS
from pipeline.published.operands import values
from pipeline.published.records import Statement, needs
from pipeline.record import Record
from pipeline.report.records import FigureCard

REFERENCE = "conf/published/reference/*.csv"


class ReportingPart(Record):
    """What a study shows, and what its paper says."""

    figures: dict[str, FigureCard] = Field(default_factory=dict)
    published: dict[str, Statement] = Field(default_factory=dict)
    called: dict[str, str] = Field(
        default_factory=dict,
        description="what the sentences of verdicts call a quantity, column, mode or comparison whose name does not "
        "read well",
    )
    answer: dict[str, Choice] = Field(default_factory=dict, description="in what the study's alternatives are compared")
    hero: str = Field(default="", description="figure that shows the answer; the first of the page without")
    captions: dict[str, str] = Field(
        default_factory=dict, description="the paper's own captions, by `Figure 11` or `Table 2`"
    )
    not_drawn: dict[str, str] = Field(
        default_factory=dict, description="why a figure or table of the paper has none of ours, by the same names"
    )


def _judged(config: Any, calibrated: Any, second_calibrated: Any, **_: Any) -> dict[str, Any]:
    titles = {name: config.modes[name].title for name in config.run}
    alone = {name: "" for name in config.comparisons if len(config.comparisons) == 1}
    return {
        "called": [{"name": name, "words": words} for name, words in (titles | alone | config.called).items()],
        "statements": named(config.published),
        "answer": named(config.answer),
        "calibrated": calibrated,
        "second_calibrated": second_calibrated,
    }


def _drawn(config: Any, figure: str, labels: list[str], **_: Any) -> dict[str, Any]:
    return {"id": figure, "card": config.figures[figure], "settings": _labelled(config, labels), **_titles(config)}


def _told(
    config: Any,
    figures: list[str],
    pages: list[str],
    labels: list[str],
    units: Mapping[str, str],
    made: Collection[str],
    rests: Mapping[str, Any],
    place: str,
    **_: Any,
) -> dict[str, Any]:
    return {
        "place": place,
        "rests": rests,
        "hero": config.hero,
        "captions": dict(config.captions),
        "not_drawn": dict(config.not_drawn),
        "seed": config.seed,
        "study": config.study,
        "battery": config.battery.title,
        "figures": named({name: config.figures[name] for name in figures}),
        "pages": pages,
        "parameters": _parameters(config, units, made),
        "command": command(config.study.name, config.overrides),
        "overrides": list(config.overrides),
        "settings": _labelled(config, labels),
        **_titles(config),
    }


_TITLES = ("run", "modes.{modes}.title", "comparisons.{comparisons}.title")

JUDGED = Step(
    "verdicts",
    rule="judge_statements",
    message="Verdicts on the published statements: {chunk}",
    settings=_judged,
    reads=("published", "answer", "called", *_TITLES),
    takes=(EVERYTHING,),
    tables={name: TableFile(f"{name}.parquet", VERDICTS) for name in ("verdicts", "second")}
    | {"answer": TableFile("answer.parquet", ANSWER)},
    chunk=(1, 32),
    files=(REFERENCE,),
)
DRAWN = Step(
    "figures",
    rule="draw_figures",
    message="Figures: {chunk}",
    effort=Footprint(node_s=1.0),
    settings=_drawn,
    reads=("figures.{figure}", "{labelled}", *_TITLES),
    takes=(EVERYTHING,),
    target="figures",
    chunk=(7, 14),
    files=("src/pipeline/report/*.mplstyle",),
)
TOLD = Step(
    "page",
    rule="write_page",
    message="Report page: {chunk}",
    settings=_told,
    # Titles of the battery and the modes, and what labels read, are among the parameters.
    reads=(
        *("study", "overrides", "configuration", "run", "comparisons.{comparisons}.title", "hero", "captions", "seed"),
        *("not_drawn", "figures.{figures}", "{parameters}"),
    ),
    takes=(EVERYTHING, "verdicts", "figures"),
    chunk=(1, 8),
    files=("src/pipeline/report/templates/*", REFERENCE),
    shown=False,
)


_NAMING = ("mode", "weights", "searches", "functions")
"""Options of figures that name modes, or what the names of an experiment's quantities are made of."""


def check(study: Any) -> None:
    """Refuse a figure that names what the run does not have.

    Raises
    ------
    UserError : with the key path, the name, and those there are.
    """
    fields = [one.fields(study) for one in registry.experiments().values()]
    words = {str(word) for steps in fields for named in steps.values() for listed in named.values() for word in listed}
    known = {word for word in words if word.isidentifier()} | set(options("modes")) | set(study.modes)
    if study.hero and study.hero not in study.figures and any(one.startswith("hero=") for one in study.overrides):
        raise UserError(f"hero: no figure {study.hero!r} in this run; {best_matches(study.hero, study.figures)}")
    for name, card in study.figures.items():
        path = f"figures.{name}"
        if card.comparison is not None and card.comparison not in study.comparisons:
            near = best_matches(card.comparison, study.comparisons)
            raise UserError(f"{path}.comparison: no comparison {card.comparison!r} in this run; {near}")
        # A card of the study's own may show what a run leaves out; one that is changed says what it means.
        keys = [word.lstrip("+").split("=")[0] for word in study.overrides]
        if not any(key == path or key.startswith(f"{path}.options") for key in keys):
            continue
        for option in _NAMING:
            asked = card.options.get(option, ())
            for word in [asked] if isinstance(asked, str) else asked:
                if word not in known:
                    raise UserError(f"{path}.options.{option}: this run has no {word!r}; {best_matches(word, known)}")


def closing(study: Any, made: Sequence[Draft]) -> Iterator[Node]:
    """Yield the verdicts, the figures and the page of a run, from what else it makes."""
    found = [*_verdicts(study, made), *_figures(study, made)]
    yield from found
    yield _page(study, made, found)


def _verdicts(study: Any, made: Sequence[Draft]) -> Iterator[Node]:
    if not study.published:
        return
    asked = {name: needs(stated) for name, stated in study.published.items()}
    shown = {f"{name}.parquet": f"published/{name}.parquet" for name in ("verdicts", "answer")}
    second: Mapping[str, Iterable[str]] | None = None
    if study.second_battery is not None:
        shown["second.parquet"] = "second/verdicts.parquet"
        by_charges = answered_by_charges(study.published)
        second = {name: {of_second(one) for one in asked[name]} for name in by_charges}
    known = {node.name for node in made}
    wanted = {name for names in (*asked.values(), *(second or {}).values()) for name in names}
    wanted |= {value.artefact for one in study.answer.values() for what in one.among.values() for value in values(what)}
    wanted |= {node.name for node in made if node.kind == ENSEMBLE}
    which = {
        "calibrated": _calibrated(study, made, asked),
        "second_calibrated": None if second is None else _calibrated(study, made, second),
        **_choices(study),
    }
    inputs = {name: name for name in sorted(wanted & known)}
    yield Node(JUDGED, "verdicts", study.study.name, which, inputs=inputs, shown=shown)


def _calibrated(study: Any, made: Sequence[Draft], asked: Mapping[str, Iterable[str]]) -> dict[str, list[str]]:
    """Return for each statement the parameters that were fitted to it and reach its answer, where there are any."""
    by_name = {node.name: node for node in made}
    found: dict[str, list[str]] = {}
    for name, artefacts in asked.items():
        reads = reads_behind(by_name, (one for one in artefacts if one in by_name))
        fitted_to = {f"{study.study.name}.{one}" for one in (name, study.published[name].fitted_with) if one}
        fitted = [path for path, source in study.sources.items() if source.to in fitted_to and below(path, reads)]
        found |= {name: sorted(fitted)} if fitted else {}
    return found


def _figures(study: Any, made: Sequence[Draft]) -> Iterator[Node]:
    kinds = {node.kind for node in made}
    needed = {name for name, step in registry.steps().items() if step.needed_by_figures} | {SECOND}
    for name, card in study.figures.items():
        if needed & set(card.reads()) - kinds:
            continue
        inputs = {node.name: node.name for node in made if _wanted(node, card)}
        labels = [label for label in card.reads() if label in registry.labels()]
        which = {"figure": name, "labels": labels, "labelled": _label_reads(labels), **_choices(study)}
        shown = {f"{name}.{kind}": f"figures/{name}.{kind}" for kind in ("svg", "png")}
        yield Node(DRAWN, f"figure/{name}", name, which, inputs, shown, room="reports", modules=(card.module,))


def _wanted(node: Draft, card: FigureCard) -> bool:
    if node.kind not in card.reads():
        return False
    return node.step != "charge" or card.comparison is None or node.name.split("/")[1] == card.comparison


def _page(study: Any, made: Sequence[Draft], found: Sequence[Node]) -> Node:
    steps = {node.step for node in made}
    owners = {registry.owners()[step] for step in steps}
    pages = {name: module for name, module in registry.pages().items() if name in owners}
    labels = list(dict.fromkeys(label for module in pages.values() for label in import_module(module).LABELS))
    drawn = [node for node in found if node.step is DRAWN]
    shown = {name for name, step in registry.steps().items() if step.shown}
    inputs = [node.name for node in made if node.step in shown] + [node.name for node in found]
    which = {
        "figures": [node.label for node in drawn],
        "place": f"{study.study.name}/{run_name(study.overrides)}",
        "rests": _rests(study, made, drawn),
        "made": sorted(steps),
        "pages": list(pages.values()),
        "labels": labels,
        "parameters": list(dict.fromkeys([*study.parameter_sections(), *_label_reads(labels)])),
        "units": _units(study, _unused(steps)),
        **_choices(study),
    }
    edges = {name: name for name in inputs}
    modules = tuple(pages.values())
    return Node(TOLD, "page", study.study.name, which, edges, {"*": ""}, room="reports", modules=modules)


def _rests(study: Any, made: Sequence[Draft], drawn: Sequence[Node]) -> dict[str, Any]:
    """Return for each statement what its answer rests on, as a page tells it."""
    by_name = {node.name: node for node in made}
    owners, file = registry.owners(), _published_in(study)
    found = {}
    for name, stated in study.published.items():
        asked = sorted(needs(stated))
        own = [by_name[one] for one in asked if one in by_name]
        reads = reads_behind(by_name, (node.name for node in own))
        behind = [path for path in study.sources if below(path, reads)]
        found[name] = {
            "artefacts": asked,
            "figures": [node.label for node in drawn if not set(node.inputs).isdisjoint(asked)],
            "owners": sorted({owners[node.step] for node in own}),
            "parameters": list(dict.fromkeys(path.split(".")[0] for path in behind)),
            "fitted": [path for path in behind if study.sources[path].kind in ("calibrated", "fitted")],
            "file": file,
            "key": name if file.startswith("conf/published") else f"published.{name}",
            "command": _again(study, own),
            "title": stated.title,
        }
    return found


def _published_in(study: Any) -> str:
    """Return the file in which a study's statements are written."""
    name = study.study.name
    return f"conf/published/{name}.yaml" if name in options("published") else f"conf/study/{name}.yaml"


_FEW = 3


def _again(study: Any, own: Sequence[Draft]) -> str:
    """Return the command that computes some nodes again and compares; the verdicts where a statement needs none."""
    steps = registry.steps()
    rules = sorted({steps[node.step].rule for node in own}) or [JUDGED.rule]
    view = f"results/{study.study.name}/{run_name(study.overrides)}"
    places = [f"{view}/{_usual(node)}" for node in own if node.shown and node.room == "results"]
    targets = {steps[node.step].target for node in own} - {None}
    words = places if 0 < len(places) <= _FEW else sorted(map(str, targets)) or [f"{view}/published/verdicts.parquet"]
    composed = " ".join([f"study={study.study.name}", *map(shlex.quote, study.overrides)])
    chosen = f"--config overrides={shlex.quote(composed)}"
    return f"snakemake --cores 2 {' '.join(map(shlex.quote, words))} {chosen} --forcerun {' '.join(rules)}"


def _usual(node: Draft) -> str:
    """Return the place of the table that a statement means where it names none; else that of the first."""
    step = registry.steps()[node.step]
    file = "" if step.usual_table is None else step.tables[step.usual_table].file
    return node.shown.get(file, next(iter(node.shown.values())))


def _unused(steps: Iterable[str]) -> list[str]:
    """Return the parts of the configuration that only steps on demand read, which this run does not take."""
    known = registry.steps().values()
    asked = {path for step in known for path in step.reads if not step.on_demand or step.name in steps}
    left = {path for step in known for path in step.reads if step.on_demand and step.name not in steps}
    return sorted(path for path in left if "{" not in path and not below(path, asked))


def _choices(study: Any) -> dict[str, list[str]]:
    return {"modes": list(study.run), "comparisons": list(study.comparisons)}


def _label_reads(labels: Iterable[str]) -> list[str]:
    return [path for label in labels for read in registry.labels()[label].reads for path in paths(read, {})]


def _labelled(config: Any, labels: Iterable[str]) -> dict[str, Any]:
    return {label: registry.labels()[label].make(config) for label in labels}


def _titles(config: Any) -> dict[str, Any]:
    """Return what every reader of charges needs to name them."""
    return {
        "modes": [{"name": name, "title": config.modes[name].title} for name in config.run],
        "comparisons": [{"name": name, "title": card.title} for name, card in config.comparisons.items()],
    }


def _units(study: Any, unused: Iterable[str]) -> dict[str, str]:
    """Return the unit of every parameter that has a source, without those that this run does not use."""
    return {path: unit_of(study, path) for path in study.sources if not below(path, unused)}


def _parameters(config: Any, units: Mapping[str, str], made: Collection[str]) -> list[dict[str, Any]]:
    """Return every parameter with its unit and source; what a step would find that this run leaves out, in words."""
    values = {path: value for section in config.parameter_sections() for path, value in config.parameters(section)}
    return [
        {"path": path, "value": _shown(values[path], made), "unit": units[path], **plain(source)}
        for path, source in config.sources_below(*config.parameter_sections()).items()
        if path in units
    ]


def _shown(value: Any, made: Collection[str]) -> Any:
    """Return a value, or in words a reference to one that no step of the run finds."""
    left_out = isinstance(value, Mapping) and set(value) == {"from", "value"} and value["from"] not in made
    return f"{value['value']} of {value['from']}" if left_out else value


def named(records: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return records as a list: where their order counts, it must count in the key too."""
    return [{"name": name, **plain(record)} for name, record in records.items()]


EXPERIMENT = Experiment(
    title="verdicts, figures and the page",
    steps=(JUDGED, DRAWN, TOLD),
    part=ReportingPart,
    checks=(check,),
    closing=closing,
    announces="announce",
)
