"""The statements of the LiFePO4 paper: each holds in a world as it is published, and is contradicted in another."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from pipeline.published.artefacts import Lookup
from pipeline.published.evaluate import evaluate
from pipeline.published.records import Statement, needs
from tests import making
from tests.published.conftest import CONF, FALSE, write_charge, write_quantities

# name -> value as published, value otherwise
STAGING = {
    "printed_time_s": (1534.0, 1700.0),
    "printed_largest_increase_a": (0.0, 1.2),
    "printed_rise_after_stage_3_k": (3.5, 2.5),
    "printed_rise_after_stage_6_k": (3.9, 3.3),
    "printed_rise_after_stage_7_k": (3.7, 3.4),
    "printed_rise_after_stage_8_k": (3.65, 3.5),
    "printed_peak_k": (4.0, 4.5),
    "printed_peak_v": (3.5, 3.7),
    "weights_5_5_printed_fitness": (1.9, 2.1),
    "weights_5_5_printed_value": (1.0, 0.4),
    "weights_5_5_best_value": (1.0, 0.3),
    "weights_5_5_agreeing_share": (0.2, 1.0),
    "constant_same_peak_s": (1700.0, 1600.0),
    "constant_same_final_s": (1700.0, 1600.0),
    "same_peak_s": (1500.0, 1600.0),
    "weights_3_7_time_s": (1700.0, 1200.0),
    "weights_5_5_time_s": (1534.0, 1201.0),
    "weights_7_3_time_s": (1200.0, 1202.0),
    "weights_3_7_peak_k": (3.0, 4.0),
    "weights_5_5_peak_k": (4.0, 3.0),
    "weights_7_3_peak_k": (6.0, 2.0),
    "weights_3_7_largest_increase_a": (0.0, 1.0),
    "weights_5_5_largest_increase_a": (0.0, 0.0),
    "weights_7_3_largest_increase_a": (0.0, 0.0),
    "time_integral_over_plain": (0.95, 1.0),
    "rise_integral_less_plain_k": (0.05, 0.05),
    "early_time_integral_over_plain": (0.945, 0.95),
    "early_rise_integral_less_plain_k": (-0.05, 0.3),
    "value_integral_over_plain_high": (0.1, 0.6),
    "plain_value_mean": (0.36, 0.35),
    "integral_value_mean": (0.35, 0.35),
    "integral_excess_worst": (1e-4, 1e-2),
}
FRONT = {
    "least_same_peak_share": (0.001, 0.11),
    "least_same_final_share": (0.001, 0.06),
    "peak_dominating_points": (0.0, 3.0),
}
FUNCTIONS = {
    "variant_generations": (5000.0, 5000.0),
    "variant_replicates": (30.0, 30.0),
    "functions": (7.0, 7.0),
    "kp_negative_share": (0.0, 0.5),
    "cuckoo_loop_error": (0.1, 0.0),
    "integral_inertia_loop_error": (0.0, 0.2),
    "integral_inertia_centred_perfect": (7.0, 4.0),
    "integral_inertia_shifted_perfect": (7.0, 0.0),
    "integral_inertia_centred_mean_success_share": (1.0, 0.8),
    "integral_inertia_shifted_mean_success_share": (1.0, 0.1),
    "integral_inertia_centred_generations_fewer": (7.0, 1.0),
    "integral_inertia_shifted_generations_fewer": (7.0, 0.0),
    "integral_shifted_speedup": (2.5, 1.1),
    "integral_shifted_mean_success_share": (0.9, 0.1),
    "cuckoo_shifted_mean_success_share": (0.2, 0.2),
}
CURRENTS = ((39.2, 36.6, 29.8, 14.3, 12.9, 11.8, 8.5, 9.7), (41.0, 36.6, 29.8, 15.3, 12.9, 11.8, 8.5, 39.7))
ENERGY_EFFICIENCY = (1.02, 0.97)
SOC_AT_LIMIT, END_SOC = (0.80, 0.98), 0.99
# Fitted to the statement, so that it cannot hold; and what cannot be true beside the others' numbers.
FITTED = ("temperature_rise", "simulated_rise_at_the_end")


@pytest.fixture(scope="module")
def statements() -> dict[str, Statement]:
    read = yaml.safe_load((CONF / "lfp_cuckoo.yaml").read_text(encoding="utf-8"))
    return {name: Statement.model_validate(data) for name, data in read.items()}


def world(folder: Path, which: int) -> Lookup:
    folders = {}
    for step, numbers in {"staging": STAGING, "front": FRONT, "functions": FUNCTIONS}.items():
        folders[step] = folder / step
        write_quantities(step, folders[step], {name: pair[which] for name, pair in numbers.items()})
    # SOC rises evenly to the end at ten thousand seconds.
    held = 10_000.0 * (1.0 - SOC_AT_LIMIT[which] / END_SOC)
    summaries = {
        "staged_printed": {"energy_efficiency": ENERGY_EFFICIENCY[which]},
        "cc_cv_5c": {"end_time_s": 10_000.0, "time_at_voltage_limit_s": held},
    }
    for mode, summary in summaries.items():
        folders[f"charge/charges/{mode}"] = folder / mode
        write_charge(folder / mode, summary, final_soc=END_SOC)
    stages = [
        ("printed", n, n / 10, (n + 1) / 10, current, 200.0, 3.0) for n, current in enumerate(CURRENTS[which], start=1)
    ]
    making.output("staging", folders["staging"]).rows("currents", stages)
    return Lookup(making.inputs(folders), folder)


def judged(statements: dict[str, Statement], reader: Lookup) -> dict[str, str]:
    columns = evaluate(statements, reader, FITTED)
    return dict(zip(columns["statement"], columns["verdict"], strict=True))


def test_each_statement_follows_from_the_artefacts_both_ways(statements, tmp_path):
    published, otherwise = (judged(statements, world(tmp_path / str(which), which)) for which in (0, 1))
    nothing = judged(statements, Lookup(making.inputs({}), tmp_path))
    for name, stated in statements.items():
        if stated.basis == "none":
            assert {published[name], otherwise[name], nothing[name]} == {"not checkable"}, name
            continue
        assert published[name] == ("calibrated" if name in FITTED else "holds"), name
        assert otherwise[name] == FALSE[stated.basis], name
        assert nothing[name] == "not checkable", name


def test_there_are_enough_of_them_and_they_read_what_the_study_makes(statements):
    assert len(statements) >= 20
    charges = {f"charge/charges/{mode}" for mode in ("staged_printed", "cc_cv_5c")}
    read = set().union(*(needs(stated) for stated in statements.values()))
    assert read == {"staging", "front", "functions"} | charges


def test_the_printed_currents_are_those_of_the_mode():
    mode = yaml.safe_load((CONF.parent / "modes" / "staged_printed.yaml").read_text(encoding="utf-8"))
    staged = mode["phases"]["stages"]["staged"]
    assert tuple(staged["currents_a"]) == CURRENTS[0]
    assert staged["soc_edges"] == [n / 10 for n in range(2, 10)]


def test_a_run_smaller_than_the_papers_says_so_and_shows_its_own_numbers(statements, tmp_path):
    """The size is the run's own: one generation or one run too few is too few."""
    asking = {name: stated for name, stated in statements.items() if stated.asks is not None}
    assert {"success_rate_100_percent", "integral_alone_solves_more"} <= set(asking)
    full = {name: pair[0] for name, pair in FUNCTIONS.items()}
    generations, runs = "variant generations", "variant replicates"
    for changed, told in (
        (
            {"variant_generations": 1000.0, "variant_replicates": 10.0},
            "1000 of the paper's 5000 variant generations, 10 of the paper's 30 variant replicates",
        ),
        ({"variant_replicates": 29.0}, f"29 of the paper's 30 {runs}"),
        ({"variant_generations": 4999.0}, f"4999 of the paper's 5000 {generations}"),
    ):
        folder = tmp_path / "-".join(changed)
        write_quantities("functions", folder, full | changed)
        columns = evaluate(asking, Lookup(making.inputs({"functions": folder}), tmp_path))
        assert set(columns["verdict"]) == {"not checkable"}
        assert all(found.startswith(f"Too small to tell: {told}. Ours: ") for found in columns["explanation"])
        assert None not in columns["computed_value"]


def test_the_shipped_sizes_are_the_configurations(statements):
    """`functions=full` is as large as the paper's experiment, and the study that runs with everything is not."""
    sizes = {}
    for name in ("quick", "full"):
        read = yaml.safe_load((CONF.parent / "functions" / f"{name}.yaml").read_text(encoding="utf-8"))["variants"]
        sizes[name] = (read["shared"]["generations"], read["replicates"])
    for stated in statements.values():
        if stated.asks is not None:
            assert stated.asks.paper == sizes["full"]
            assert sizes["quick"] < stated.asks.paper
