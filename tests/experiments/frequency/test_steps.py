"""The steps that find values: what they write is what was declared, twice the same, and what others can read."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.experiments.frequency import chaos, objective, page, search, tuning
from pipeline.experiments.frequency.choices import pulsed_modes
from pipeline.experiments.frequency.declaration import EXPERIMENT
from pipeline.kernel import registry, store
from pipeline.kernel.draft import drafts
from pipeline.kernel.run import resolve
from pipeline.report.tables import ReportData
from tests import making

STEPS = {"chaos": chaos, "objective": objective, "tuning": tuning, "search": search}
SMALL = (
    "chaos.r_low=3.9",
    "chaos.r_points=26",
    "chaos.disorder_steps=20000",
    "chaos.bins=[10,20,100]",
    "design.replicates=4",
    "design.factorial_replicates=4",
    "search.replicates=12",
)


def made(folder: Path, words: Iterable[str] = SMALL) -> dict[str, Path]:
    nodes = {node.name: node for node in drafts(study_from(compose_tree(tuple(words))))}
    found: dict[str, Path] = {}
    for name, step in STEPS.items():
        if name in nodes:
            output = making.output(name, folder / name)
            step.run(resolve(nodes[name].settings, found), making.inputs(found), output)
            found[name] = folder / name
    return found


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    return made(tmp_path_factory.mktemp("once"))


@pytest.fixture(scope="module")
def data(outputs):
    return ReportData(making.inputs(outputs), {}, {})


def test_every_file_is_a_declared_table(outputs):
    for name, folder in outputs.items():
        for path in folder.glob("*.parquet"):
            table = path.name.removesuffix(".parquet").replace(".", "_")
            declared = making.inputs(outputs).declared(name, table)
            assert declared is not None, path
            assert declared.file == path.name
            assert len(next(iter(making.inputs(outputs).table(name, table).values()))) > 0, path


def test_the_view_shows_every_table(outputs):
    for node in drafts(study_from(compose_tree(SMALL))):
        if node.name in outputs:
            assert set(node.shown) == {path.name for path in outputs[node.name].glob("*.parquet")}


def test_the_named_numbers_are_those_that_statements_may_name(outputs, data):
    study = study_from(compose_tree(SMALL))
    fields = {**EXPERIMENT.fields(study)}
    fields["objective"] = {
        "mode": pulsed_modes(study, study.modes)
    }  # statements may name modes that this run leaves out
    known = {name: registry.steps()[name].quantities.names(fields[name]) for name in STEPS}
    for name in outputs:
        found = data.table(name, "quantities")["quantity"].tolist()
        assert len(set(found)) == len(found)
        if name != "search":
            assert set(found) == known[name], name
            continue
        # Searches of other numbers of replicates are not compared.
        missing = known[name] - set(found)
        assert set(found) <= known[name]
        assert all(word.startswith(("iterations_swarm_over_", "distance_swarm_over_")) for word in missing)
        assert all("published_protocol" in word or "sweep" in word for word in missing)


def test_twice_the_same_bytes(outputs, tmp_path):
    again = made(tmp_path)
    for name, folder in outputs.items():
        files = sorted(path.name for path in folder.iterdir())
        assert files == sorted(path.name for path in again[name].iterdir())
        for file in files:
            assert (folder / file).read_bytes() == (again[name] / file).read_bytes(), file


def test_another_seed_searches_otherwise(outputs, tmp_path):
    other = made(tmp_path, (*SMALL, "seed=1"))
    same = (outputs["search"] / "swarm.best.parquet").read_bytes() == (
        other["search"] / "swarm.best.parquet"
    ).read_bytes()
    assert not same


def test_the_search_finds_the_stationary_point_with_the_tuned_constants(outputs, data):
    best = data.numbers("objective")["optimal_frequency_hz"]
    found = data.numbers("search")
    assert store.found_value(outputs["search"], "frequency_hz") == found["frequency_hz"]
    assert found["frequency_hz"] == pytest.approx(best, abs=0.05)
    assert found["sweep_frequency_hz"] == pytest.approx(best, abs=1e-3)
    chosen = {name: store.found_value(outputs["tuning"], name) for name in ("c1", "c2", "w")}
    numbers = data.numbers("tuning")
    assert chosen == {name: numbers[f"rerun_chosen_{name}"] for name in chosen}


def test_the_published_design_is_that_of_the_paper(data):
    numbers = data.numbers("tuning")
    assert [numbers[f"published_chosen_{name}"] for name in ("c1", "c2", "w")] == [1.0, 1.0, 0.75]
    assert (numbers["published_chosen_rank"], numbers["published_best_run"]) == (8, 3)
    assert numbers["published_p_c1"] == pytest.approx(0.60, abs=0.005)
    shown = {table.name: table for table in page.tables(data)}
    for row in shown["table_3"].rows:
        assert row[3] == pytest.approx(row[2], abs=5e-5)
    assert len(shown["table_3"].rows) == 12
    assert [row[4] for row in shown["table_2"].rows][5] == 14.2958


def test_runs_of_the_protocol_are_the_first_of_the_published_constants(data):
    five = data.table("search", "published_protocol_history")
    many = data.table("search", "swarm_published_history")
    first = many["replicate"] < 5
    np.testing.assert_array_equal(five["position"], many["position"][first])


def test_a_battery_without_pairs_has_no_best_frequency(tmp_path):
    voltages = [f"modes.{mode}.voltage_v=3.4" for mode in ("cc_cv", "cv_pulse", "cv_reflex")]
    words = (*SMALL, "battery=nicd_2s_600mah", "~battery@second_battery", *voltages)
    found = ReportData(making.inputs(made(tmp_path, words)), {}, {})
    assert "optimal_frequency_hz" not in found.numbers("objective")
    assert len(found.table("objective", "map")["capacitance_f"]) == 0
    assert found.numbers("search")["frequency_hz"] == 1.0


def test_the_map_holds_the_configured_point_and_its_contour(data):
    grid = data.table("objective", "map")
    middle = len(grid["capacitance_f"]) // 2
    assert grid["capacitance_f"][middle] == pytest.approx(0.4)
    assert grid["optimal_frequency_hz"][middle] == pytest.approx(data.numbers("objective")["optimal_frequency_hz"])
    contour = data.table("objective", "contour")
    at = int(np.argmin(np.abs(contour["capacitance_f"] - 0.4)))
    assert contour["switching_energy_j"][at] == pytest.approx(data.numbers("objective")["switching_energy_j"], rel=1e-3)


def test_the_loss_is_least_at_the_optimum(data):
    loss = data.table("objective", "loss")
    np.testing.assert_allclose(loss["total_w"], loss["pair_ripple_w"] + loss["series_ripple_w"] + loss["switching_w"])
    numbers = data.numbers("objective")
    inside = loss["share_over_minimum"] <= 0.01
    low, high = loss["frequency_hz"][inside][[0, -1]]
    assert numbers["band_low_hz"] <= low < numbers["optimal_frequency_hz"] < high <= numbers["band_high_hz"]
    assert loss["share_over_minimum"].min() >= 0.0


def test_disorder_is_largest_at_4_by_one_measure_alone(data):
    numbers = data.numbers("chaos")
    assert numbers["most_unstable_r"] == 4.0
    assert numbers["lyapunov_at_4_nats"] == pytest.approx(np.log(2.0), abs=1e-3)
    assert numbers["most_disordered_r_100_bins"] < 4.0
    assert numbers["distance_to_arcsine"] < 0.02 < 0.1 < numbers["distance_to_uniform"]
