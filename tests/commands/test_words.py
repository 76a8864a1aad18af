"""The words that explain and list: steps, modes, batteries, panels, schema, new."""

from __future__ import annotations

import argparse
import contextlib
import json
import math
import re
import shlex
from pathlib import Path

import pytest
from pvlib.pvsystem import retrieve_sam

import pipeline as cp
from pipeline.__main__ import main
from pipeline.cell.records import value_of
from pipeline.charge.waveforms import WAVEFORMS
from pipeline.commands import COMMANDS, OF_THE_REPOSITORY, listing, run, terminal
from pipeline.commands.listing import between
from pipeline.commands.new import write
from pipeline.commands.terminal import table_lines
from pipeline.config import inheritance
from pipeline.config.compose import options
from pipeline.config.sources import Source
from pipeline.errors import UserError
from pipeline.kernel import registry
from pipeline.kernel.places import SHIPPED


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


def _rows(told: str) -> list[list[str]]:
    """Return the cells of a table as it is piped: columns stand two spaces apart, or more."""
    return [re.split(r"\s{2,}", line.strip()) for line in told.splitlines()]


def test_panels_are_those_whose_numbers_lie_in_the_ranges(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["panels", "--power", "90..110", "--cells", "36", "--all"]) == 0
    head, *rows, count = _rows(capsys.readouterr().out)
    assert head == [
        *("name", "Pmp [W]", "Vmp [V]", "Imp [A]", "Voc [V]", "Isc [A]", "cells", "technology", "from"),
    ]  # fmt: skip
    found = {row[0] for row in rows}
    for pvlibs, own in (
        ("CECMod", ("V_mp_ref", "I_mp_ref", "N_s")),
        ("SandiaMod", ("Vmpo", "Impo", "Cells_in_Series")),
    ):
        modules = retrieve_sam(pvlibs)
        volt, ampere, cells = (modules.loc[name].astype(float) for name in own)
        power = volt * ampere
        theirs = set(modules.columns[(power >= 90.0) & (power <= 110.0) & (cells == 36)])
        assert theirs <= found
        found -= theirs
    assert not found
    assert count == [f"{len(rows)} panels"]
    assert [float(row[1]) for row in rows] == sorted(float(row[1]) for row in rows)


def test_panels_have_words_and_technologies_and_own_files_are_among_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["panels", "CS5P", "canadian", "--technology", "multi"]) == 0
    _, *rows, _ = _rows(capsys.readouterr().out)
    assert rows
    assert all("CS5P" in row[0] and row[7] == "Multi-c-Si" for row in rows)
    assert main(["panels", "kc65t", "--open-circuit", "21.7"]) == 0
    assert "kc65t " in capsys.readouterr().out
    assert main(["panels", "--power", "1e6.."]) == 0
    assert "no panel" in capsys.readouterr().out
    assert main(["panels", "kyocerra", "kc130"]) == 0
    assert "Kyocera_Solar_KC130GT" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "low", "high"),
    [("90..110", 90, 110), ("90..", 90, math.inf), ("..110", -math.inf, 110), ("36", 36, 36), ("-1.5..1e3", -1.5, 1e3)],
)
def test_a_range_is_read(words: str, low: float, high: float) -> None:
    assert between(words) == (low, high)


@pytest.mark.parametrize("words", ["", "..", "x", "1..2..3", "110..90", "nan", "90-110"])
def test_what_is_no_range_is_refused(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(argparse.ArgumentTypeError):
        between(words)
    with pytest.raises(SystemExit) as ended:
        main(["panels", f"--power={words}"])
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("error: ") == 1


@pytest.mark.parametrize("word", ["panels", "batteries"])
def test_an_override_is_no_word_of_a_name(word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([word, "battery.capacity_ah=7"]) == 2
    assert "override battery.capacity_ah=7: words of a name" in capsys.readouterr().err


def test_every_battery_is_listed_with_the_numbers_of_its_record(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["batteries"]) == 0
    head, *rows = _rows(capsys.readouterr().out)
    assert [row[0] for row in rows] == options("battery")
    for row in (row for row in rows if row[0] in ("lead_acid_12v18ah", "lead_acid_generic")):
        cells, one = dict(zip(head, row, strict=False)), cp.battery(row[0])
        assert one.title.startswith(cells["chemistry"])
        assert float(cells["capacity [Ah]"]) == pytest.approx(one.capacity_in_use_ah, rel=1e-3)
        assert int(cells["cells"]) == one.cells
        assert cells["usual [C-rate]"] == "{:g} to {:g}".format(*one.usual_c_rate)
        volts = one.cells_in_series * value_of(one.open_circuit_voltage_v, 0.5)
        assert float(cells["voltage [V]"]) == pytest.approx(volts, rel=1e-3)
    assert main(["batteries", "nothing like it"]) == 0


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the configuration of a project of one's own, before the shipped one."""
    conf = tmp_path / "conf"
    for group in ("battery", "panel"):
        (conf / group).mkdir(parents=True)
    monkeypatch.setattr(inheritance, "confs", lambda: (conf, SHIPPED / "conf"))
    return conf


@pytest.mark.parametrize("words", [[], ["mine"], ["lead_acid_12v7ah"], ["nothing", "like", "it"]])
@pytest.mark.parametrize("fault", ["capacity_ah: [", "defaults: [nicd_2s_600mah]\ncapacity_ahh: 3.0\n"])
def test_a_faulty_file_is_told_whatever_battery_is_looked_for(
    fault: str, words: list[str], own: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (own / "battery" / "mine.yaml").write_text(fault)
    assert main(["batteries", *words]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-1].startswith("mine: ")
    assert "conf/battery/mine.yaml" in lines[-1]
    assert any(line.startswith("lead_acid_12v7ah ") for line in lines) == (words in ([], ["lead_acid_12v7ah"]))
    assert any("no battery has all" in line for line in lines) == (words in (["mine"], ["nothing", "like", "it"]))


@pytest.mark.parametrize("words", [["mine"], ["kc65t"], ["nothing like it"]])
@pytest.mark.parametrize("fault", ["max_power_w: [", "defaults: [kc65t]\nmax_power_w: 65 W\n", "title: Mine\n"])
def test_a_faulty_file_is_told_whatever_panel_is_looked_for(
    fault: str, words: list[str], own: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (own / "panel" / "mine.yaml").write_text(fault)
    assert main(["panels", *words]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("mine: ") and "conf/panel/mine.yaml" in line for line in lines)
    assert any(line.startswith("kc65t ") for line in lines) == (words == ["kc65t"])


SHEET = """\
title: Mine
technology: multi_silicon
max_power_w: 66.0
max_power_voltage_v: 17.4
max_power_current_a: 3.79
open_circuit_voltage_v: 21.7
short_circuit_current_a: 3.99
"""


@pytest.mark.parametrize("sheet", ["defaults: [kc65t, _self_]\ntitle: Mine\nmax_power_w: 66.0\n", SHEET])
def test_a_panel_that_builds_on_another_or_leaves_numbers_out_is_listed(
    sheet: str, own: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (own / "panel" / "mine.yaml").write_text(sheet)
    assert main(["panels", "mine"]) == 0
    _, row, count = _rows(capsys.readouterr().out)
    assert row[:3] == ["mine", "66", "17.4"]
    assert row[6] == "36"
    assert count == ["1 panel"]


def test_a_battery_says_where_its_values_come_from_and_how_far_they_go() -> None:
    one = cp.battery("nmc_5ah")
    sources = {
        "battery.a": Source(kind="fitted", file="log.csv", valid={"soc": (0.2, 1.0), "c_rate": (0.1, 0.5)}),
        "battery.b": Source(kind="data_sheet", ref="sheet"),
        "battery.c": Source(kind="data_sheet", ref="sheet"),
    }
    row = listing._battery_row("nmc_5ah", one, sources)
    assert row[-2:] == ("2 data sheet, 1 fitted", "SOC 0.2 to 1, 0.1C to 0.5C (log.csv)")


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_a_table_fits_the_terminal_and_cuts_no_name(width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = [("name", "power [W]", "words", "more"), ("a" * 30, "90.07", "some words that fold", "b" * 40)]
    piped = list(table_lines(rows))
    assert piped[1].split() == ["a" * 30, "90.07", "some", "words", "that", "fold", "b" * 40]
    monkeypatch.setattr(terminal, "is_watched", lambda: True)
    monkeypatch.setenv("COLUMNS", str(width))
    shown = [re.sub(r"\x1b\[[0-9;]*m", "", line) for line in table_lines(rows)]
    table = [line for line in shown if not line.startswith("a wider terminal")]
    assert max(map(len, table)) <= width
    assert any("a" * 30 in line and "90.07" in line for line in table)
    assert len(table) < len(shown) or any("b" * 10 in line for line in table)


@pytest.mark.parametrize(
    ("typed", "taken"),
    [
        ([], []),
        (["battery=a"], ["battery=a"]),
        (["--cfg"], ["--cfg=job"]),
        (["--cfg", "hydra"], ["--cfg", "hydra"]),
        (["--cfg", "battery=a"], ["--cfg=job", "battery=a"]),
    ],
)
def test_a_cfg_without_its_word_is_that_of_the_job_and_no_words_are_the_default_study(
    typed: list[str], taken: list[str]
) -> None:
    assert run._with_kind(typed) == taken


def test_every_example_of_the_help_is_a_plan() -> None:
    for words in run.EXAMPLES:
        given = shlex.split(words)
        plan = run.planned([word for word in given if word != "-m"], "-m" in given)
        assert plan["runs"]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ("compare-mode --battery x", "compare-mode: no word of python -m pipeline; best matches are: compare-modes,"),
        ("reprot", "reprot: no word of python -m pipeline; best matches are: report,"),
        ("-c 2 reprot", "reprot: no word of python -m pipeline; best matches are: report,"),
        ("Batteries lead", "Batteries: no word of python -m pipeline; best matches are: batteries"),
        ("run licenses", "licenses: no word of python -m pipeline; best matches are: licences"),
        ("solar_reflex", "solar_reflex: no word of python -m pipeline; best matches are: study=solar_reflex"),
        ("charges", "charges: no word of python -m pipeline; best matches are: -t charges,"),
        ("-c 2 report solar_reflex", "report: stands before all else: python -m pipeline report ..."),
        ("seed=1 --coers=4", "option --coers=4: unknown; see python -m pipeline --help; best matches are: --cores,"),
        ("-z", "option -z: unknown; see python -m pipeline --help"),
        ("qqqqq", "override qqqqq: not understood; allowed is key=value or group=option"),
    ],
)
def test_a_mistyped_word_is_told_with_the_nearest(words: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words.split()) == 2
    found = capsys.readouterr().err
    assert found.startswith(f"error: {told}")
    assert found.count("\n") == 1


@pytest.fixture
def installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The installed command was typed."""
    monkeypatch.setattr("sys.argv", ["/usr/bin/charge-pipeline"])


@pytest.mark.parametrize("word", COMMANDS)
def test_help_names_the_command_that_was_typed(word: str, installed: None, capsys: pytest.CaptureFixture[str]) -> None:
    with contextlib.suppress(SystemExit):
        main([word, "--help"])
    told = " ".join(" ".join(capsys.readouterr()).split())
    assert "charge-pipeline" in told
    assert "python -m pipeline" not in told
    assert ("own repository" in told) == (word in ("run", *OF_THE_REPOSITORY))


def test_so_do_messages_from_rooms_that_know_no_commands(installed: None, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["panel.name=Canadian_Solar", "--cfg"]) == 2
    told = capsys.readouterr().err
    assert "more: charge-pipeline panels canadian solar" in told
    assert "python -m pipeline" not in told


@pytest.mark.parametrize(
    ("text", "missing"), [(None, "no such file is here"), ("# Mine\n", "it has no lines <!-- studies: begin -->")]
)
def test_a_readme_without_room_for_the_studies_is_told_what_readme_does(
    text: str | None, missing: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    if text is not None:
        Path("README.md").write_text(text)
    assert main(["readme"]) == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert told.startswith(f"error: README.md: {missing}")
    assert told.endswith("readme writes what the studies found into the README of the project's own repository")
