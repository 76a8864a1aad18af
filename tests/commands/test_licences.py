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
from pipeline.errors import UserError
from pipeline.kernel.places import LOCK_FILE, PACKAGE, PROJECT


@pytest.fixture(scope="module")
def found() -> list[Licence]:
    return list(licences.licences())


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


def test_a_package_that_is_not_installed_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    lock = tmp_path / "requirements.lock"
    lock.write_text("no-such-package==1.0 \\\n    --hash=sha256:0\n")
    monkeypatch.setattr(licences, "LOCK_FILE", lock)
    with pytest.raises(UserError, match="no-such-package is not installed"):
        list(licences.licences())
