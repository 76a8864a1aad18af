"""The licences of what a run needs: all of the lock file, copyleft told, the page of the documentation as of today."""

from __future__ import annotations

import re
from email.message import Message
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest

from pipeline.__main__ import main
from pipeline.commands import licences
from pipeline.commands.licences import Licence, copyleft_of, licence_of
from pipeline.kernel.places import LOCK_FILE, PACKAGE, PROJECT


@pytest.fixture(scope="module")
def found() -> list[Licence]:
    return licences.licences().found


def test_every_package_of_the_lock_file_has_a_licence(found: list[Licence]) -> None:
    locked = [line.split("==")[0] for line in LOCK_FILE.read_text().splitlines() if re.match(r"[a-z0-9].*==", line)]
    assert [one.package for one in found] == locked
    assert all(one.licence != "not said" for one in found)


def test_the_page_of_the_documentation_is_as_of_today(found: list[Licence]) -> None:
    page = (PROJECT / licences.DOCS).read_text(encoding="utf-8")
    assert licences.written(page, found) == page
    assert all(f"| {one.package} | {one.licence} |" in page for one in found)


def test_copyleft_is_told_with_who_brings_it_and_for_what(
    found: list[Licence], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["licences"]) == 0
    told = capsys.readouterr().out
    assert (
        "moocore: LGPL-2.1-or-later (copyleft of the library), through pymoo, which serves only two baselines" in told
    )
    assert {one.package for one in found if one.copyleft} >= {"moocore", "certifi", "pathspec", "docutils"}
    for one in found:
        if "GPL" in one.licence or "MPL" in one.licence:
            assert one.copyleft
            assert f"\n  {one.package}: " in told


def test_pymoo_serves_what_is_said_of_it() -> None:
    imports = re.compile(r"^\s*(?:from|import) (?:pymoo|moocore)\b", re.MULTILINE)
    using = {
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        if imports.search(path.read_text(encoding="utf-8"))
    }
    baselines = {"search/algorithms/genetic.py", "search/algorithms/particle_swarm.py"}
    # box.py hands a problem to pymoo, for these two.
    assert using == {*baselines, "search/box.py", "experiments/staging/front.py"}


@pytest.mark.parametrize(
    ("licence", "covers"),
    [
        ("MIT", ""),
        ("BSD-3-Clause AND Apache-2.0", ""),
        ("GPL-3.0-only", "copyleft"),
        ("GNU Affero General Public License v3", "copyleft"),
        ("LGPL-2.1-or-later", "copyleft of the library"),
        ("GNU Lesser General Public License v2 or later (LGPLv2+)", "copyleft of the library"),
        ("MPL-2.0 AND MIT", "copyleft of its files"),
        ("MIT OR GPL-2.0-or-later", "copyleft in part, or by choice"),
        ("LGPL-3.0-only OR GPL-2.0-or-later", "copyleft of the library"),
    ],
)
def test_what_a_copyleft_covers(licence: str, covers: str) -> None:
    assert copyleft_of(licence) == covers


class Package(metadata.Distribution):
    """A package whose metadata are these fields, and whose licence is a text."""

    def __init__(self, text: str = "", **fields: Any) -> None:
        self._text, self._fields = text, fields

    @property
    def metadata(self) -> Any:
        about = Message()
        for name, values in self._fields.items():
            for value in values if isinstance(values, list) else [values]:
                about[name.replace("_", "-")] = value
        return about

    @property
    def files(self) -> Any:
        text = self._text

        class File(metadata.PackagePath):
            def read_text(self, encoding: str = "utf-8") -> str:
                return text

        return [File("one-1.0.dist-info/licenses/LICENSE")] if text else []

    def read_text(self, filename: str) -> str | None:
        return None

    def locate_file(self, path: Any) -> Any:
        return Path(path)


MIT_TEXT = "Copyright (c) somebody\n\nPermission is hereby granted, free\nof charge, to any person"


@pytest.mark.parametrize(
    ("package", "licence"),
    [
        (Package(License_Expression="MIT", License="whatever"), "MIT"),
        (Package(Classifier=["License :: OSI Approved :: BSD License", "Topic :: X"]), "BSD License"),
        (Package(License="Apache-2.0\n\nlong text"), "Apache-2.0"),
        (Package(MIT_TEXT, License="Copyright (c) 2015, the project"), "MIT"),
        (Package(MIT_TEXT), "MIT"),
        (Package("GNU LESSER GENERAL PUBLIC LICENSE\nVersion 3"), "LGPL"),
        (Package(), "not said"),
    ],
)
def test_a_licence_is_read_from_what_a_package_says(package: Package, licence: str) -> None:
    assert licence_of(package) == licence


LOCKED = {"charge-one": "1.0", "charge-two": "2.0", "charge-hatch": "3.0", "charge-path": "4.0", "charge-win": "5.0"}


def _installed(site: Path, name: str, *asks: str) -> None:
    """Install a package that is its metadata alone."""
    folder = site / f"{name.replace('-', '_')}-1.0.dist-info"
    folder.mkdir(parents=True)
    needs = "".join(f"Requires-Dist: {one}\n" for one in asks)
    about = f"Metadata-Version: 2.4\nName: {name}\nVersion: 1.0\nLicense-Expression: MIT\n{needs}"
    (folder / "METADATA").write_text(about)


@pytest.fixture
def site(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """Return where packages lie beside the project's own wheel, and make a lock file of it."""
    lock = tmp_path / "requirements.lock"
    lock.write_text("".join(f"{name}=={version} \\\n    --hash=sha256:0\n" for name, version in LOCKED.items()))
    monkeypatch.setattr(licences, "LOCK_FILE", lock)
    monkeypatch.setattr(licences, "INSTALLED", True)
    monkeypatch.setattr("sys.path", [str(tmp_path / "site")])
    asks = ("charge-one[fast]>=1", "charge_hatch; extra == 'build'", "charge-win; sys_platform == 'win32'")
    _installed(tmp_path / "site", "charge-pipeline", *asks)
    return tmp_path / "site"


def test_what_is_locked_for_the_build_alone_is_left_out_of_a_wheels_licences(
    site: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _installed(site, "charge-one", "Charge.Two; extra == 'fast'", "charge-slow; extra == 'slow'")
    _installed(site, "charge-two", "charge-new")
    _installed(site, "charge-new", "charge-one")
    assert main(["licences"]) == 0
    told = capsys.readouterr().out
    rows = [re.split(r"\s{2,}", line.strip()) for line in told.split("\n\n")[0].splitlines()]
    assert rows[1:] == [
        ["charge-one", "MIT"],
        ["charge-two", "MIT", "charge-one"],
        ["charge-new", "MIT", "charge-one > charge-two"],
    ]
    assert "no run needs them: charge-hatch, charge-path, charge-win\n" in told


def test_a_package_of_the_build_that_is_installed_is_marked(site: Path) -> None:
    _installed(site, "charge-one", "charge-two")
    _installed(site, "charge-two")
    _installed(site, "charge-hatch", "charge-path")
    found = {one.package: one.through for one in licences.licences().found}
    assert found == {"charge-one": "", "charge-two": "charge-one", "charge-hatch": licences.BUILD}


@pytest.mark.parametrize(
    ("wheel", "remedy"), [(True, "python -m pip install charge-two==2.0 charge-new"), (False, "make setup")]
)
def test_a_package_that_is_missing_is_told_after_the_others_with_what_installs_it(
    wheel: bool, remedy: str, site: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(licences, "INSTALLED", wheel)
    _installed(site, "charge-one", "charge-two", "charge-new")
    _installed(site, "charge-path")
    assert main(["licences"]) == 2
    told = capsys.readouterr()
    # Perhaps brought by what is missing: nothing is said of whether a run needs these.
    assert licences.BUILD not in told.out
    assert "left out" not in told.out
    assert re.search(r"charge-one +MIT", told.out)
    assert told.err == f"error: requirements.lock: charge-two, charge-new are not installed; {remedy}\n"
    assert main(["licences", "--write"]) == 2
    assert capsys.readouterr().out == ""


def test_without_metadata_of_its_own_all_that_is_locked_is_needed(site: Path) -> None:
    (site / "charge_pipeline-1.0.dist-info" / "METADATA").unlink()
    (site / "charge_pipeline-1.0.dist-info").rmdir()
    _installed(site, "charge-one")
    missing = [name for name in LOCKED if name != "charge-one"]
    assert licences.licences() == ([Licence("charge-one", "MIT", "", "")], missing, [])
