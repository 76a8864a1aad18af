"""The search for the currents of a staged charge on the page: what was found, what it is held against, calibrations."""

from __future__ import annotations

import numpy as np

from pipeline.report.tables import Cell, ReportData, ReportTable, plain

LABELS = ()
_OF_A_SEARCH = (
    ("replicates", "replicates"),
    ("evaluations", "charges computed"),
    ("value_mean", "objective, mean"),
    ("excess_mean", "above the best, mean"),
    ("excess_worst", "above the best, worst"),
    ("hit_share", "share within 0.1 %"),
    ("time_mean_s", "time, mean / s"),
    ("rise_mean_k", "rise, mean / K"),
    ("early_excess_mean", "above the best, early"),
    ("early_time_mean_s", "time, early / s"),
    ("early_rise_mean_k", "rise, early / K"),
)
_READINGS = {"final": "at the end", "positive": "sum of the rises", "peak": "highest"}


def tables(data: ReportData) -> list[ReportTable]:
    """Return the tables of a search for stage currents; none where a run has none."""
    shown: list[ReportTable] = []
    if "staging" in data.inputs:
        shown += [table_3(data), cases(data), searches(data)]
    if "front" in data.inputs:
        shown += [calibrations(data), printed_rises(data)]
    return shown


def table_3(data: ReportData) -> ReportTable:
    """Return currents, time and rise for each pair of weights: the paper's Table 3, whose numbers are lost."""
    found, stages = data.table("staging", "cases"), data.table("staging", "currents")
    rows: list[tuple[Cell, ...]] = []
    for place, name in enumerate(found["case"].tolist()):
        if name != "printed" and found["weights"][place] is None:
            continue
        currents = stages["current_a"][stages["case"] == name]
        rows.append(
            (
                _words(found["weights"][place] or "weights_5_5"),
                _source(found["found_by"][place]),
                _READINGS.get(found["rise"][place] or ""),
                float(found["time_s"][place]),
                float(found["peak_k"][place]),
                float(found["final_k"][place]),
                *(round(float(current), 2) for current in currents),
            )
        )
    rows.sort(key=lambda row: str(row[0]))
    count = len(np.unique(stages["stage"]))
    header = ("weights", "found by", "rise that is weighed", "time / s", "highest rise / K", "rise at the end / K")
    return ReportTable(
        "table_3",
        "Currents, time and temperature rise by weights",
        "The paper's numbers are lost, but for its currents with 5:5. What the search found, and the best there is for "
        "each way to read the sum of the stages' temperature rises.",
        (*header, *(f"I{n} / A" for n in range(1, count + 1))),
        tuple(rows),
        paper="Table 3",
        grouped=True,
    )


def cases(data: ReportData) -> ReportTable:
    """Return what can be had with the printed currents' rise or time, and with one constant current."""
    numbers, found = data.numbers("staging"), data.table("staging", "cases")
    kept = {
        "same_peak": "best, same highest rise",
        "same_final": "best, same rise at the end",
        "same_positive": "best, same sum of the rises",
        "same_time_peak": "best, same time, least highest rise",
        "same_time_final": "best, same time, least rise at the end",
    }
    rows: list[tuple[Cell, ...]] = []
    for name, title in {"printed": "printed", **kept}.items():
        place = found["case"].tolist().index(name)
        rows.append((title, *(float(found[part][place]) for part in ("time_s", "peak_k", "final_k", "peak_v"))))
    for what, time in (
        ("time", "printed_time_s"),
        ("peak", "constant_same_peak_s"),
        ("final", "constant_same_final_s"),
    ):
        title = {"time": "time", "peak": "highest rise", "final": "rise at the end"}[what]
        current = numbers.get(f"constant_same_{what}_a")
        rises = {
            "time": (numbers.get("constant_same_time_peak_k"), numbers.get("constant_same_time_final_k")),
            "peak": (numbers.get("printed_peak_k"), None),
            "final": (None, numbers.get("printed_final_k")),
        }[what]
        if current is not None:
            rows.append((f"constant {current:.4g} A, same {title}", numbers.get(time), *rises, None))
    printed = float(found["time_s"][found["case"].tolist().index("printed")])
    rows = [(*row, None if row[1] is None else round(100.0 * (float(row[1]) / printed - 1.0), 6)) for row in rows]
    return ReportTable(
        "stage_cases",
        "Beside the printed currents",
        "Best: by the local solver from random starts.",
        (
            "charge",
            "time / s",
            "highest rise / K",
            "rise at the end / K",
            "highest voltage / V",
            "time against printed / %",
        ),
        tuple(rows),
    )


def searches(data: ReportData) -> ReportTable:
    """Return a row per search for stage currents."""
    found = data.numbers("staging")
    names = [name.removesuffix("_value_mean") for name in found if name.endswith("_value_mean")]
    rows = tuple((_words(name), *(found.get(f"{name}_{key}") for key, _ in _OF_A_SEARCH)) for name in names)
    return ReportTable(
        "stage_searches",
        "The searches for the stage currents",
        f"First weights; the best is the local solver's. Early: after {found['early_evaluations']:.0f} of "
        f"{found['evaluations']:.0f} charges.",
        ("search", *(title for _, title in _OF_A_SEARCH)),
        rows,
    )


def calibrations(data: ReportData) -> ReportTable:
    """Return how much faster the best currents are under each calibration."""
    names = ("calibration", "rise", "printed_s", "rise_k", "best_s", "saved_share", "agreeing_share")
    found = data.table("front", "calibrations")
    rows = tuple(
        (_words(str(row[0])), _READINGS[str(row[1])], *map(plain, row[2:]))
        for row in zip(*(found[name] for name in names), strict=True)
    )
    return ReportTable(
        "calibrations",
        "How much faster, under each calibration",
        "The rise named is kept to that of the printed currents.",
        (
            "calibration",
            "rise kept",
            "printed / s",
            "rise / K",
            "best / s",
            "time saved / 1",
            "starts that end there / 1",
        ),
        rows,
        grouped=True,
    )


def printed_rises(data: ReportData) -> ReportTable:
    """Return the printed currents' rise after each stage under each calibration."""
    found = data.table("front", "calibration_stages")
    names = [str(name) for name in dict.fromkeys(found["calibration"])]
    rows: list[tuple[Cell, ...]] = []
    for stage in np.unique(found["stage"]).tolist():
        own = found["stage"] == stage
        rises = (plain(found["printed_rise_k"][own & (found["calibration"] == name)][0]) for name in names)
        printed = plain(found["printed_a"][own][0]) if names else None
        rows.append((stage, printed, *rises))
    return ReportTable(
        "calibration_rises",
        "Temperature rise after each stage with the printed currents [K]",
        "The text describes 3.5 K after the third stage, 4 K at most, and a little less at the end.",
        ("stage", "printed / A", *(_words(name) for name in names)),
        tuple(rows),
    )


def _words(name: str) -> str:
    parts = name.split("_")
    if parts[0] == "weights" and len(parts) > 1:
        return ":".join(parts[1:])
    return name.replace("_", " ")


def _source(found_by: str) -> str:
    return found_by.replace("_", " ")
