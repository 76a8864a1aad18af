"""A folder of reports as publishing leaves it, of a study that never was: two pages, figures, traces, front page."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from pipeline.experiments.reporting import announce
from pipeline.published.words import WORDS
from pipeline.report import pages, traces
from pipeline.report.claims import Rests
from pipeline.report.pages import PageContent, PageFigure, PageSection, Paper
from pipeline.report.tables import Parameter, ReportTable
from tests.report_pages.conftest import verdict_columns

MANIFEST = {"command": "snakemake", "commit": "abc", "digest": "def", "seed": 1, "versions": {"python": "3.11"}}
PLACES = ("study/default", "study/seed=2")


def build(root: Path) -> Path:
    """Write the reports below a folder; return where they are."""
    for place in PLACES:
        folder = root / "reports" / place
        (folder / "figures").mkdir(parents=True)
        shown = replace(content(), place=place)
        (folder / "index.html").write_text(pages.render(shown), encoding="utf-8")
        departs = [] if place.endswith("default") else ["seed=2"]
        (folder / "card.json").write_text(json.dumps(pages.card(shown, departs)), encoding="utf-8")
        (folder / pages.TRACES).write_text(traces.script(charges()), encoding="utf-8")
        for figure in shown.every_figure():
            (folder / "figures" / f"{figure.name}.svg").write_text(drawing(figure.title), encoding="utf-8")
    for place in PLACES:
        study, _, name = place.partition("/")
        announce.published({"study": study, "name": name}, MANIFEST, root / "results")
    return root / "reports"


def charges() -> list[traces.Trace]:
    """Return two charges at one current and one at another, each a straight line and a bend."""
    time = np.linspace(0.0, 3600.0, 1801)
    found = []
    for mark, (name, slope, group) in enumerate(
        (("cc", 1.0, "peak"), ("pulse", 0.5, "peak"), ("reflex", 0.25, "mean"))
    ):
        quantities = {"Voltage [V]": 12.0 + slope * time / 3600.0, "Current [A]": np.where(time < 1800.0, slope, 0.0)}
        quantities["Share + rest [%]"] = 100.0 * time / 3600.0
        found.append(traces.Trace(f"{group}/{name}", name, group, mark, time, quantities))
    return found


def drawing(title: str) -> str:
    """Return a figure of the usual size."""
    return (
        '<svg xmlns="http://www.w3.org/2000/svg" width="648pt" height="288pt" viewBox="0 0 648 288">'
        f'<rect width="648" height="288" fill="#fff"/><text x="20" y="40">{title}</text></svg>'
    )


def content() -> PageContent:
    """Return a page with something of everything: every word, readings, close calls, long and wide tables."""
    words = [*WORDS, "holds", "undecided"]
    count = len(words)
    columns = verdict_columns(*words) | {
        "statement": [*(f"claim_{number}" for number in range(count - 2)), "fast_same_peak", "fast_same_mean"],
        "says": [*(f"claim {number} of the paper" for number in range(count - 2)), "“it is fast”", "“it is fast”"],
        "where": [f"section 4, Figure {11 + number % 3}" for number in range(count)],
        "robust_low": [0.7, *[None] * (count - 1)],
        "robust_high": [0.9, *[None] * (count - 1)],
    }
    figures = [
        PageFigure(f"figure_{number}", f"Figure {number}", f"Curve {number}", "What to see.") for number in (11, 12, 13)
    ]
    long = tuple((f"a_rather_long_name_of_a_quantity_{row}_s", 10.0**-row, row, "text " * 8) for row in range(30))
    wide = (("row", *(float(cell) / 7.0 for cell in range(24))),)
    rests = Rests(
        ("panel", "charge/a"), ("figure_11",), ("charges",), ("battery",), ("battery.r_ohm",),
        "conf/published/study.yaml", "claim_0", "snakemake --cores 2 results/study/default/charge/a.summary.parquet",
    )  # fmt: skip
    return PageContent(
        title="A study that never was",
        subtitle="Which of them is faster?",
        paper=Paper("Author (2015). Title.", "10.1000/example", {"Figure 11": "Comparison diagram."}),
        verdicts=columns,
        figures=figures,
        tables=[
            ReportTable("long", "Long", "A caption.", ("quantity", "value", "count", "note"), long),
            ReportTable("wide", "Wide", "", ("name", *(f"column {cell}" for cell in range(24))), wide, paper="Table 1"),
        ],
        parameters=[
            Parameter(f"battery.value_{number}_v", 1.5 * number, "V", "estimate", "a reference " * 6, 1.0, 2.0)
            for number in range(20)
        ]
        + [Parameter("battery.r_ohm", 0.02, "ohm", "calibrated", "to it", calibrated_to="claim_0")],
        command="snakemake --cores 2 study",
        keys={"panel": "0" * 64, "charge/a": "1" * 64},
        sections=[PageSection("apart", "A section", "Text.", [], [PageFigure("rise", "", "Rise", "A rise.")])],
        answer=["Best: cc, by 450 s in charging time.", "Time: cc 100 s, pulse 550 s."],
        hero="rise",
        rests={"claim_0": rests, "fast_same_peak": rests},
        owners={"long": "charges"},
        traces=3,
        seed=1,
        notes=["Battery: one."],
    )
