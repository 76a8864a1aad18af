"""What the runs of a sweep are told in: one table and one page for all of them.

Their nodes are no part of a run's own; whoever plans a sweep asks for them.
"""

from __future__ import annotations

from pipeline.kernel.experiment import Experiment, Step

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
EXPERIMENT = Experiment(
    title="sweeps: the outcomes of many runs",
    steps=(SWEEP, PAGE),
    tells="telling",
)
