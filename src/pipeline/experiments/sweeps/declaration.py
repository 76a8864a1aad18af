"""What the runs of a sweep are told in: one table and one page for all of them.

Their nodes are no part of a run's own; whoever plans a sweep asks for them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.experiments.sweeps.reading import CSV, TABLE
from pipeline.kernel.draft import plain
from pipeline.kernel.experiment import Draft, Effort, Experiment, Step, Swept
from pipeline.published.records import read_tables, read_values

SWEEP = Step(
    "sweep",
    rule="gather_sweep",
    message="Sweep: a table of all runs: {chunk}",
    takes=("charge",),
    shown=False,
)
PAGE = Step(
    "sweep_page",
    rule="write_sweep_page",
    message="Sweep: the page: {chunk}",
    takes=("sweep",),
    files=("src/pipeline/experiments/sweeps/*.j2", "src/pipeline/report/templates/*", "src/pipeline/report/*.mplstyle"),
    shown=False,
)
_ROW_B, _ROW_S = 4e4, 4e-3


def gathers(sweep: Swept) -> Iterator[Draft]:
    """Yield the table of a sweep's runs, and its page."""
    study = sweep.study.study
    label = f"{study.name}.{sweep.name}"
    told = {"study": study.name, "sweep": sweep.name, "title": study.title, "keys": list(sweep.keys)}
    settings = told | {"runs": list(sweep.runs), "statements": list(_statements(sweep))}
    inputs = {node: node for run in sweep.runs for node in run["nodes"].values()}
    files = {file: file for file in (TABLE, CSV)}
    # Each row is read from an artefact of its own.
    rows = Effort(_ROW_B * len(inputs), _ROW_S * len(inputs), ())
    yield Draft(SWEEP.name, SWEEP.name, label, settings, inputs, (), files, "results", (), rows)
    listed = [f"{sweep.folder}/{file}" for file in files]
    of_page = told | {"names": _names(sweep.study), "command": sweep.command, "files": listed}
    yield Draft(PAGE.name, PAGE.name, label, of_page, {SWEEP.name: SWEEP.name}, (), {"*": ""}, "reports", (), rows)


def _names(study: Any) -> dict[str, str]:
    """Return what modes and comparisons are called, those of the second battery too."""
    titled = {**study.modes, **study.comparisons}
    return {name: one.title for name, one in titled.items()} | {"second": "second battery"}


def _statements(sweep: Swept) -> Iterator[dict[str, Any]]:
    """Yield the published statements that the summaries of a run's charges answer."""
    nodes = {node for run in sweep.runs for node in run["nodes"]}
    for name, stated in sweep.study.published.items():
        read = read_values(stated)
        of_charges = read and all(value.table == "summary" and value.artefact in nodes for value in read)
        if of_charges and stated.basis == "model" and stated.check is not None and not read_tables(stated):
            yield {"name": name, "statement": plain(stated)}


EXPERIMENT = Experiment(
    title="sweeps: the outcomes of many runs",
    steps=(SWEEP, PAGE),
    gathers=gathers,
    tells="telling",
)
