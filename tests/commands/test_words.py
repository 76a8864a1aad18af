"""The words that explain: steps, modes, schema, new."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pipeline.__main__ import main
from pipeline.charge.waveforms import WAVEFORMS
from pipeline.commands.new import write
from pipeline.errors import UserError
from pipeline.kernel import registry


def test_every_step_is_told_with_what_it_reads_and_makes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["steps"]) == 0
    told = capsys.readouterr().out
    for name, step in registry.steps().items():
        part = told.split(f"\n{name}  (" if not told.startswith(f"{name}  (") else f"{name}  (", 1)[1].split("\n\n")[0]
        assert all(read in part for read in step.reads)
        assert all(table in part for table in step.tables)
        assert step.rule in part


def test_one_step_is_told_alone(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["steps", "supply"]) == 0
    assert "  reads  panel, weather, converter, load\n  takes  panel\n" in capsys.readouterr().out


def test_the_vocabulary_of_modes_is_whole(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["modes"]) == 0
    told = capsys.readouterr().out
    for name, record in WAVEFORMS.items():
        part = told.split(f"\n  {name}: ")[1]
        for key, field in record.model_fields.items():
            assert f"\n    {key}" in part
            assert (field.description or "") in part


def test_the_schema_is_written(tmp_path: Path) -> None:
    file = tmp_path / "schema.json"
    assert main(["schema", "--output", str(file)]) == 0
    assert "group:battery" in json.loads(file.read_text())["$defs"]


@pytest.mark.parametrize("name", ["charges", "supply", "search", "Upper", "two words", "1st"])
def test_a_name_that_is_taken_or_none_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="new experiment"):
        list(write(name, tmp_path))
    assert not list(tmp_path.iterdir())
