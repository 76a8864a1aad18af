"""A project of one's own: its configuration before the shipped one, with the package of a clone or of a wheel."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from pipeline.__main__ import main
from pipeline.commands import init
from pipeline.errors import UserError
from pipeline.kernel import places


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("own") / "garage"
    list(init.write(folder))
    return folder


def _python(folder: Path, *words: str, code: int = 0) -> str:
    """Run Python in a folder with this package; return what it printed."""
    done = subprocess.run(
        [sys.executable, *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(places.PACKAGE.parent)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout + done.stderr


def test_its_study_is_the_one_that_is_meant_and_builds_on_shipped_files(own: Path) -> None:
    shown = yaml.safe_load(_python(own, "-m", "pipeline", "--cfg"))
    assert shown["study"]["name"] == "garage"
    assert shown["battery"]["name"] == "garage_battery"
    assert shown["battery"]["cells_in_series"] == 6
    assert set(shown["modes"]) == {"cc_cv", "garage_pulse", "garage_reflex"}


def test_a_file_that_builds_on_none_is_named(own: Path) -> None:
    file = own / "conf" / "battery" / "other.yaml"
    file.write_text("defaults: [lead_acid_12v7a, _self_]\nname: other\n", encoding="utf-8")
    told = _python(own, "-m", "pipeline", "battery=other", "--cfg", code=2)
    assert "error: conf/battery/other.yaml: defaults: no conf/battery/lead_acid_12v7a.yaml; best matches are: " in told
    file.unlink()
    told = _python(own, "-m", "pipeline", "battery=other", "--cfg", code=2)
    assert "error: override battery=other: no conf/battery/other.yaml; " in told


def test_a_file_of_the_same_name_takes_the_place_of_the_shipped_one(own: Path) -> None:
    file = own / "conf" / "modes" / "cc_cv.yaml"
    file.parent.mkdir(exist_ok=True)
    shipped = (places.SHIPPED / "conf" / "modes" / "cc_cv.yaml").read_text()
    file.write_text(shipped.replace("max_current_a: 2.1", "max_current_a: 2.5"))
    try:
        shown = yaml.safe_load(_python(own, "-m", "pipeline", "--cfg"))
        assert shown["modes"]["cc_cv"]["max_current_a"] == 2.5
        file.write_text(shipped.replace("max_current_a: 2.1", "max_current_a: x"))
        told = _python(own, "-m", "pipeline", "--cfg", code=2)
        assert told.startswith("error: conf/modes/cc_cv.yaml:3: modes.cc_cv.max_current_a")
    finally:
        file.unlink()


def test_all_means_its_own_studies_and_shipped_ones_are_there_by_name(own: Path) -> None:
    code = "from pipeline.config.compose import cards; from pipeline.commands.workflow import wanted; import sys; "
    code += "print(wanted(cards(), sys.argv[1:]))"
    assert _python(own, "-c", code, "all").strip() == "['garage']"
    assert _python(own, "-c", code, "nicd_grnn").strip() == "['nicd_grnn']"


def test_snakemake_plans_it(own: Path) -> None:
    told = _python(own, "-m", "snakemake", "--cores", "1", "-n", "all")
    assert "charge_battery" in told
    assert "write_page" in told


def test_the_keys_are_those_of_the_clone(own: Path) -> None:
    """A shipped study is the same artefacts, wherever it is asked for."""
    code = "from pipeline.config.planning import run_of; print(sorted(run_of(['study=nicd_grnn']).keys.items()))"
    assert _python(own, "-c", code) == _python(places.PROJECT, "-c", code)


def test_a_notebook_there_knows_its_batteries(own: Path) -> None:
    assert (
        _python(own, "-c", "import pipeline as cp; print(cp.battery('garage_battery').title)") == "Battery of garage\n"
    )


@pytest.mark.parametrize("name", ["solar_reflex", "2nd", "Two words"])
def test_a_name_that_no_study_can_have_is_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot name its study"):
        list(init.write(tmp_path / "new", name))
    assert not (tmp_path / "new").exists()


def test_a_folder_that_holds_something_is_left_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "note").write_text("x")
    assert main(["init", str(tmp_path)]) == 2
    assert "is there and not empty" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["note"]
