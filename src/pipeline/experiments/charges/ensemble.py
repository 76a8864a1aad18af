"""Ensemble: the study's charges over points of the estimated parameters in; what statements read of them out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pipeline.cell.records import Battery
from pipeline.charge.comparison import compared, level_of
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import Charge, Supply, Task, try_many
from pipeline.experiments.charges.charge import supply
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.digest import canonical
from pipeline.kernel.tables import TableFile
from pipeline.published import ensemble

BATCH = 16
"""Points whose charges are held at once."""
Name = tuple[str, str]


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Charge in every point whatever statements read."""
    points = ensemble.draw(settings["estimated"], settings["points"], settings["seed"])
    source, rows = supply(inputs), list[ensemble.Row]()
    engine = EngineSettings.model_validate(settings["engine"])
    for start in range(0, len(points), BATCH):
        batch = enumerate(points[start : start + BATCH], start)
        prepared = [(number, *_prepared(settings, values, source, engine)) for number, values in batch]
        tasks = [task for _, _, own in prepared for task in own.values()]
        done = iter(try_many(tasks, ensemble.IMPOSSIBLE))
        for number, sheets, own in prepared:
            charges = {sheet: found for sheet in own if isinstance(found := next(done), Charge)}
            rows += _answers(number, settings, {name: charges.get(sheet) for name, sheet in sheets.items()})
        print(f"{min(start + BATCH, len(points))} of {len(points)} points", flush=True)
    output.rows("ensemble", rows)


def _prepared(
    settings: Mapping[str, Any], values: Mapping[str, float], source: Supply, engine: EngineSettings
) -> tuple[dict[Name, str], dict[str, Task]]:
    """Return the sheet of every charge, empty where no charger can have it, and the task of every sheet."""
    tree = ensemble.with_values({name: settings[name] for name in ("battery", "modes", "charge")}, values)
    asked: list[Name] = [(comparison, name) for comparison, name in settings["charges"]]
    sheets = dict.fromkeys(asked, "")
    tasks: dict[str, Task] = {}
    try:
        battery = Battery.model_validate(tree["battery"])
        charge = ChargeSettings.model_validate(tree["charge"])
        modes = {key: Mode.model_validate(one) for key, one in tree["modes"].items()}
    except ensemble.IMPOSSIBLE:
        return sheets, tasks
    for comparison, name in asked:
        level = level_of(settings["comparisons"][comparison], modes)
        try:
            mode = compared(modes[name], level, battery, settings["stops"].get(comparison))
        except ensemble.IMPOSSIBLE:
            continue
        sheet = sheets[comparison, name] = canonical([name, mode.model_dump(mode="json")])
        tasks.setdefault(sheet, Task(battery, mode, source, charge, engine))
    return sheets, tasks


def _answers(point: int, settings: Mapping[str, Any], charges: Mapping[Name, Charge | None]) -> Iterator[ensemble.Row]:
    """Yield what is asked of a point; charges that no charger accepts make impossible what reads them."""
    held = {f"charge/{'/'.join(name)}": _tables(done) for name, done in charges.items() if done is not None}
    declared = {name: TableFile.of(table) for name, table in settings["tables"].items()}
    reader = ensemble.reader(held, {"charge": declared})
    for one in settings["asked"]:
        possible = all(charges.get((c, m)) is not None for c, m in _read(one))
        yield from ensemble.answers(point, [one], reader if possible else None)


def _read(asked: Any) -> Iterator[Name]:
    """Yield the charges that an operand, as plain data, reads."""
    if isinstance(asked, Mapping):
        if "artefact" in asked:
            _, comparison, mode = asked["artefact"].split("/")
            yield comparison, mode
        asked = list(asked.values())
    if isinstance(asked, list | tuple):
        for part in asked:
            yield from _read(part)


def _tables(done: Charge) -> dict[str, Mapping[str, Any]]:
    summary = {name: [getattr(row, name) for row in done.summary] for name in ("quantity", "value", "text", "unit")}
    # A number that a charge did not get to is empty.
    summary["value"] = [float("nan") if value is None else value for value in summary["value"]]
    return {"trace": done.trace, "summary": summary, "phases": done.phases, "energy": done.energy}
