"""The converters switch by switch on the page."""

from __future__ import annotations

from pipeline.report.tables import Cell, ReportData, ReportTable, plain

LABELS = ()
_COLUMNS = (
    ("window", "window"),
    ("ripple_a", "ripple / A"),
    ("overshoot_a", "overshoot / A"),
    ("settling_s", "settling / ms"),
    ("ringing_j", "ringing a period / µJ"),
    ("ringing_w", "ringing / µW"),
    ("conduction_efficiency", "conduction efficiency"),
)
_SCALE = {"settling_s": 1e3, "ringing_j": 1e6, "ringing_w": 1e6}


def tables(data: ReportData) -> list[ReportTable]:
    """Return what the steps of each mode come to, and the numbers of the boost converter; none where not computed."""
    if "switched" not in data.inputs:
        return []
    return [_modes(data), _boost(data)]


def _modes(data: ReportData) -> ReportTable:
    found = data.table("switched", "modes")
    rows: list[tuple[Cell, ...]] = []
    for row, (comparison, mode) in enumerate(zip(found["comparison"], found["mode"], strict=True)):
        numbers = (
            _SCALE[name] * float(found[name][row]) if name in _SCALE else plain(found[name][row])
            for name, _ in _COLUMNS
        )
        rows.append((data.comparisons[str(comparison)], data.modes[str(mode)].title, *numbers))
    return ReportTable(
        "switched_modes",
        "The steps of the pulses, switch by switch",
        "Of the battery's current: its ripple at the switching frequency; then, without this ripple, the largest "
        "overshoot and the longest settling time to 2 % of any step, and the heat of the ringing in the series "
        "resistance. The efficiency has conduction losses alone. The components and the control are estimates.",
        ("comparison", "mode", *(title for _, title in _COLUMNS)),
        tuple(rows),
        grouped=True,
    )


def _boost(data: ReportData) -> ReportTable:
    found = data.table("switched", "quantities")
    columns = (found[name] for name in ("quantity", "value", "unit", "description"))
    return ReportTable(
        "switched_boost",
        "The boost converter in numbers",
        "With the panel at maximum power and the bus at its voltage.",
        ("quantity", "value", "unit", "meaning"),
        tuple(tuple(map(plain, row)) for row in zip(*columns, strict=True)),
    )
