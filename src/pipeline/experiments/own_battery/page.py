"""Own measurements on the page: what the file holds, what the fit found, how well, and how the battery charges."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pipeline.report.pages import PageFigure, PageSection
from pipeline.report.tables import Cell, ReportData, ReportTable, plain

LABELS = ("own",)
_MOST_SEGMENTS = 60


def sections(data: ReportData, figures: Sequence[PageFigure]) -> list[PageSection]:
    """Return the sections of a run with an own measurement; none of any other run.

    Arguments
    ---------
    figures : those of this experiment.
    """
    if "own_fit" not in data.inputs:
        return []
    return [
        PageSection(
            "fit",
            "Measured and simulated",
            _summary(data),
            [_errors(data), *_limits(data), _structures(data)],
            list(figures),
        ),
        PageSection("card", "The card", _card_text(data), [_parameters(data)]),
        PageSection("unknown", "What the measurement does not tell", _unknown_text(data), [_foresight(data)]),
        PageSection("charges", "This battery on the charger", _charge_text(data), [_charges(data)]),
        PageSection("file", "The file", "", [_files(data), _notes(data), _segments(data)]),
    ]


def _summary(data: ReportData) -> str:
    found = data.numbers("own_fit")
    said = [
        f"The fitted battery meets the voltage to {1e3 * found['fit_voltage_rmse_v']:.2f} mV (rmse) where it was fitted"
    ]
    if "held_out_voltage_rmse_v" in found:
        said.append(f" and to {1e3 * found['held_out_voltage_rmse_v']:.2f} mV in what was held out, looked at once")
    if "fit_current_rmse_a" in found:
        said.append(
            f"; where the charger held a voltage, that drives the replay, and the current is met to "
            f"{1e3 * found['fit_current_rmse_a']:.2f} mA"
        )
    said.append(
        f". {found['unknowns']:.0f} numbers were fitted to {found['rows']:.0f} rows, worth "
        f"{found['effective_rows']:.0f} independent ones, since errors go together from row to row."
    )
    return "".join(said)


def _card_text(data: ReportData) -> str:
    found = data.numbers("own_fit")
    return (
        "battery.yaml beside this run's results is the card; in conf/battery it is a battery like any other. It holds "
        f"for a state of charge from {100 * found['lowest_soc']:.0f} to {100 * found['highest_soc']:.0f} %, currents "
        "up to "
        f"{found['highest_c_rate']:.2g}C and {found['lowest_temperature_c']:.0f} to "
        f"{found['highest_temperature_c']:.0f} degC. Hysteresis of the open-circuit voltage is not modelled: "
        "on the other branch the voltage is another."
    )


def _unknown_text(data: ReportData) -> str:
    names = data.table("own_fit", "parameters")
    rows = [
        (str(path), str(how))
        for path, told, how in zip(names["path"], names["identified"], names["how"], strict=True)
        if not told
    ]
    kept = [path for path, how in rows if how.startswith("keeps")]
    points = [path for path, _ in rows if ".value." in path]
    loose = [path for path, _ in rows if path not in (*kept, *points)]
    said = []
    if kept:
        said.append(f"Not identified, so that they keep the start card's value: {', '.join(kept)}.")
    if loose:
        said.append(f"Fitted, but known no better than before: {', '.join(loose)}.")
    if points:
        said.append(f"{len(points)} points of tables are not told by themselves and go with those beside them.")
    return " ".join(said) or "Every number that was fitted is known better than before."


def _charge_text(data: ReportData) -> str:
    notes = [str(note) for note in data.table("own_charges", "notes")["note"]]
    text = (
        "Intervals are those of the fit, carried through by draws from its distribution; they hold if the model does."
    )
    return " ".join([text, *(f"{note[:1].upper()}{note[1:]}." for note in notes)])


def _notes(data: ReportData) -> ReportTable:
    rows = []
    for note in data.table("own_reading", "notes")["note"]:
        name, _, said = str(note).partition(": ")
        rows.append((name, said))
    return ReportTable(
        "read", "What was found in the files and done to them", "", ("file", "what"), tuple(rows), grouped=True
    )


def _errors(data: ReportData) -> ReportTable:
    names = _names(data)
    rows: list[tuple[Cell, ...]] = []
    for row in _rows(data, "own_fit", "errors"):
        factor, unit = (1e3, f"m{row['unit']}") if row["unit"] in ("V", "A") else (1.0, str(row["unit"]))
        sizes = (factor * float(row[name]) for name in ("rmse", "p95", "largest"))
        rows.append((str(row["part"]), names[int(row["file"])], row["quantity"], unit, *sizes, plain(row["at_s"])))
    return ReportTable(
        "errors",
        "Simulated less measured",
        "Over every row of the file; the fit did not see what was held out.",
        ("part", "file", "quantity", "unit", "rmse", "95th percentile", "largest", "at / s"),
        tuple(rows),
        grouped=True,
    )


def _limits(data: ReportData) -> list[ReportTable]:
    names, rows = _names(data), list(_rows(data, "own_fit", "limits"))
    if not rows:
        return []
    whole = [
        row for row in _rows(data, "own_fit", "errors") if row["part"] == "held out" and row["quantity"] == "voltage"
    ]
    shown: list[tuple[Cell, ...]] = []
    said, is_left = [], False
    for place, before in ((int(row["file"]), 1e3 * float(row["rmse"])) for row in whole):
        found = {str(row["freed"]): 1e3 * float(row["rmse_v"]) for row in rows if int(row["file"]) == place}
        if not found:
            continue
        shown += [(names[place], "nothing: the prediction", before), *((names[place], *one) for one in found.items())]
        alone = min((freed for freed in found if " and " not in freed), key=lambda freed: found[freed])
        verb = "matter" if alone == "the resistances" else "matters"
        said.append(
            f"{names[place]}: of single parts {alone} {verb} most, {before:.0f} mV become {found[alone]:.0f} mV; "
            f"at best {min(found.values()):.0f} mV are left, which no such change takes away."
        )
        is_left |= min(found.values()) > 0.7 * before
    return [
        ReportTable(
            "limits",
            "What limits the prediction",
            "The error with one part of the card found from the held-out file itself, the rest as it was fitted; none "
            f"of it is in the card. {' '.join(said)}{_form(data, is_left)}",
            ("file", "found from it", "rmse / mV"),
            tuple(shown),
            grouped=True,
        )
    ]


def _form(data: ReportData, is_left: bool) -> str:
    """Return that the form of the open-circuit voltage may be what limits a fit, where it is no table."""
    paths = data.table("own_fit", "parameters")["path"]
    if not is_left or any(str(path).startswith("open_circuit_voltage_v.value.") for path in paths):
        return ""
    return (
        " The form of the card's open-circuit voltage may be what limits it, since it cannot bend where the "
        "measurement does: own_battery.open_circuit_points=11 makes it a table."
    )


def _structures(data: ReportData) -> ReportTable:
    rows = tuple(
        (
            str(row["structure"]), int(row["unknowns"]), int(row["blocks"]), _milli(row["left_out_v"]),
            _milli(row["seen_v"]), "chosen" if row["chosen"] else None,
        )
        for row in _rows(data, "own_fit", "structures")
    )  # fmt: skip
    return ReportTable(
        "structures",
        "Structures compared",
        "By cross-validation inside the fitted part: the typical error in a stretch that was left out; the simplest "
        "within the noise of the best is chosen.",
        ("structure", "numbers", "stretches", "left out / mV", "seen / mV", ""),
        rows,
    )


def _parameters(data: ReportData) -> ReportTable:
    rows = tuple(
        (
            str(row["path"]), plain(row["soc"]), str(row["unit"]), plain(row["start"]), plain(row["value"]),
            plain(row["low"]), plain(row["high"]), str(row["how"]),
        )
        for row in _rows(data, "own_fit", "parameters")
    )  # fmt: skip
    return ReportTable(
        "fitted_parameters",
        "Fitted numbers",
        "95 % intervals, those of numbers outside tables from profiles; what the measurement leaves open of the "
        "numbers that keep their priors is in those of the others.",
        ("number", "SOC", "unit", "start card", "fitted", "from", "to", "how"),
        rows,
    )


def _foresight(data: ReportData) -> ReportTable:
    rows = tuple(
        tuple(str(row[name]) for name in ("quantity", "told", "why", "test"))
        for row in _rows(data, "own_reading", "foresight")
    )
    return ReportTable(
        "foresight",
        "What the measurement can tell",
        "From its segments, before any fit.",
        ("quantity", "told", "why", "what would tell it"),
        rows,
    )


def _charges(data: ReportData) -> ReportTable:
    rows = tuple(
        (
            data.modes[str(row["mode"])].title, str(row["quantity"]).replace("_", " "), str(row["unit"]),
            plain(row["value"]), plain(row["low"]), plain(row["high"]),
        )
        for row in _rows(data, "own_charges", "charges")
    )  # fmt: skip
    return ReportTable(
        "own_charges",
        "Charges of the fitted battery",
        "",
        ("mode", "quantity", "unit", "value", "from", "to"),
        rows,
        grouped=True,
    )


def _files(data: ReportData) -> ReportTable:
    rows = tuple(
        (
            str(row["name"]), int(row["rows"]), plain(row["charge_in_ah"]), plain(row["charge_out_ah"]),
            plain(row["initial_soc"]), "stated" if row["stated"] else "from the first voltage",
        )
        for row in _rows(data, "own_reading", "files")
    )  # fmt: skip
    header = ("file", "rows", "charge in / Ah", "charge out / Ah", "SOC at the start", "how")
    return ReportTable("files", "Files", "", header, rows)


def _segments(data: ReportData) -> ReportTable:
    names = _names(data)
    found = [
        (
            names[int(row["file"])], str(row["kind"]), plain(row["start_s"]), plain(row["length_s"]),
            plain(row["current_a"]), plain(row["charge_ah"]), 100.0 * float(row["soc"]), plain(row["end_v"]),
        )
        for row in _rows(data, "own_reading", "segments")
    ]  # fmt: skip
    more = f"The first {_MOST_SEGMENTS} of {len(found)}." if len(found) > _MOST_SEGMENTS else ""
    header = ("file", "kind", "from / s", "length / s", "current / A", "charge / Ah", "SOC / %", "end / V")
    return ReportTable("segments", "Segments", more, header, tuple(found[:_MOST_SEGMENTS]), grouped=True)


def _names(data: ReportData) -> list[str]:
    return [str(name) for name in data.table("own_reading", "files")["name"]]


def _milli(value: Any) -> float | None:
    number = plain(value)
    return 1e3 * number if isinstance(number, float) else None


def _rows(data: ReportData, source: str, name: str) -> Iterator[Mapping[str, Any]]:
    columns = data.table(source, name)
    for row in zip(*columns.values(), strict=True):
        yield dict(zip(columns, row, strict=True))
