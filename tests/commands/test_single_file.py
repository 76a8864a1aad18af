"""A page as one file: everything it shows is in it, and nothing in it leads beside it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pipeline.commands import report
from pipeline.errors import UserError
from tests.browser import site


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    site.build(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path / "reports" / "study" / "default"


def test_figures_and_scripts_are_in_the_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert report.main(["study", "--single-file", "one.html"]) == 0
    page = Path("one.html").read_text(encoding="utf-8")
    sources = re.findall(r'\bsrc="([^"]*)"', page)
    assert len(sources) == 5
    assert all(source.startswith("data:image/svg+xml;base64,") for source in sources)
    assert "window.TRACES = [" in page
    assert "window.RUN = {" in page
    assert not re.findall(r'href="(?!#|data:|https://doi\.org/)[^"]*"', page)
    assert "one.html" in capsys.readouterr().out


def test_the_page_of_the_run_asked_for_is_taken(folder: Path) -> None:
    report.main(["reports/study/seed=2", "--single-file", "other.html"])
    assert '"study/seed=2"' in Path("other.html").read_text(encoding="utf-8")


def test_what_is_not_published_is_refused(folder: Path) -> None:
    with pytest.raises(UserError, match="not published here"):
        report.main(["nothing", "--single-file", "one.html"])


def test_a_place_that_cannot_be_written_is_refused(folder: Path) -> None:
    with pytest.raises(UserError, match=r"no/such/one\.html"):
        report.main(["study", "--single-file", "no/such/one.html"])
