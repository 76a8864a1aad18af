"""What publishing says beside a page, and the page that leads to all of them."""

from __future__ import annotations

import json
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from pipeline.experiments.reporting import announce
from tests.report_pages.test_pages import Page

MANIFEST = {
    "command": "snakemake --cores 2 one",
    "commit": "0123456789abcdef",
    "digest": "fedcba",
    "seed": 7,
    "versions": {"python": "3.11.7"},
    "configuration": {"large": True},
}


def report(root: Path, place: str, **fields: Any) -> dict[str, str]:
    """Write a page with its card; return the run as a plan names it."""
    folder = root / "reports" / place
    folder.mkdir(parents=True)
    card = {
        "title": f"Title of <{place}>",
        "question": "Which?",
        "answer": "This one, at 25 degC.",
        "counts": [["holds", 3], ["undecided", 1]],
        "picture": {"file": "figures/one.svg", "size": [864, 384], "text": "One"},
        "departs": [],
    }
    (folder / "card.json").write_text(json.dumps(card | fields), encoding="utf-8")
    (folder / "index.html").write_text("<!DOCTYPE html>", encoding="utf-8")
    study, _, name = place.partition("/")
    return {"study": study, "name": name}


def script(path: Path) -> dict[str, Any]:
    found = re.match(r"window\.\w+ = (.*);\n", path.read_text(encoding="utf-8"))
    assert found
    return json.loads(found[1])


def test_a_script_beside_the_page_tells_of_the_run(tmp_path: Path) -> None:
    announce.published(report(tmp_path, "one/default"), MANIFEST, tmp_path / "results")
    told = script(tmp_path / "reports/one/default/run.js")
    assert {name: told[name] for name in ("command", "commit", "seed", "versions")} == {
        name: MANIFEST[name] for name in ("command", "commit", "seed", "versions")
    }
    assert re.fullmatch(r"\d{4}-\d\d-\d\d \d\d:\d\d UTC", told["made"])
    assert "configuration" not in told


def test_the_front_page_leads_to_every_page_and_loads_nothing_else(tmp_path: Path) -> None:
    run = report(tmp_path, "one/default")
    report(tmp_path, "one/seed=2", departs=["seed=2"])
    report(tmp_path, "validation/default", counts=[], picture=None)
    report(tmp_path, "one/sweeps/pulses", counts=[], picture=None)
    announce.published(run, MANIFEST, tmp_path / "results")
    text = (tmp_path / "reports/index.html").read_text(encoding="utf-8")
    page = Page(text)
    links = [link for link in page.attributes("href") if link.endswith("index.html")]
    places = ["one/default", "one/seed=2", "one/sweeps/pulses", "validation/default"]
    assert sorted(set(links)) == [f"{place}/index.html" for place in places]
    assert page.attributes("src") == ["one/default/figures/one.svg", "one/seed=2/figures/one.svg", "one/default/run.js"]
    assert {f"../results/{place}/manifest.json" for place in places} <= set(page.attributes("href"))
    assert "Title of <one/default>" in page.text
    assert "This one, at 25 °C." in page.text
    assert (
        text.index("Studies</h2>")
        < text.index("one/default")
        < text.index("Other runs</h2>")
        < text.index("one/seed=2")
    )
    assert [one["place"] for one in script(tmp_path / "reports/reports.js")] == places


def test_a_run_without_a_page_gets_no_script_and_no_card(tmp_path: Path) -> None:
    run = report(tmp_path, "one/default")
    announce.published(run, MANIFEST, tmp_path / "results")
    (tmp_path / "reports/one/default/index.html").unlink()
    announce.published(run, MANIFEST, tmp_path / "results")
    assert not (tmp_path / "reports/one/default/run.js").exists()
    assert "one/default" not in (tmp_path / "reports/index.html").read_text(encoding="utf-8")


def test_without_reports_nothing_is_written(tmp_path: Path) -> None:
    announce.published({"study": "one", "name": "default"}, MANIFEST, tmp_path / "results")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("damage", ["", "[]", '{"title": "t"}', "{"])
def test_a_damaged_card_is_left_out(tmp_path: Path, damage: str) -> None:
    run = report(tmp_path, "one/default")
    report(tmp_path, "two/default")
    (tmp_path / "reports/two/default/card.json").write_text(damage, encoding="utf-8")
    announce.published(run, MANIFEST, tmp_path / "results")
    assert "two/default" not in (tmp_path / "reports/index.html").read_text(encoding="utf-8")


def test_of_jobs_that_publish_at_once_the_last_has_seen_all(tmp_path: Path) -> None:
    runs = [report(tmp_path, f"study_{number}/default") for number in range(8)]
    with ThreadPoolExecutor(8) as jobs:
        list(jobs.map(lambda run: announce.published(run, MANIFEST, tmp_path / "results"), runs))
    text = (tmp_path / "reports/index.html").read_text(encoding="utf-8")
    assert all(f"study_{number}/default/run.js" in text for number in range(8))
    assert not list((tmp_path / "reports").rglob(".*"))


def test_a_run_that_the_study_was_made_from_has_no_card_beside_it(tmp_path: Path) -> None:
    run = report(tmp_path, "one/default", title="One", departs=["functions=full"])
    report(tmp_path, "one/functions=full", title="One", departs=["functions=full"])
    report(tmp_path, "one/seed=2", title="One", departs=["seed=2"])
    announce.published(run, MANIFEST, tmp_path / "results")
    text = (tmp_path / "reports/index.html").read_text(encoding="utf-8")
    links = {link for link in Page(text).attributes("href") if link.endswith("index.html")}
    assert links == {"one/default/index.html", "one/seed=2/index.html"}
    assert text.index("Studies</h2>") < text.index("Made with") < text.index("Other runs</h2>")


def test_modes_side_by_side_have_a_card_without_a_manifest_until_their_page_is_gone(tmp_path: Path) -> None:
    report(tmp_path, "one/default")
    report(tmp_path, "compare_modes/cell__cc_cv", counts=[])
    reports = tmp_path / "reports"
    announce.lead_to_all(reports)
    text = (reports / "index.html").read_text(encoding="utf-8")
    assert text.index("Modes side by side</h2>") < text.index("compare_modes/cell__cc_cv/index.html")
    assert "../results/one/default/manifest.json" in text
    assert "results/compare_modes" not in text
    (reports / "compare_modes/cell__cc_cv/index.html").unlink()
    announce.lead_to_all(reports)
    assert "compare_modes" not in (reports / "index.html").read_text(encoding="utf-8")
