"""The charges on the page: their results, their energy balance, both batteries side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pipeline.experiments.charges import second_cell
from pipeline.report.pages import PageFigure, PageSection
from pipeline.report.tables import JOULES_PER_WATT_HOUR, Cell, Columns, ReportData, ReportTable, plain, sentence
from pipeline.report.traces import Trace

LABELS = ("cells", "scaled", "beyond")
_TRACED = {
    "Voltage [V]": ("Voltage / V", 1.0),
    "Current [A]": ("Current / A", 1.0),
    "Temperature [°C]": ("Surface Temperature / degC", 1.0),
    "State of charge [%]": ("soc", 100.0),
    "Charge put in [Ah]": ("Charging Capacity / Ah", 1.0),
    "Energy put in [Wh]": ("Charging Energy / Wh", 1.0),
    "Side reaction [A]": ("side_current_a", 1.0),
}


def tables(data: ReportData) -> list[ReportTable]:
    """Return the tables of the charges; none where nothing is charged."""
    return [charges(data), energy(data)] if data.inputs.of_kind("charge") else []


def traces(data: ReportData) -> list[Trace]:
    """Return the curves of every charge for the explorer, those of a second battery behind the first's."""
    found = [*_traces(data, "", "")]
    titles = second_cell.cells(data)
    if len(titles) > 1:
        found += _traces(second_cell.second(data), "second/", f", {titles[1]}")
    return found


def _traces(data: ReportData, prefix: str, of_battery: str) -> Iterator[Trace]:
    for comparison in data.shown(None):
        for mode in data.charged(comparison):
            trace = data.charge(comparison, mode, "trace")
            quantities = {name: factor * trace[column] for name, (column, factor) in _TRACED.items()}
            yield Trace(
                f"{prefix}{comparison}/{mode}",
                data.modes[mode].title,
                f"{data.comparisons[comparison]}{of_battery}",
                list(data.modes).index(mode),
                trace["Test Time / s"],
                quantities,
            )


def notes(data: ReportData) -> list[str]:
    """Return sentences: what a comparison scaled; what charges missed, goals and why, phases that did not run."""
    scaled = [
        f"{data.modes[mode].title} ({data.comparisons[comparison]}): {told}."
        for comparison, modes in data.settings.get("scaled", {}).items()
        for mode, told in modes.items()
    ]
    titles = second_cell.cells(data)
    second = [] if len(titles) < 2 else _missed(second_cell.second(data), f", {titles[1]}")
    beyond = [f"{sentence(str(told))}." for told in data.settings.get("beyond", {}).get("said", [])]
    return [*beyond, *scaled, *_missed(data, ""), *second]


def _missed(data: ReportData, of_battery: str) -> list[str]:
    found = []
    for comparison, title in data.comparisons.items():
        for mode in data.charged(comparison):
            summary = data.charge(comparison, mode, "summary")
            texts = dict(zip(map(str, summary["quantity"]), summary["text"], strict=True))
            if texts.get("missed"):
                found.append(f"{data.modes[mode].title} ({title}{of_battery}): {texts['missed']}.")
    return found


def sections(data: ReportData, figures: Sequence[PageFigure]) -> list[PageSection]:
    """Return the section on the second battery; none where the run has one battery.

    Arguments
    ---------
    figures : those of this experiment that the paper does not have.
    """
    titles = second_cell.cells(data)
    if len(titles) < 2 or "verdicts" not in data.inputs:
        return []
    first, others = (data.table("verdicts", name) for name in ("verdicts", "second"))
    shown = [second_cell.side_by_side(data)]
    if second_cell.differing(first, others):
        shown.insert(0, second_cell.statements(first, others, titles))
    text = second_cell.summary(first, others, titles)
    return [PageSection("second-cell", "Second battery", text, shown, _of_both(figures))]


def _of_both(figures: Sequence[PageFigure]) -> list[PageFigure]:
    return [figure for figure in figures if figure.draws == "two_cells"]


def charges(data: ReportData) -> ReportTable:
    """Return every quantity of the charges' summaries: a row per comparison and quantity, a column per mode."""
    rows: list[tuple[Cell, ...]] = []
    for comparison in data.shown(None):
        summaries = {mode: data.charge(comparison, mode, "summary") for mode in data.charged(comparison)}
        units = {
            str(n): str(u) for one in summaries.values() for n, u in zip(one["quantity"], one["unit"], strict=True)
        }
        found = {mode: _summary(one) for mode, one in summaries.items()}
        for quantity, unit in units.items():
            cells = tuple(found[mode].get(quantity) if mode in found else None for mode in data.modes)
            if any(cell not in (None, "") for cell in cells):
                rows.append((data.comparisons[comparison], quantity, unit, *cells))
    return ReportTable(
        "charges",
        "Charge results",
        "A dash: not reached.",
        ("comparison", "quantity", "unit", *(label.title for label in data.modes.values())),
        tuple(rows),
        grouped=True,
    )


def energy(data: ReportData) -> ReportTable:
    """Return where the energy of each charge went [Wh]: a row per comparison and path, a column per mode."""
    rows: list[tuple[Cell, ...]] = []
    for comparison in data.shown(None):
        found = {mode: data.charge(comparison, mode, "energy") for mode in data.charged(comparison)}
        paths = {
            str(path): str(role) for one in found.values() for path, role in zip(one["path"], one["role"], strict=True)
        }
        values = {
            mode: dict(zip(map(str, one["path"]), one["energy_j"].tolist(), strict=True)) for mode, one in found.items()
        }
        for path, role in paths.items():
            joules = [values.get(mode, {}).get(path) for mode in data.modes]
            watt_hours = (None if one is None else one / JOULES_PER_WATT_HOUR for one in joules)
            rows.append((data.comparisons[comparison], path, role, *watt_hours))
    return ReportTable(
        "energy",
        "Energy balance [Wh]",
        "Residual: the input less what is stored, lost and given off; the first law requires 0.",
        ("comparison", "path", "role", *(label.title for label in data.modes.values())),
        tuple(rows),
        grouped=True,
    )


def _summary(columns: Columns) -> dict[str, Cell]:
    rows = zip(columns["quantity"], columns["value"], columns["text"], strict=True)
    return {str(name): plain(text) if text else plain(value) for name, value, text in rows}
