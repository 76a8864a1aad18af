"""Any file of the readable view or the report is a target by its path; it brings what it needs and nothing else."""

from __future__ import annotations

import html
import json
import re
import zipfile

import pytest
import yaml

from tests.workflow.conftest import Project, copy_project, rules

pytestmark = [pytest.mark.workflow, pytest.mark.slow]

RUN = "solar_reflex/default"
CURVES = f"reports/{RUN}/figures/panel_curves.svg"


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Project:
    return copy_project(tmp_path_factory.mktemp("files") / "project")


def _there(project: Project, room: str) -> set[str]:
    folder = project.folder / room / RUN
    return {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}


def test_a_figure_by_its_path(fresh: Project) -> None:
    planned = rules(fresh.snakemake("-n", CURVES))
    place = next(name for name in planned if name.startswith("place_"))
    assert dict(planned) == {"fit_panel": 1, "draw_figures": 1, place: 1}
    fresh.snakemake(CURVES)
    assert _there(fresh, "reports") == {"figures/panel_curves.svg"}
    assert _there(fresh, "results") == {"manifest.files.json"}
    assert "Nothing to be done" in fresh.snakemake(CURVES)


def test_a_report_of_snakemake_s_carries_captions_categories_and_the_workflow(fresh: Project) -> None:
    fresh.snakemake(CURVES)
    fresh.snakemake("--report", "workflow.zip", CURVES)
    with zipfile.ZipFile(fresh.folder / "workflow.zip") as archive:
        names = archive.namelist()
        page = archive.read("workflow/report.html").decode("utf-8")
    assert any(name.endswith("/panel_curves.svg") for name in names)
    found = json.loads(re.search(r'id="results">\s*var results = (.*?);\s*</script>', page, re.S)[1])
    figure, receipts = found[CURVES], [one for name, one in found.items() if name.endswith(".json")]
    card = yaml.safe_load((fresh.folder / "conf/report/solar_reflex.yaml").read_text(encoding="utf-8"))["panel_curves"]
    told = " ".join(html.unescape(re.sub(r"<[^>]+>", "", figure["caption"])).split())
    assert told.startswith(f"{card['title']}. {' '.join(card['caption'].split())} {CURVES}, as the run of its study")
    assert receipts
    assert all("its artefacts by their keys" in " ".join(one["caption"].split()) for one in receipts)
    categories = re.search(r'id="categories">\s*var categories = (.*?);\s*</script>', page, re.S)[1]
    assert set(json.loads(categories)) == {"solar_reflex", "Steps"}
    assert "a configuration becomes a plan" in page
    assert all(f'"rule": "{rule}"' in page or f'"{rule}"' in page for rule in ("fit_panel", "draw_figures"))


def test_a_table_by_its_path_is_remade_where_it_is_no_longer_the_run_s(fresh: Project) -> None:
    path = f"results/{RUN}/panel/curves.parquet"
    fresh.snakemake(path)
    first = (fresh.folder / path).read_bytes()
    panel = fresh.folder / "conf/panel/kc65t.yaml"
    text = panel.read_text()
    try:
        panel.write_text(text.replace("max_power_current_a: 3.75", "max_power_current_a: 3.70"))
        assert panel.read_text() != text
        fresh.snakemake(path)
        assert (fresh.folder / path).read_bytes() != first
        # What another configuration placed is no longer this run's.
        assert not (fresh.folder / CURVES).exists()
    finally:
        panel.write_text(text)
    fresh.snakemake(path)
    assert (fresh.folder / path).read_bytes() == first


def test_a_file_that_nothing_makes_is_refused(fresh: Project) -> None:
    plans = set(fresh.folder.glob("results/plan/*"))
    printed = fresh.snakemake(f"reports/{RUN}/figures/figure_99.svg", code=2)
    assert "figure_99.svg: no run that is planned makes this file" in printed
    assert set(fresh.folder.glob("results/plan/*")) == plans
