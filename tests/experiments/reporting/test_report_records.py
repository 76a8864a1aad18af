from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from pydantic import ValidationError

from pipeline.kernel import registry, tables
from pipeline.report.records import FigureCard
from pipeline.report.tables import ReportData
from tests import making
from tests.experiments.charges.artefacts import build

CARD = {"draw": "over_time", "title": "t", "caption": "c", "options": {"quantity": "soc"}}


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> ReportData:
    return build(tmp_path_factory.mktemp("whole"))


def test_every_drawing_reads_what_an_experiment_makes_or_declares():
    known = {*registry.steps(), *registry.labels(), "second_charge"}
    for name in registry.figures():
        assert set(FigureCard.model_construct(draw=name, module=registry.figures()[name]).reads()) <= known, name


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"draw": "overtime"}, "draw is 'overtime', which draws nothing; best matches are: over_time"),
        ({"options": {"quantity": "colour"}}, "'current', 'voltage', 'soc' or 'temperature'"),
        ({"options": {"quantity": "soc", "size": 3}}, "Extra inputs are not permitted"),
        ({"options": {}}, "quantity\n  Field required"),
    ],
)
def test_a_card_that_cannot_be_drawn_is_refused(change, message):
    with pytest.raises(ValidationError, match=message):
        FigureCard(**(CARD | change))


def test_artefacts_are_read_once_and_only_when_asked_for(whole, monkeypatch):
    asked = []
    read = tables.read
    monkeypatch.setattr(tables, "read", lambda table, path: asked.append(path.name) or read(table, path))
    fresh = type(whole)(making.inputs(dict(whole.inputs)), whole.modes, whole.comparisons)
    assert asked == []
    fresh.charge("same_peak", "cc_cv", "trace")
    fresh.charge("same_peak", "cc_cv", "trace")
    assert asked == ["trace.bdf.parquet"]


def test_quantities_leave_out_what_the_charge_did_not_reach(whole):
    found = whole.quantities("same_peak", "cc_cv")
    assert set(found) == {"time_to_soc_0.5_s", "time_to_soc_0.8_s", "time_to_soc_0.95_s"}
    assert list(found.values()) == sorted(found.values())


def test_a_table_of_another_kind_is_refused(whole, tmp_path):
    for name in ("panel", "supply"):
        (tmp_path / name).mkdir()
    source = whole.inputs["supply"] / "supply.parquet"
    (tmp_path / "panel" / "curves.parquet").write_bytes(source.read_bytes())
    wrong = type(whole)(making.inputs({"panel": tmp_path / "panel"}), {}, {})
    with pytest.raises(tables.TableError, match="not a panel_curves table"):
        wrong.table("panel", "curves")


def test_records_import_no_matplotlib():
    code = "import sys, pipeline.report.records\nprint([m for m in ('matplotlib', 'pandas') if m in sys.modules])"
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2] / "src")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_pyplot_is_never_imported():
    names = ["pipeline.experiments.reporting.figures", *registry.figures().values()]
    code = (
        "import sys, importlib\n"
        f"for name in {names}:\n"
        "    importlib.import_module(name)\n"
        "print([m for m in ('matplotlib.pyplot', 'pipeline.panel', 'pipeline.charge', 'pandas') if m in sys.modules])"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2] / "src")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
