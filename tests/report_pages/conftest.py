"""The content of a page that no experiment made."""

from __future__ import annotations

import pytest

from pipeline.report.pages import PageContent, PageFigure, Paper
from pipeline.report.tables import Parameter, ReportTable

SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="648pt" height="288pt" viewBox="0 0 648 288"></svg>'


def verdict_columns(*verdicts: str) -> dict[str, list]:
    count = len(verdicts)
    return {
        "statement": [f"claim_{number}" for number in range(count)],
        "where": ["Table 1"] * count,
        "says": [f"claim <{number}> & more" for number in range(count)],
        "reading": ["at 25 degC"] * count,
        "conditions": ["another <cell>", *[""] * (count - 1)],
        "basis": ["model"] * count,
        "verdict": list(verdicts),
        "met": [
            "yes" if word in ("holds", "calibrated") else "" if word == "not checkable" else "no" for word in verdicts
        ],
        "published_value": [65.0] + [None] * (count - 1),
        "computed_value": [65.25] * count,
        "unit": ["W"] * count,
        "tolerance": [0.5] * count,
        "margin": [-0.25] * count,
        **{
            name: [value] + [None] * (count - 1)
            for name, value in {
                "robust_share": 0.625,
                "robust_low": 0.53,
                "robust_high": 0.71,
                "robust_points": 128.0,
                "robust_left_out": 0.0,
            }.items()
        },
        "explanation": ["The numbers."] * count,
    }


@pytest.fixture
def content() -> PageContent:
    return PageContent(
        title="A study <of> charging",
        subtitle="A question?",
        paper=Paper("Author (2015). Title.", "10.1000/example"),
        verdicts=verdict_columns("holds", "contradicted", "contradicted", "not checkable", "calibrated", "undecided"),
        figures=[PageFigure("figure_11", "Figure 11", "Battery current", 'Current "in" A', (864, 384))],
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
        place="a_study/default",
    )
