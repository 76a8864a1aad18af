"""A new table, figure, quantity or step changes the keys of what uses it, and of nothing else."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from pipeline.kernel.places import PROJECT

# Each edit plans three studies anew, by a process of its own.
pytestmark = pytest.mark.slow
EXPERIMENT = "src/pipeline/experiments/trade_off"
KEYS = """
import json
from pipeline.config.planning import run_of
found = {}
for study in ("solar_reflex", "nicd_grnn", "lfp_cuckoo"):
    run = run_of([f"study={study}"])
    found |= {f"{study}/{name}": key for name, key in run.keys.items()}
print(json.dumps(found))
"""


def _keys(project: Path) -> dict[str, str]:
    """Return the key of every node of the three studies, planned from the sources of a copy."""
    done = subprocess.run(
        [sys.executable, "-c", KEYS],
        cwd=project,
        env={"PYTHONPATH": str(project / "src"), "PATH": "/usr/bin:/bin", "HOME": str(project)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("project")
    for name in ("src", "conf"):
        shutil.copytree(PROJECT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("requirements.lock", "pyproject.toml"):
        shutil.copy(PROJECT / name, folder / name)
    return folder


@pytest.fixture(scope="module")
def before(project: Path) -> dict[str, str]:
    return _keys(project)


def _changed(project: Path, before: dict[str, str], edits: dict[str, tuple[str, str]]) -> set[str]:
    """Return the nodes whose keys change with some edits: file -> (text, what stands in its place)."""
    originals = {file: (project / file).read_text() if (project / file).is_file() else None for file in edits}
    try:
        for file, (old, new) in edits.items():
            text = originals[file] or ""
            assert old in text, f"{file} has no {old!r}"
            (project / file).write_text(text.replace(old, new, 1) if old else text + new)
        after = _keys(project)
    finally:
        for file, text in originals.items():
            if text is None:
                (project / file).unlink()
            else:
                (project / file).write_text(text)
    return {name for name in before.keys() | after.keys() if before.get(name) != after.get(name)}


TABLE = """

ANOTHER_TABLE = Table("another", "A table that nobody writes yet", (Column("one", "1", "a number"),))
"""
FIGURE = '''"""A figure."""

from __future__ import annotations

from typing import Any

from pipeline.report import style
from pipeline.report.records import NoOptions

READS = ("trade_off",)
Options = NoOptions


def draw(figure: Any, data: Any) -> Any:
    """Draw nothing."""
    return style.figure(1.0)
'''
CARD = """
another_figure:
  draw: another
  title: another
  caption: another
"""
SHOWN = {"nicd_grnn/page"}


def test_a_line_in_a_module_of_tables_changes_nothing(project: Path, before: dict[str, str]) -> None:
    assert _changed(project, before, {f"{EXPERIMENT}/declaration.py": ("", TABLE)}) == set()
    other = "src/pipeline/experiments/frequency/tables.py"
    assert _changed(project, before, {other: ("", TABLE)}) == set()


def test_what_is_chaotic_elsewhere_changes_nothing(project: Path, before: dict[str, str]) -> None:
    edit = ('elsewhere={"value": CHAOTIC}', 'elsewhere={"step": 0.5}')
    assert _changed(project, before, {"src/pipeline/experiments/frequency/tables.py": edit}) == set()


def test_a_figure_changes_the_page_that_shows_it(project: Path, before: dict[str, str]) -> None:
    edits = {f"{EXPERIMENT}/figures/another.py": ("", FIGURE), "conf/report/nicd_grnn.yaml": ("", CARD)}
    assert _changed(project, before, edits) == {"nicd_grnn/figure/another_figure", *SHOWN}


NUMBER = """    quantity = TRADE_OFF_NUMBERS.quantity
    return [*found, quantity("rows", len(rows))]
"""


def test_a_quantity_changes_the_step_that_makes_it_and_what_shows_it(project: Path, before: dict[str, str]) -> None:
    edits = {
        f"{EXPERIMENT}/records.py": (
            "TRADE_OFF_NUMBERS = Vocabulary(\n    {\n",
            'TRADE_OFF_NUMBERS = Vocabulary(\n    {\n        "rows": ("1", "charges in all"),\n',
        ),
        f"{EXPERIMENT}/summary.py": ("    return found\n\n\ndef _", f"{NUMBER}\n\ndef _"),
    }
    changed = _changed(project, before, edits)
    assert "nicd_grnn/trade_off" in changed
    # Beside the step: the verdicts on statements that read it, its figures, the page.
    assert _outside(changed - {"nicd_grnn/verdicts", *SHOWN}) == set()


STEP = '''"""Another step."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.kernel.artefacts import Inputs, Output


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Write a number."""
    output.write("one", {"one": [1.0]})
'''
DECLARED = """
ANOTHER = Step(
    "another",
    rule="make_another",
    message="Another: {chunk}",
    tables={"one": TableFile("one.parquet", Table("one", "a number", (Column("one", "1", "a number"),)))},
)


def _more(study: Any) -> Iterator[Node]:
    yield from nodes(study)
    if study.trade_off is not None:
        yield Node(ANOTHER, "another", "another", shown=ANOTHER.places("another"))


EXPERIMENT = Experiment("""
IMPORTS = "from pipeline.kernel.tables import Column, Table, TableFile\n"


def test_a_step_changes_the_page_that_shows_it(project: Path, before: dict[str, str]) -> None:
    declaration = f"{EXPERIMENT}/declaration.py"
    text = (project / declaration).read_text()
    with_step = text.replace("\nEXPERIMENT = Experiment(", DECLARED, 1).replace(
        "    nodes=nodes,", "    nodes=_more,", 1
    )
    with_step = with_step.replace("steps=(WEIGH, ", "steps=(WEIGH, ANOTHER, ", 1)
    first = next(line for line in text.splitlines(keepends=True) if line.startswith("from pipeline.kernel.experiment"))
    with_step = with_step.replace(first, first + IMPORTS, 1)
    edits = {declaration: (text, with_step), f"{EXPERIMENT}/another.py": ("", STEP)}
    assert _changed(project, before, edits) == {"nicd_grnn/another", *SHOWN}


def _outside(names: set[str]) -> set[str]:
    """Return those of some nodes that are neither the trade-off's steps nor figures that read it."""
    cards = ("trade_off", "sensors", "figure_1_typical_charge", "figure_7_4c", "figure_8_8c", "figure_9_network_charge")
    own = {"nicd_grnn/trade_off", "nicd_grnn/ensemble/trade_off", *(f"nicd_grnn/figure/{card}" for card in cards)}
    return names - own
