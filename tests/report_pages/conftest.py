"""A run that never was: two modes in two comparisons, one of which did not get to its mark."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline import schemas, tables
from pipeline.report.data import ModeLabel, ReportData
from pipeline.report.pages import PageContent, PageFigure, Paper
from pipeline.report.tables import Parameter, ReportTable

SVG = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 4"><title>a &amp; b</title></svg>'


def write_charge(folder: Path, time_s: float | None) -> None:
    folder.mkdir(parents=True)
    summary = {
        "quantity": ["time_to_soc_0.95_s", "end_reason"],
        "value": [time_s, None],
        "text": [None, "stop: elapsed 43200 s"],
        "unit": ["s", ""],
        "description": ["", ""],
    }
    tables.write(schemas.CHARGE_SUMMARY, summary, folder / "summary.parquet")
    energy = {
        "path": ["electrical input", "series resistance"],
        "role": ["input", "loss"],
        "energy_j": [36000.0, 1800.0],
        "description": ["", ""],
    }
    tables.write(schemas.CHARGE_ENERGY, energy, folder / "energy.parquet")


@pytest.fixture
def data(tmp_path: Path) -> ReportData:
    (tmp_path / "panel").mkdir()
    values = {
        "irradiance_w_m2": [200.0, 1000.0],
        "cell_temperature_c": [25.0, 25.0],
        "short_circuit_current_a": [0.8, 3.99],
        "open_circuit_voltage_v": [20.0, 21.7],
        "max_power_current_a": [0.75, 3.75],
        "max_power_voltage_v": [17.0, 17.4],
        "max_power_w": [12.75, 65.25],
    }
    tables.write(schemas.PANEL_POINTS, values, tmp_path / "panel" / "points.parquet")
    inputs = {"panel": tmp_path / "panel"}
    for name, time_s in {"peak/cc": 9000.0, "peak/reflex": None, "mean/cc": 9000.0}.items():
        inputs[f"charge/{name}"] = tmp_path / name
        write_charge(tmp_path / name, time_s)
    labels = {"cc": ModeLabel("CC-CV"), "reflex": ModeLabel("CV-Reflex")}
    return ReportData(inputs, labels, {"peak": "Same peak current", "mean": "Same mean current"})


def verdict_columns(*verdicts: str) -> dict[str, list]:
    count = len(verdicts)
    return {
        "statement": [f"claim_{number}" for number in range(count)],
        "where": ["Table 1"] * count,
        "says": [f"claim <{number}> & more" for number in range(count)],
        "reading": ["at 25 degC"] * count,
        "basis": ["model"] * count,
        "verdict": list(verdicts),
        "published_value": [65.0] + [None] * (count - 1),
        "computed_value": [65.25] * count,
        "unit": ["W"] * count,
        "tolerance": [0.5] * count,
        "margin": [-0.25] * count,
        "robust_share": [0.625] + [None] * (count - 1),
        "explanation": ["The numbers."] * count,
    }


@pytest.fixture
def content() -> PageContent:
    return PageContent(
        title="A study <of> charging",
        subtitle="A question?",
        paper=Paper("Author (2015). Title.", "10.1000/example"),
        verdicts=verdict_columns("holds", "contradicted", "contradicted", "not checkable", "calibrated", "fails"),
        figures=[PageFigure("figure_11", "Figure 11", "Battery current", 'Current "in" A', SVG, b"\x89PNG")],
        tables=[
            ReportTable(
                "charges", "Charges", "", ("comparison", "quantity", "CC-CV"), (("Peak", "rise", 1.5),), grouped=True
            ),
            ReportTable("table_1", "Panel", "Fitted.", ("quantity", "printed"), (("power", 65.0),), paper="Table 1"),
        ],
        parameters=[
            Parameter("panel.max_power_w", 65.0, "W", "published", "Table 1", calibrated_to="table_1"),
            Parameter("battery.heat_capacity_j_per_k", 2100.0, "J/K", "estimate", "by weight", 1800.0, 2600.0),
        ],
        command="snakemake solar_reflex",
        keys={"panel": "0123456789abcdef"},
    )
