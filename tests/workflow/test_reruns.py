"""What runs again after a change, and what does not."""

from __future__ import annotations

import json
from collections import Counter

import pytest

from pipeline.kernel import store
from tests.workflow.conftest import Project, rules

pytestmark = [pytest.mark.workflow, pytest.mark.slow]
SUPPLY = {"fit_panel", "power_supply", "try_trackers", "follow_daylight"}
AFTER_CHARGES = {"switch_converters", "judge_statements", "draw_figures", "write_page", "publish_run"}
CHARGES = {"charge_battery", "charge_ensemble", "switch_over_estimates", "charge_over_day"}


def test_a_second_run_has_nothing_to_do(project: Project) -> None:
    assert "Nothing to be done" in project.snakemake()


def test_an_edited_battery_value_charges_again_and_fits_no_panel(restored: Project) -> None:
    restored.edit("conf/battery/lead_acid_12v7ah.yaml", "heat_capacity_j_k: 2100", "heat_capacity_j_k: 2150")
    assert set(restored.planned()) == CHARGES | {"loss_over_estimates"} | AFTER_CHARGES


def test_an_edited_panel_value_fits_it_again(restored: Project) -> None:
    restored.edit("conf/panel/kc65t.yaml", "alpha_isc_a_per_k: 0.001596", "alpha_isc_a_per_k: 0.0016")
    assert set(restored.planned()) == SUPPLY | CHARGES | AFTER_CHARGES


def test_an_edited_knob_of_one_mode_leaves_the_others(restored: Project) -> None:
    planned = restored.planned("modes.cv_reflex.discharge_a=0.6")
    assert planned["charge_battery"] == 2, "the mode in both comparisons, in a job each"
    assert "fit_panel" not in planned


def test_an_edited_caption_draws_one_chunk(restored: Project) -> None:
    restored.edit("conf/report/solar_reflex.yaml", "title: Battery temperature", "title: Temperature of the battery")
    assert set(restored.planned()) == {"draw_figures", "write_page", "publish_run"}


def test_an_edited_helper_runs_its_dependents(restored: Project) -> None:
    path = restored.folder / "src/pipeline/converter/efficiency.py"
    path.write_text(path.read_text() + "\n\nANOTHER = 1\n")
    planned = restored.planned()
    assert {"power_supply", "charge_battery", *AFTER_CHARGES} <= set(planned)
    assert "fit_panel" not in planned
    assert "compile_engine" not in planned


def test_an_edited_drawing_draws_its_figure_alone(restored: Project) -> None:
    path = restored.folder / "src/pipeline/experiments/charges/figures/energy.py"
    path.write_text(path.read_text() + "\n\nANOTHER = 1\n")
    assert restored.planned() == Counter(draw_figures=1, write_page=1, publish_run=1)


def test_a_frequency_by_hand_searches_nothing(restored: Project) -> None:
    planned = restored.planned("modes.cv_reflex.frequency_hz=50")
    assert {"charge_battery", *AFTER_CHARGES} <= set(planned)
    assert {"tune_search", "search_frequency", "follow_logistic_map", "loss_over_frequency"}.isdisjoint(planned)


def test_an_edited_algorithm_searches_again(restored: Project) -> None:
    path = restored.folder / "src/pipeline/search/algorithms/sweep.py"
    path.write_text(path.read_text() + "\n\nANOTHER = 1\n")
    planned = restored.planned()
    assert {"search_frequency", "search_with_other_seeds", *CHARGES, *AFTER_CHARGES} == set(planned)


def test_an_edited_comment_runs_nothing(restored: Project) -> None:
    for file in ("converter/efficiency.py", "charge/simulate.py", "report/style.py"):
        path = restored.folder / "src/pipeline" / file
        path.write_text("# A remark.\n" + path.read_text())
    restored.edit("conf/load/master_system.yaml", "# The master system", "# It is the master system")
    assert restored.planned() == Counter()


def test_going_back_computes_nothing(restored: Project) -> None:
    file = "conf/battery/lead_acid_12v7ah.yaml"
    manifest = restored.folder / "results/solar_reflex/default/manifest.json"
    restored.edit(file, "resistance_k_w: 1.9}", "resistance_k_w: 1.8}")
    assert rules(restored.snakemake("all", "-p"))["charge_battery"] == 2, "three charges, shared out over two jobs"
    assert json.loads(manifest.read_text())["configuration"]["battery"]["thermal"]["resistance_k_w"] == 1.8
    restored.edit(file, "resistance_k_w: 1.8}", "resistance_k_w: 1.9}")
    assert rules(restored.snakemake("all", "-p")) == Counter(publish_run=1)
    assert json.loads(manifest.read_text())["configuration"]["battery"]["thermal"]["resistance_k_w"] == 1.9


def test_a_lost_artefact_is_made_again(restored: Project) -> None:
    manifest = json.loads((restored.folder / "results/solar_reflex/default/manifest.json").read_text())
    entry = next(entry for entry in manifest["artefacts"] if entry["step"] == "supply")
    store.remove(restored.folder / "results/store/supply" / entry["key"])
    assert restored.planned()["power_supply"] == 1
    restored.snakemake()
    assert restored.planned() == Counter()
