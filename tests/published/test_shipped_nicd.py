"""The shipped statements on the nickel-cadmium charger: every name exists, every verdict can come out both ways."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.kernel import tables
from pipeline.published.artefacts import Lookup
from pipeline.published.evaluate import VERDICTS, evaluate
from pipeline.published.records import Statement, needs, read_values
from tests import making
from tests.published.conftest import CONF, FALSE, write_quantities, write_summary

SHIPPED = {
    name: Statement.model_validate(entry)
    for name, entry in yaml.safe_load((CONF / "nicd_grnn.yaml").read_text(encoding="utf-8")).items()
}
REFERENCES = ("nicd_table2", "nicd_table3", "nicd_stops", "nicd_figure6")
# What answers every statement as the paper says, and what answers none so.
NUMBERS: dict[str, dict[str, tuple[float, float]]] = {
    "surface": {"learnt_consistent": (1.0, 0.0), "plateau_ramp_variance": (6.5, 6.5)},
    "network": {
        "units_of_all_data": (1123.0, 1121.0),
        "units": (13.0, 15.0),
        "nodes_of_anfis": (27.0, 21.0),
        "genetic_mse": (0.0046, 0.5),
        "crossover": (0.8, 0.5),
        "mutation": (0.1, 0.1),
        "population": (20.0, 20.0),
        "genetic_evaluations": (500.0, 6000.0),
        "greedy_evaluations": (5600.0, 5600.0),
        "genetic_mse_median": (0.0046, 0.5),
        "genetic_mse_median_long": (0.0045, 0.3),
        "genetic_population_mean": (0.5, 0.6),
        "anfis_mse": (0.13, 0.01),
        "least_squares_mse": (0.09, 0.01),
        **{
            f"{name}_mse_median": (1.0, 0.1)
            for name in ("exchange", "random", "random_best", "regular", "medoids", "greedy")
        },
        "least_squares_mse_median": (0.09, 0.01),
        "uncovered_share": (0.4, 0.0),
    },
    "network_size": {"size_6_mse_median": (0.005, 2.0), "size_20_mse_median": (0.001, 0.001)},
    "trade_off": {
        "constant_4c_ended_by_voltage_drop_s": (1390.0, 1500.0),
        "constant_4c_ended_by_temperature_rate_s": (1380.0, 1500.0),
        "constant_8c_ended_by_voltage_drop_s": (410.0, 500.0),
        "constant_8c_ended_by_temperature_rate_s": (400.0, 500.0),
        "network_time_to_full_paper_s": (400.0, 500.0),
        "rival_time_to_full_paper_s": (450.0, 450.0),
        "network_peak_paper_c": (40.0, 50.0),
        "coolest_peak_paper_c": (45.0, 45.0),
    },
}
CHARGES: dict[str, dict[str, tuple[float, float]]] = {
    "charge/stopped/constant_4c": {"end_time_s": (1390.0, 1600.0), "time_to_soc_0.95_s": (900.0, 400.0)},
    "charge/stopped/constant_8c": {
        "end_time_s": (415.0, 500.0),
        "time_to_soc_0.95_s": (420.0, 800.0),
        "peak_temperature_c": (44.0, 41.0),
    },
    "charge/unstopped/constant_4c": {
        "peak_temperature_rate_k_s": (0.18, 0.002),
        "temperature_rise_at_soc_0.8_k": (2.0, 2.0),
        "time_to_soc_0.8_s": (700.0, 700.0),
    },
    "charge/unstopped/constant_8c": {"peak_temperature_rate_k_s": (0.37, 0.001)},
    "charge/stopped/grnn": {
        "end_soc": (0.99, 0.9),
        "time_to_soc_0.95_s": (420.0, 880.0),
        "time_to_soc_0.99_s": (100.0, 900.0),
        "peak_temperature_c": (42.0, 50.0),
    },
}
# Two statements of the paper's own numbers that exclude each other hold in different worlds.
REFERENCE_ROWS: dict[str, tuple[list[dict[str, Any]], list[dict[str, Any]]]] = {
    "nicd_table2": (
        [{"row": 4, "rate_c": 8.0}, {"row": 5, "rate_c": 5.0}],
        [{"row": 4, "rate_c": 8.0}, {"row": 5, "rate_c": 2.0}],
    ),
    "nicd_table3": (
        [
            {"network": "ANFIS", "layers": 6, "nodes": 27, "mse": 0.1321},
            {"network": "GRNN", "layers": 3, "nodes": 15, "mse": 0.0905},
            {"network": "GA-trained GRNN", "layers": 3, "nodes": 13, "mse": 0.0046},
        ],
        [
            {"network": "ANFIS", "layers": 5, "nodes": 12, "mse": 0.001},
            {"network": "GRNN", "layers": 3, "nodes": 13, "mse": 0.0905},
            {"network": "GA-trained GRNN", "layers": 3, "nodes": 13, "mse": 0.0046},
        ],
    ),
    "nicd_stops": (
        [{"c_rate": 4, "stop_s": 1000}, {"c_rate": 8, "stop_s": 480}],
        [{"c_rate": 4, "stop_s": 1400}, {"c_rate": 8, "stop_s": 300}],
    ),
    "nicd_figure6": ([{"best_mse": 0.0046, "mean_mse": 0.5}], [{"best_mse": 0.0043719, "mean_mse": 0.001}]),
}
# What needs the stops as printed to hold.
AS_PRINTED = {"stop_4c", "stopped_within_4c", "stop_8c", "overcharge_shows_4c", "overcharge_shows_8c"}


def world(folder: Path, place: int, printed: bool = False) -> Lookup:
    """Write the artefacts of a world: 0 as the paper says, 1 otherwise; the paper's own tables printed or made up."""
    folders: dict[str, Path] = {}
    for name, numbers in NUMBERS.items():
        folders[name] = folder / name
        write_quantities(name, folders[name], {key: pair[place] for key, pair in numbers.items()})
    for name, numbers in CHARGES.items():
        folders[name] = folder / name
        _write_charge(folders[name], {key: pair[place] for key, pair in numbers.items()})
    for name in REFERENCES:
        rows = REFERENCE_ROWS[name][place]
        lines = [",".join(rows[0]), *(",".join(str(value) for value in row.values()) for row in rows)]
        (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Lookup(making.inputs(folders), CONF / "reference" if printed else folder)


def _write_charge(folder: Path, numbers: dict[str, float]) -> None:
    """Write a charge whose current falls from 5 A to nothing in ten hundred seconds, from 99 % on its start."""
    write_summary(folder, numbers)
    output = making.output("charge", folder)
    time = np.linspace(10.0, 1000.0, 100)
    trace: dict[str, Any] = {name: np.zeros(100) for name in output.columns("trace")}
    trace |= {"Test Time / s": time, "Current / A": 5.0 * time / 1000.0, "Step Count / 1": np.ones(100, dtype=np.int64)}
    output.write("trace", trace)


@pytest.fixture(scope="module")
def verdicts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, str]]:
    """Return world -> statement -> verdict."""
    folder = tmp_path_factory.mktemp("worlds")
    worlds = {
        "as said": world(folder / "a", 0),
        "as said and printed": world(folder / "b", 0, printed=True),
        "otherwise": world(folder / "c", 1),
        "empty": Lookup(making.inputs({}), folder),
    }
    found = {}
    for name, artefacts in worlds.items():
        columns = evaluate(SHIPPED, artefacts)
        tables.to_arrow(VERDICTS, columns)
        found[name] = dict(zip(columns["statement"], columns["verdict"], strict=True))
    return found


@pytest.fixture(scope="module")
def study() -> Any:
    return study_from(compose_tree(["study=nicd_grnn"]))


@pytest.mark.parametrize("statement", SHIPPED)
def test_no_verdict_is_constant(statement: str, verdicts: dict[str, dict[str, str]]) -> None:
    if SHIPPED[statement].basis == "none":
        assert {found[statement] for found in verdicts.values()} == {"not checkable"}
        return
    holding = "as said and printed" if statement in AS_PRINTED else "as said"
    assert verdicts[holding][statement] == "holds"
    assert verdicts["otherwise"][statement] == FALSE[SHIPPED[statement].basis]
    assert verdicts["empty"][statement] == "not checkable"


@pytest.mark.parametrize(
    ("statement", "verdict", "computed"),
    [
        ("error_printed_twice", "contradicted", 0.0043719),
        ("charge_by_stop_4c", "contradicted", 4 * 1400 / 3600),
        ("charge_by_stop_8c", "holds", 8 * 415 / 3600),
        ("one_battery", "contradicted", 4 * 1400 / (8 * 415)),
        ("fewer_units_than_anfis", "holds", 13.0),
        ("fewer_units_than_grnn", "contradicted", 13.0),
        ("least_error_printed", "holds", 0.0046),
    ],
)
def test_what_the_paper_prints_of_itself(statement: str, verdict: str, computed: float, tmp_path: Path) -> None:
    """The shipped tables are read, not copies in the test."""
    reader = Lookup(making.inputs({}))
    columns = evaluate({statement: SHIPPED[statement]}, reader)
    assert (columns["verdict"], columns["computed_value"]) == ([verdict], [pytest.approx(computed, rel=1e-12)])


def test_every_name_exists_and_every_world_has_all_of_them(study: Any) -> None:
    """Composing the study checks the names; a world that lacks one would prove nothing."""
    assert list(study.published) == list(SHIPPED)
    known = {(name, quantity) for name, numbers in {**NUMBERS, **CHARGES}.items() for quantity in numbers}
    asked = {
        (value.artefact, value.quantity)
        for stated in SHIPPED.values()
        for value in read_values(stated)
        if value.table in ("quantities", "summary")
    }
    assert asked == known
    assert {name for stated in SHIPPED.values() for name in needs(stated)} == {
        *NUMBERS,
        *CHARGES,
        *(f"reference/{name}" for name in REFERENCES),
    }


def test_answers_that_rest_on_a_stand_in_say_so() -> None:
    for name, stated in SHIPPED.items():
        lost = {"genetic", "anfis", "least_squares", "plateau_ramp", "size"}
        rests = any(value.quantity.startswith(tuple(lost)) and "units" not in value.quantity and "mse" in value.quantity
                    for value in read_values(stated) if not value.artefact.startswith("reference/"))  # fmt: skip
        if rests:
            told = f"{stated.reading} {stated.conditions} {stated.missing}".lower()
            assert any(words in told for words in ("stand-in", "stands in", "stand in")), name


def test_there_are_enough_of_them() -> None:
    assert sum(stated.basis != "none" for stated in SHIPPED.values()) >= 15
