"""A sweep's table holds what the charges' summaries say, typed and with units; its page and the terminal show it."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest
from matplotlib.text import Text

from pipeline.experiments.charges.tables import CHARGE
from pipeline.experiments.sweeps import reading, sweep, sweep_page, telling
from pipeline.kernel import store, tables
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.report import style

README = Path(__file__).parents[3] / "README.md"
NODE = "charge/same_peak/{mode}"
FREQUENCIES = [10, 50.5, 90]


def _summary(folder: Path, time_s: float | None, peak_c: float, missed: str) -> Path:
    rows = [
        ("time_to_soc_0.95_s", time_s, None, "s", "time at which SOC 0.95 was first reached"),
        ("end_time_s", 9000.0, None, "s", "time at which the charge ended"),
        ("end_reason", None, "soc", "", "what ended the charge"),
        ("missed", None, missed, "", "what was not reached"),
        ("energy_efficiency", 0.9, None, "1", "efficiency"),
        ("peak_temperature_c", peak_c, None, "degC", "highest battery temperature"),
    ]
    names = ("quantity", "value", "text", "unit", "description")
    folder.mkdir(parents=True)
    columns = {name: [row[place] for row in rows] for place, name in enumerate(names)}
    tables.write(CHARGE["summary"].table, columns, folder / "summary.parquet")
    return folder


def _runs(folder: Path) -> tuple[list[dict[str, Any]], Inputs]:
    """Return three runs: the second one misses its goal in one mode, the last one has no second mode."""
    folders, runs = {}, []
    for place, frequency in enumerate(FREQUENCIES):
        modes = ("cc_cv", "cv_reflex") if place < 2 else ("cc_cv",)
        for mode in modes:
            late = place == 1 and mode == "cv_reflex"
            own = _summary(folder / f"{place}{mode}", None if late else 3600.0 + place, 30.0 + place, "far" * late)
            folders[f"{place}/{NODE.format(mode=mode)}"] = own
        nodes = {NODE.format(mode=mode): f"{place}/{NODE.format(mode=mode)}" for mode in modes}
        runs.append({"name": f"run{place}", "values": ["lead", frequency, place == 0], "nodes": nodes})
    return runs, Inputs(folders, dict.fromkeys(folders, CHARGE))


KEYS = [
    {
        "key": "battery",
        "unit": "",
        "description": "swept: battery",
        "short": "battery",
        "titles": {"lead": "Lead-acid"},
    },
    {
        **{"key": "modes.cv_reflex.frequency_hz", "unit": "Hz", "description": "swept"},
        **{"short": "cv_reflex.frequency_hz", "titles": {}},
    },
    {"key": "flag", "unit": "", "description": "swept: flag", "short": "flag", "titles": {}},
]
NAMES = {"cc_cv": "CC-CV", "cv_reflex": "CV-Reflex", "same_peak": "Same peak current"}


STATED = {
    "where": "page 1",
    "says": "constant current is the fastest",
    "reading": "",
    "basis": "model",
    "unit": "s",
    "check": {
        "smallest": {
            "value": "time_to_soc_0.95_s of charge/same_peak/cc_cv",
            "among": ["time_to_soc_0.95_s of charge/same_peak/cv_reflex"],
            "by": 60,
        }
    },
}


@pytest.fixture
def table(tmp_path: Path) -> Path:
    runs, inputs = _runs(tmp_path / "charges")
    made = tmp_path / "sweep"
    made.mkdir()
    sweep.run(
        {"keys": KEYS, "runs": runs, "statements": [{"name": "fastest", "statement": STATED}]}, inputs, Output(made, {})
    )
    return made


def test_the_table_is_typed_and_has_units(table: Path) -> None:
    found = pq.read_table(table / "runs.parquet")
    types = {field.name: (str(field.type), field.metadata[b"unit"].decode()) for field in found.schema}
    assert types["battery"] == ("string", "")
    assert types["modes.cv_reflex.frequency_hz"] == ("double", "Hz")
    assert types["flag"] == ("bool", "")
    assert types["cc_cv.time_to_soc_0.95_s"] == ("double", "s")
    assert types["cv_reflex.missed"] == ("string", "")
    rows = found.to_pydict()
    assert rows["run"] == ["run0", "run1", "run2"]
    assert rows["modes.cv_reflex.frequency_hz"] == FREQUENCIES
    assert rows["cc_cv.time_to_soc_0.95_s"] == [3600.0, 3601.0, 3602.0]
    assert rows["cv_reflex.time_to_soc_0.95_s"] == [3600.0, None, None]
    assert rows["cv_reflex.missed"] == ["", "far", None]


def test_a_statement_is_met_missed_or_not_answered_by_each_run(table: Path) -> None:
    found = pq.read_table(table / "runs.parquet")
    # As fast; the other one does not get there; there is no other one.
    assert found.column("met.fastest").to_pylist() == [False, True, None]
    assert b"constant current is the fastest" in found.schema.field("met.fastest").metadata[b"description"]


def test_the_same_stands_in_csv(table: Path) -> None:
    found = pq.read_table(table / "runs.parquet").to_pydict()
    with (table / "runs.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == list(found)
    for name in ("cc_cv.peak_temperature_c", "modes.cv_reflex.frequency_hz", "cv_reflex.time_to_soc_0.95_s"):
        assert [float(row[name]) if row[name] else None for row in rows] == found[name]


def test_a_summary_of_another_form_is_refused(tmp_path: Path) -> None:
    runs, inputs = _runs(tmp_path / "charges")
    (tmp_path / "sweep").mkdir()
    phases = CHARGE["phases"].table
    file = tmp_path / "charges" / "0cc_cv" / "summary.parquet"
    tables.write(phases, {column.name: [] for column in phases.columns}, file)
    with pytest.raises(tables.TableError, match="not a charge_summary table"):
        sweep.run({"keys": KEYS, "runs": runs, "statements": []}, inputs, Output(tmp_path / "sweep", {}))


def test_the_line_of_the_readme_reads_it_with_pandas(table: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert list(_line("pandas", table, monkeypatch)["run"]) == ["run0", "run1", "run2"]


def test_the_line_of_the_readme_reads_it_with_duckdb(table: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("duckdb", reason="DuckDB is no part of the project; the line is tried where it is installed")
    assert _line("duckdb", table, monkeypatch).fetchall() == [("lead", 31.0)]


def _line(package: str, table: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Run the line that the README has for a package on a table of its own; return what it comes to."""
    (line,) = (line for line in README.read_text().splitlines() if f"import {package}" in line and "sweeps/" in line)
    place = table.parent / "results" / "solar_reflex" / "sweeps" / "NAME"
    place.mkdir(parents=True)
    (place / "runs.parquet").write_bytes((table / "runs.parquet").read_bytes())
    monkeypatch.chdir(table.parent)
    first, _, last = line.partition("; ")
    known: dict[str, Any] = {}
    exec(first, known)
    return eval(last, known)


def test_headlines_are_the_highest_soc_that_half_of_the_runs_reach(table: Path) -> None:
    columns = pq.read_table(table / "runs.parquet").to_pydict()
    found = {one.column: (one.unit, one.factor) for one in reading.outcomes(columns)}
    assert found["cc_cv.time_to_soc_0.95_s"] == ("h", 1 / 3600)
    assert found["cv_reflex.energy_efficiency"] == ("%", 100.0)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_page_shows_every_run_and_a_picture(
    table: Path, count: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept = style.save
    folder = tmp_path / "page"
    folder.mkdir()
    settings = {
        "keys": KEYS[-count:],
        **{"study": "s", "sweep": "pulses", "title": "T & U", "command": "python -m pipeline -m x=<1>,2"},
        "files": ["results/s/sweeps/pulses/runs.parquet"],
        "names": NAMES,
    }
    drawn = []
    monkeypatch.setattr(style, "save", lambda figure, *place: (drawn.append(figure), kept(figure, *place)))
    sweep_page.run(settings, Inputs({"sweep": table}, {}), Output(folder, {}))
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert "T &amp; U: 3 runs" in page
    assert "x=&lt;1&gt;,2" in page
    # One comparison has no name of its own in the table.
    assert "<figcaption>The modes: time, peak temperature" in page
    assert len(re.findall(r"<tr>", page)) == 4
    for file in re.findall(r'src="([^"]+)"', page):
        assert (folder / file).is_file()
    assert re.findall(r'src="([^"]+)"', page)
    card = json.loads((folder / "card.json").read_text(encoding="utf-8"))
    assert card["title"] == "T & U, sweep pulses"
    assert card["question"].startswith("3 runs over ")
    assert (folder / card["picture"]["file"]).is_file()
    told = [one.get_text() for one in drawn[0].findobj(Text)] + re.findall(r"<th[^>]*>(.*?)</th>", page)
    assert not [one for one in told if re.search(r"[a-z]_[a-z]|degC|\.[a-z]", one)]
    assert any("Peak temperature [°C]" in " ".join(one.split()) for one in told)
    assert count < 2 or any("CV-Reflex frequency [Hz]" in " ".join(one.split()) for one in told)
    assert count < 3 or any("Lead-acid" in one for one in told)


def test_the_terminal_shows_the_runs_and_what_was_missed(table: Path, tmp_path: Path) -> None:
    folder = store.artefact(tmp_path, "sweep", "0" * 64)
    folder.parent.mkdir(parents=True)
    table.rename(folder)
    run = {
        "study": "s",
        "name": "sweeps/pulses",
        "view": [{"step": "sweep", "key": "0" * 64, "file": "runs.parquet"}],
        "sweep": {"run0": {"values": ["lead", 10, True]}},
    }
    lines = list(telling.lines(run, {"sweep"}, tmp_path))
    assert lines[0].startswith("s/sweeps/pulses: 3 runs")
    assert "cv_reflex: 1 of 3 runs missed something, as far" in lines
    assert any("50.5" in line and "1.0003" in line for line in lines)
    # In a pipe a line is a row: no boxes, and what was swept stands in each.
    assert [line.split()[0] for line in lines[2:8]] == ["lead"] * 6
    assert not re.search(r"[\x1b\u2500-\u257f]", "".join(lines))
    assert list(telling.lines(run, {"charge"}, tmp_path)) == []


def test_prefixes_tell_charges_apart() -> None:
    names = ["charge/a/cc_cv", "charge/b/cc_cv", "second_charge/a/cc_cv"]
    assert list(reading.prefixes(names).values()) == ["a.cc_cv", "b.cc_cv", "second.a.cc_cv"]
    assert reading.prefixes(names[:1]) == {"charge/a/cc_cv": "cc_cv"}
