"""`reproduce` holds what was made against what is expected: bytes on the recorded machine, numbers on another."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from pipeline.__main__ import main
from pipeline.commands import expected, reproduce
from pipeline.commands.run import cores
from pipeline.errors import UserError
from pipeline.experiments.charges.tables import CHARGE
from pipeline.experiments.frequency.tables import CHAOS
from pipeline.kernel import digest, tables
from pipeline.published.evaluate import VERDICTS

MACHINE = {"cpu": "one", "python": "3.11"}
PHASE = {
    "phase": ["bulk", "absorption"],
    "start_s": [0.0, 3600.0],
    "end_s": [3600.0, 7200.0],
    "end_reason": ["voltage", "time"],
    "start_soc": [0.2, 0.7],
    "end_soc": [0.7, 0.9],
    "end_temperature_c": [25.0, 31.0],
}
ORBIT = {"r": np.full(3, 4.0), "step": np.arange(3), "value": [0.1, 0.36, 0.9216]}
NUMBERS = {"quantity": ["capacity_ah", "none_v"], "value": [7.0, None], "unit": ["A h", "V"], "description": ["", ""]}
VERDICT = {column.name: ["x"] if column.kind == "text" else [None] for column in VERDICTS.columns} | {
    "statement": ["warmer"],
    "verdict": ["holds"],
}


def _made(root: Path, change: Callable[[dict[str, dict[str, object]]], None] = lambda made: None) -> Path:
    """Make the results folder of a run with a table of each kind."""
    made: dict[str, dict[str, object]] = {
        "phases.parquet": dict(PHASE),
        "orbit.parquet": dict(ORBIT),
        "quantities.parquet": dict(NUMBERS),
        "verdicts.parquet": dict(VERDICT),
        "found.json": {"frequency_hz": 90.0, "currents_a": [27.0, 25.0]},
    }
    change(made)
    declared = {
        "phases.parquet": ("charge", CHARGE["phases"].table),
        "orbit.parquet": ("chaos", CHAOS["orbit"].table),
        "quantities.parquet": ("chaos", CHAOS["quantities"].table),
        "verdicts.parquet": ("verdicts", VERDICTS),
    }
    results = root / "results"
    folder, store = results / "study" / "run", results / "store" / "search" / "key"
    folder.mkdir(parents=True)
    store.mkdir(parents=True)
    (store / "found.json").write_text(json.dumps(made["found.json"]))
    for file, (_, table) in declared.items():
        if file in made:
            tables.write(table, made[file], folder / file)
    shown = [
        {
            "path": f"results/study/run/{file}",
            "sha256": digest.of_file(folder / file),
            "step": step,
            "file": file,
        }
        for file, (step, _) in declared.items()
        if file in made
    ]
    nodes = {"search": {"step": "search", "key": "key"}}
    manifest = {"study": "study", "run": "run", "artefacts": shown, "nodes": nodes}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return results


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file of what is expected, recorded on the machine `MACHINE`."""
    monkeypatch.setattr(expected, "fingerprint", lambda: dict(MACHINE))
    file = tmp_path / "expected.json"
    assert _reproduce("--renew", "--expected", file, "--results", _made(tmp_path / "recorded")) == 0
    return file


@pytest.fixture
def elsewhere(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Moves to another machine than the recorded one."""
    return lambda: monkeypatch.setattr(expected, "fingerprint", lambda: MACHINE | {"cpu": "another"})


def _reproduce(*words: object) -> int:
    return main(["reproduce", *map(str, words)])


def _set(name: str, column: str, value: object) -> Callable[[dict[str, dict[str, object]]], None]:
    return lambda made: made[name].update({column: value})


def test_a_change_of_the_file_reads_as_numbers(file: Path, tmp_path: Path) -> None:
    before = file.read_text().splitlines()
    warmer = _made(tmp_path / "warmer", _set("phases.parquet", "end_temperature_c", [25.0, 32.0]))
    assert _reproduce("--renew", "--expected", file, "--results", warmer) == 0
    after = file.read_text().splitlines()
    differing = [(old.strip(), new.strip()) for old, new in zip(before, after, strict=True) if old != new]
    assert [pair for pair in differing if "parquet" not in pair[0]] == [
        ('"last": 31.0,', '"last": 32.0,'),
        ('"mean": 28.0,', '"mean": 28.5,'),
        ('"most": 31.0', '"most": 32.0'),
    ]
    # Beside the numbers, one sha256.
    assert len(differing) == 4


def test_what_is_recorded(file: Path) -> None:
    run = json.loads(file.read_text())["runs"]["study/run"]
    assert run["found"] == {"search": {"frequency_hz": 90.0, "currents_a": [27.0, 25.0]}}
    assert run["verdicts"] == {"results/verdicts.parquet": {"warmer": "holds"}}
    assert run["numbers"] == {"results/quantities.parquet": {"capacity_ah": 7.0, "none_v": None}}
    # Rows of the same value need one number; an orbit is chaotic.
    assert run["tables"]["results/orbit.parquet"] == {
        "rows": 3,
        "r": 4.0,
        "step": {"least": 0.0, "mean": 1.0, "most": 2.0, "last": 2.0},
    }


@pytest.mark.parametrize("bytes_too", [True, False])
def test_the_same_is_as_expected(
    bytes_too: bool,
    file: Path,
    elsewhere: Callable[[], None],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if not bytes_too:
        elsewhere()
    assert _reproduce("--expected", file, "--results", _made(tmp_path / "again")) == 0
    told = capsys.readouterr().out
    assert ("byte by byte" in told) == bytes_too
    assert ("cpu: another; recorded: one" in told) == (not bytes_too)
    assert "0 differ; no number differs" in told


def test_a_last_digit_counts_on_the_recorded_machine_alone(
    file: Path, elsewhere: Callable[[], None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    off = _made(tmp_path / "off", _set("phases.parquet", "end_s", [3600.0, 7200.0 * (1 + 1e-7)]))
    assert _reproduce("--expected", file, "--results", off) == 1
    assert "study/run results/phases.parquet: sha256" in capsys.readouterr().out
    elsewhere()
    assert _reproduce("--expected", file, "--results", off) == 0
    told = capsys.readouterr().out
    assert "largest difference let pass: 1e-07 of study/run results/phases.parquet: end_s" in told


@pytest.mark.parametrize(("last", "code"), [(4.0 * (1 + 1e-7), 0), (4.1, 1)])
def test_a_column_of_one_number_may_vary_in_its_last_digit(
    last: float, code: int, file: Path, elsewhere: Callable[[], None], tmp_path: Path
) -> None:
    off, varying = _made(tmp_path / "off", _set("orbit.parquet", "r", [4.0, 4.0, last])), tmp_path / "varying.json"
    assert _reproduce("--renew", "--expected", varying, "--results", off) == 0
    elsewhere()
    assert _reproduce("--expected", file, "--results", off) == code
    assert _reproduce("--expected", varying, "--results", _made(tmp_path / "same")) == code


WRONG = {
    "a column": (_set("phases.parquet", "end_s", [3600.0, 7200.1]), "phases.parquet: end_s most"),
    "a text": (_set("phases.parquet", "end_reason", ["time", "time"]), "phases.parquet: end_reason"),
    "a row more": (lambda made: made.update({"phases.parquet": {k: [*v, v[-1]] for k, v in PHASE.items()}}), "rows"),
    "a named number": (_set("quantities.parquet", "value", [7.1, None]), "quantities.parquet: capacity_ah"),
    "a number where there was none": (_set("quantities.parquet", "value", [7.0, 1.0]), "none_v"),
    "a name": (_set("quantities.parquet", "quantity", ["capacity_ah", "other_v"]), "other_v: made, not expected"),
    "a verdict": (_set("verdicts.parquet", "verdict", ["contradicted"]), "warmer: 'holds' expected, 'contradicted'"),
    "a found value": (_set("found.json", "frequency_hz", 91.0), "search: frequency_hz: 90.0 expected, 91.0 found"),
    "one of found values": (_set("found.json", "currents_a", [27.0, 24.0]), "currents_a 1: 25.0 expected"),
    "fewer found values": (_set("found.json", "currents_a", [27.0]), "currents_a 1: 25.0 expected, None found"),
    "an artefact": (lambda made: made.pop("phases.parquet"), "phases.parquet: expected, not made"),
}


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("bytes_too", [True, False])
def test_what_differs_is_named_on_every_machine(
    bytes_too: bool,
    wrong: str,
    file: Path,
    elsewhere: Callable[[], None],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    change, told = WRONG[wrong]
    if not bytes_too:
        elsewhere()
    assert _reproduce("--expected", file, "--results", _made(tmp_path / "wrong", change)) == 1
    assert told in capsys.readouterr().out


def test_chaos_counts_on_the_recorded_machine_alone(file: Path, elsewhere: Callable[[], None], tmp_path: Path) -> None:
    off = _made(tmp_path / "off", _set("orbit.parquet", "value", [0.1, 0.36, 0.1]))
    assert _reproduce("--expected", file, "--results", off) == 1
    elsewhere()
    assert _reproduce("--expected", file, "--results", off) == 0


def test_what_lies_on_disk_counts_and_not_the_manifest(file: Path, tmp_path: Path) -> None:
    results = _made(tmp_path / "flipped")
    victim = results / "study/run/orbit.parquet"
    victim.write_bytes(victim.read_bytes()[:-9])
    assert _reproduce("--expected", file, "--results", results) == 2


@pytest.mark.parametrize(
    ("text", "told"), [(None, "nothing is expected yet"), ("{", "not JSON"), ("[]", "version"), ("{}", "version")]
)
def test_a_file_that_is_none_ends_in_one_message(
    text: str | None, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "expected.json"
    if text is not None:
        file.write_text(text)
    assert _reproduce("--expected", file, "--results", _made(tmp_path / "made")) == 2
    message = capsys.readouterr().err
    assert told in message
    assert "--renew" in message
    assert message.count("\n") == 1


def test_another_cpu_is_played_for_every_library_that_looks_at_it() -> None:
    ours = expected.fingerprint()
    played = reproduce.machine(True)
    assert played["cpu"] == "generic"
    assert ours["cpu"] != "generic"
    for name in ("lock file", "libc", "platform", "python"):
        assert played[name] == ours[name]
    assert set(played["numpy's features"].split()) <= set(ours["numpy's features"].split())


def test_it_takes_the_project_as_it_is_and_nothing_that_was_made(tmp_path: Path) -> None:
    project = tmp_path / "project"
    for name in (
        "conf/study/a.yaml",
        "src/pipeline/reports/x.py",
        "Snakefile",
        "results/a",
        "reports/b",
        ".cache/c",
        ".git/d",
    ):
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        (project / name).write_text("x")
    reproduce.copied(project, tmp_path / "copy")
    found = {path.relative_to(tmp_path / "copy").as_posix() for path in (tmp_path / "copy").rglob("*.*")}
    assert found == {"conf/study/a.yaml", "src/pipeline/reports/x.py"}


def test_it_runs_on_another_number_of_cores() -> None:
    assert reproduce.other_cores("2") != "2"
    assert reproduce.other_cores("all") == cores("1")


def test_a_folder_that_is_there_is_left_alone(file: Path, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="is there already"):
        reproduce.main(["--expected", str(file), "--folder", str(tmp_path)])
