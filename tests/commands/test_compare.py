"""`compare` reads what is on disk: damage at rest is told, and where two tables differ."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline.__main__ import main
from pipeline.commands.expected import Recorded
from pipeline.kernel import digest


def _run(root: Path, values: list[float], run: str = "run") -> Path:
    folder = root / "results" / "study" / run
    folder.mkdir(parents=True)
    pq.write_table(pa.table({"Voltage / V": values}), folder / "trace.parquet")
    (folder / "found.json").write_text("{}\n")
    shown = [
        {"path": f"results/study/{run}/{name}", "sha256": digest.of_file(folder / name)}
        for name in ("trace.parquet", "found.json")
    ]
    (folder / "manifest.json").write_text(json.dumps({"study": "study", "run": run, "artefacts": shown, "nodes": {}}))
    return folder


@pytest.fixture
def runs(tmp_path: Path) -> tuple[Path, Path]:
    return _run(tmp_path / "a", [1.0, 2.0, 4.0]), _run(tmp_path / "b", [1.0, 2.0, 4.0])


def _tables(root: Path, *tables: dict[str, list[object]]) -> list[Path]:
    """Publish a run of each table, in a project of its own."""
    runs = []
    for number, columns in enumerate(tables):
        folder = _run(root / str(number), [])
        file = folder / "trace.parquet"
        pq.write_table(pa.table(columns), file)
        text = (folder / "manifest.json").read_text()
        manifest = json.loads(text)
        manifest["artefacts"][0]["sha256"] = digest.of_file(file)
        (folder / "manifest.json").write_text(json.dumps(manifest))
        runs.append(folder)
    return runs


def _compare(*words: object) -> int:
    return main(["compare", *map(str, words)])


def test_equal_runs_are_equal(runs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    assert _compare(*runs) == 0
    assert _compare(*(run.parents[1] for run in runs)) == 0
    assert "2 artefacts equal, 0 differ" in capsys.readouterr().out


def test_a_changed_value_is_told_with_column_row_and_size(
    runs: tuple[Path, Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert _compare(runs[0], _run(tmp_path / "c", [1.0, 2.5, 4.0])) == 1
    told = capsys.readouterr().out
    assert "differs   results/trace.parquet" in told
    assert "column 'Voltage / V', row 1: 2.0 and 2.5; 1 rows differ, largest relative difference 0.2" in told


@pytest.mark.parametrize("fault", ["flipped", "truncated", "empty", "replaced", "missing"])
def test_damage_at_rest_is_told_and_the_manifest_alone_is_not_believed(
    fault: str, runs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    victim = runs[1] / "trace.parquet"
    content = victim.read_bytes()
    if fault == "missing":
        victim.unlink()
    else:
        flipped = content[:20] + bytes([content[20] ^ 1]) + content[21:]
        victim.write_bytes({"flipped": flipped, "truncated": content[:-9], "empty": b"", "replaced": b"x"}[fault])
    assert _compare(*runs) == 1
    told = capsys.readouterr().out
    assert "differs   results/trace.parquet" in told
    assert str(victim) in told
    assert _compare(*runs, "--trust-manifest") == 0
    assert "no artefact was read" in capsys.readouterr().out


def test_the_same_damage_on_both_sides_is_told(runs: tuple[Path, Path]) -> None:
    for run in runs:
        (run / "found.json").write_text("[]\n")
    assert _compare(*runs) == 1


def test_an_artefact_on_one_side_only_is_told(runs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    manifest = json.loads((runs[1] / "manifest.json").read_text())
    manifest["artefacts"].pop()
    (runs[1] / "manifest.json").write_text(json.dumps(manifest))
    assert _compare(*runs) == 1
    assert f"only in {runs[0]}: results/found.json" in capsys.readouterr().out


@pytest.mark.parametrize("text", ["{", "[1]", "{}", '{"artefacts": [{"path": "x"}]}'])
def test_a_damaged_manifest_ends_in_one_message(
    text: str, runs: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    (runs[1] / "manifest.json").write_text(text)
    assert _compare(*runs) == 2
    told = capsys.readouterr().err
    assert "run the study again" in told
    assert told.count("\n") == 1


@pytest.fixture
def sweeps(tmp_path: Path) -> tuple[Path, Path]:
    """Return two sweeps of a project, with their pages, beside a run of the same study."""
    _run(tmp_path, [0.0])
    made = [_run(tmp_path, values, f"sweeps/{name}") for name, values in (("one", [1.0, 2.0]), ("two", [1.0, 3.0]))]
    for folder in made:
        page = tmp_path / "reports" / folder.relative_to(tmp_path / "results") / "index.html"
        page.parent.mkdir(parents=True)
        page.write_text("the same page")
        manifest = json.loads((folder / "manifest.json").read_text())
        listed = {"path": page.relative_to(tmp_path).as_posix(), "sha256": digest.of_file(page)}
        manifest["artefacts"].append(listed)
        (folder / "manifest.json").write_text(json.dumps(manifest))
    return made[0], made[1]


def test_a_sweep_is_equal_to_itself_and_another_is_told_where_it_differs(
    sweeps: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert _compare(sweeps[0], sweeps[0]) == 0
    assert "3 artefacts equal, 0 differ, 0 on one side only" in capsys.readouterr().out
    assert _compare(*sweeps) == 1
    told = capsys.readouterr().out
    assert "differs   results/trace.parquet" in told
    assert "row 1: 2.0 and 3.0" in told
    assert "2 artefacts equal, 1 differ, 0 on one side only" in told


@pytest.mark.parametrize(("above", "artefacts"), [(0, 6), (1, 8), (2, 8)])
def test_all_sweeps_all_of_a_study_and_all_results_are_compared_whole(
    above: int, artefacts: int, sweeps: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    folder = sweeps[0].parents[above]
    assert _compare(folder, folder) == 0
    assert f"{artefacts} artefacts equal, 0 differ" in capsys.readouterr().out


def test_what_is_expected_of_results_with_sweeps_is_read(sweeps: tuple[Path, Path]) -> None:
    runs = Recorded.of(sweeps[0].parents[2]).runs
    assert set(runs) == {"study/run", "study/sweeps/one", "study/sweeps/two"}
    assert set(runs["study/sweeps/one"]["sha256"]) == {
        "results/trace.parquet",
        "results/found.json",
        "reports/index.html",
    }


def test_a_manifest_that_lists_what_is_not_of_its_run_is_refused(
    sweeps: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    text = (sweeps[0] / "manifest.json").read_text()
    (sweeps[0] / "manifest.json").write_text(text.replace("reports/study/sweeps/one", "reports/study"))
    assert _compare(*sweeps) == 2
    assert "run the study again" in capsys.readouterr().err


QUANTITIES = ["end", "loss", "rise", "soc"]


@pytest.mark.parametrize(
    ("first", "second", "told"),
    [
        (
            {"quantity": QUANTITIES, "value": [1.0, 2.0, 3.0, 4.0], "unit": ["s", "W", "K", "1"]},
            {"quantity": QUANTITIES, "value": [1.0, 2.0, 6.0, 4.0], "unit": ["s", "W", "K", "1"]},
            ["column 'value', quantity 'rise': 3.0 and 6.0; 1 rows differ, largest relative difference 0.5"],
        ),
        (  # rows that moved are not told as differing
            {"path": QUANTITIES, "value": [1.0, 2.0, 3.0, 4.0]},
            {"path": [QUANTITIES[at] for at in (3, 1, 0)], "value": [4.0, 2.0, 9.0]},
            [
                "4 and 3 rows",
                "path of the first only: 'rise'",
                "column 'value', path 'end': 1.0 and 9.0; 1 rows differ",
            ],
        ),
        (  # two columns together
            {"mode": ["a", "a", "b", "b"], "quantity": ["x", "y", "x", "y"], "value": [1, 2, 3, 4]},
            {"mode": ["a", "a", "b", "b"], "quantity": ["x", "y", "x", "y"], "value": [1, 2, 3, 5]},
            ["column 'value', mode 'b', quantity 'y': 4 and 5; 1 rows differ"],
        ),
        (  # a verdict changed: the statement names it
            {"statement": ["s1", "s2"], "verdict": ["holds", "fails"]},
            {"statement": ["s1", "s2"], "verdict": ["holds", "holds"]},
            ["column 'verdict', statement 's2': 'fails' and 'holds'; 1 rows differ"],
        ),
        (  # words that are the same in many rows, or missing, name none
            {"end": ["full", "full", None], "value": [1.0, 2.0, 3.0]},
            {"end": ["full", "full", None], "value": [1.0, 2.5, 3.0]},
            ["column 'value', row 1: 2.0 and 2.5; 1 rows differ"],
        ),
        (  # names of other things altogether
            {"run": ["a", "b"], "value": [1.0, 2.0]},
            {"run": ["c", "d"], "value": [1.0, 3.0]},
            ["column 'run', row 0: 'a' and 'c'; 2 rows differ", "column 'value', row 1: 2.0 and 3.0; 1 rows differ"],
        ),
        (
            {"value": [1.0], **{f"c{at}": [0.0] for at in range(7)}},
            {"value": [1.0], "other": [2.0]},
            ["columns of the first only: 'c0', 'c1', 'c2', 'c3', 'c4', 2 more", "columns of the second only: 'other'"],
        ),
    ],
)
def test_a_row_is_told_by_its_name_where_it_has_one(
    first: dict[str, list[object]],
    second: dict[str, list[object]],
    told: list[str],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert _compare(*_tables(tmp_path, first, second)) == 1
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()[1:-1]]
    assert [line for line in lines if not line.startswith("values of the common")] == [
        next((line for line in lines if line.startswith(one)), one) for one in told
    ]


def test_a_run_is_known_by_its_name_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _run(tmp_path, [1.0], "default")
    _run(tmp_path, [1.0], "battery=other")
    _run(tmp_path, [2.0], "sweeps/one")
    monkeypatch.chdir(tmp_path)
    same = ("study", "study/default", "study/battery=other", "./results/study/default/", "reports/study/default")
    for word in same:
        assert _compare("study/default", word) == 0
    assert _compare("study/default", "study/sweeps/one") == 1
    assert "column 'Voltage / V', row 0: 1.0 and 2.0" in capsys.readouterr().out
    assert _compare("study/default", "study/batery=other") == 2
    assert capsys.readouterr().err == (
        "error: study/batery=other: no such folder, and no run of this name; "
        "best matches are: study/battery=other, study/default\n"
    )
