"""The steps of a charger's network: what they write is what was declared, twice the same, and what others can read."""

from __future__ import annotations

from importlib import import_module
from typing import Any, cast

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline.errors import UserError
from pipeline.experiments.network import EXPERIMENT, page, sources
from pipeline.experiments.network.numbers import fields
from pipeline.grnn.charger_network import ChargerNetwork
from pipeline.grnn.network import Network, make_network, predict_many, responses
from pipeline.kernel import registry, store, tables
from pipeline.report.tables import ReportData
from tests import making
from tests.experiments.network.artefacts import made, network_half, nodes, small_study


@pytest.fixture(scope="module")
def outputs():
    return network_half()


@pytest.fixture(scope="module")
def data(outputs):
    return ReportData(making.inputs(outputs), {}, {})


def as_written(data: ReportData, name: str) -> Network:
    """Return a network as the table of networks has it."""
    table = data.table("network", "networks")
    own = {key: values[table["network"] == name] for key, values in table.items()}

    def pair(temperature: str, gradient: str) -> list[float]:
        return [float(own[key][0]) for key in (temperature, gradient)]

    return make_network(
        np.column_stack([own["temperature_c"], own["gradient"]]),
        own["rate_c"],
        widths=pair("width_temperature", "width_gradient"),
        scales=pair("scale_temperature", "scale_gradient"),
        kernel=cast(Any, str(own["kernel"][0])),
        extension=float(own["extension"][0]),
        low=pair("lowest_temperature_c", "lowest_gradient"),
        high=pair("highest_temperature_c", "highest_gradient"),
        gradient_seconds=float(own["gradient_seconds"][0]),
    )


def test_every_file_is_a_declared_table(outputs):
    for name, folder in outputs.items():
        if name.startswith("ensemble/"):
            continue
        declared = {one.file: one.table for one in registry.steps()[name].tables.values()}
        assert {path.name for path in folder.glob("*.parquet")} == set(declared)
        for file, table in declared.items():
            tables.read(table, folder / file)


def test_every_number_has_a_declared_name(data):
    for step in EXPERIMENT.steps:
        if step.quantities is None:
            continue
        names = step.quantities.names(fields()[step.name])
        found = set(map(str, data.table(step.name, "quantities")["quantity"]))
        assert found <= names
        # Names for what the small study leaves out: other sizes.
        assert all(name.startswith("size_") for name in names - found)
        assert {name.split("_")[1] for name in found if name.startswith("size_")} <= {"2", "3", "4"}


def test_twice_the_same_bytes(outputs, tmp_path):
    again = made(tmp_path)
    for name, folder in outputs.items():
        for path in folder.iterdir():
            assert path.read_bytes() == (again[name] / path.name).read_bytes(), path.name


def test_a_network_is_read_as_it_was_written_and_as_it_is_found(outputs, data):
    one = as_written(data, "genetic")
    response = data.table("network", "response")
    answer = predict_many(one, response["temperature_c"], response["gradient"])
    np.testing.assert_array_equal(answer, response["network_c"])
    error = float(np.mean((answer - response["rate_c"]) ** 2))
    assert error == pytest.approx(data.numbers("network")["genetic_mse"], rel=1e-12)
    found = ChargerNetwork.model_validate(store.found_value(outputs["network"], "genetic")).compiled()
    np.testing.assert_array_equal(responses(found, one.centres), responses(one, one.centres))
    for name in EXPERIMENT.finds(small_study())["network"]:
        assert as_written(data, name).centre_count == 6
        assert ChargerNetwork.model_validate(store.found_value(outputs["network"], name)).compiled().centre_count == 6


def test_the_rows_of_a_network_are_those_of_the_data(data):
    table = data.table("network", "networks")
    learnt = sources.surfaces(data.inputs)[sources.LEARNT]
    rows = table["row"] - 1
    np.testing.assert_array_equal(np.column_stack([table["temperature_c"], table["gradient"]]), learnt.inputs[rows])
    np.testing.assert_array_equal(table["rate_c"], learnt.rate[rows])


def test_the_course_ends_in_the_numbers(data):
    course, found = data.table("network", "course"), data.numbers("network")
    used = course["generation"] == found["generations"]
    assert found["genetic_mse"] == np.min(course["best_mse"][used])
    assert found["genetic_evaluations"] == course["evaluations"][used][0]
    best = np.argmin(course["best_mse"][used])
    assert found["genetic_population_mean"] == course["mean_mse"][used][best]


def test_the_tables_show_what_is_printed_beside_what_was_found(data):
    shown = {table.name: table for table in page.tables(data)}
    assert [shown[name].paper for name in ("nicd_table_1", "nicd_table_2", "nicd_table_3")] == [
        "Table I", "Table II", "Table III",
    ]  # fmt: skip
    assert dict(shown["nicd_table_1"].rows)["crossover"] == 0.8
    printed = [row[2:5] for row in shown["nicd_table_2"].rows if row[0] == "printed"]
    assert printed[3] == (40, 0.5, 8)
    assert printed[5] == (50, None, None)
    nodes_and_units = {(row[0], row[2], row[5]) for row in shown["nicd_table_3"].rows}
    assert nodes_and_units == {("ANFIS", 27, 27), ("GRNN", 13, 13), ("GA-trained GRNN", 13, 13)}
    assert [row[:2] for row in shown["network_sizes"].rows] == [(2, 5), (3, 7), (4, 9)]
    assert len(shown["network_kernels"].rows) == 12


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_table_of_ones_own_is_learnt(tmp_path, ending):
    columns = {"temperature_c": [], "gradient": [], "rate_c": []}
    for temperature in range(0, 50, 5):
        for gradient in (0.0, 0.5):
            columns["temperature_c"].append(float(temperature))
            columns["gradient"].append(gradient)
            columns["rate_c"].append(4.0 if temperature < 30 else 1.0)
    path = tmp_path / f"own.{ending}"
    if ending == "csv":
        lines = [",".join(columns), *(",".join(map(str, row)) for row in zip(*columns.values(), strict=True))]
        path.write_text("\n".join(lines) + "\n")
    else:
        pq.write_table(pa.table(columns), path)
    words = [f"network.data.table={path}", "network.size=null", "network.kernels=null"]
    found = ReportData(making.inputs(made(tmp_path / "made", words)), {}, {})
    learnt = sources.surfaces(found.inputs)[sources.LEARNT]
    assert learnt.rate.tolist() == columns["rate_c"]
    assert set(found.table("network", "networks")["rate_c"]) <= {4.0, 1.0}
    numbers = found.numbers("surface")
    assert numbers["points"] == 20
    assert "learnt_consistent" not in numbers


def test_another_content_of_the_table_is_another_key(tmp_path):
    path = tmp_path / "own.csv"
    path.write_text("temperature_c,gradient,rate_c\n0,0,1\n10,0,2\n")
    few = [f"network.{key}" for key in ("form.centres=2", "size.smallest=1", "size.largest=2")]
    words = [f"network.data.table={path}", *few]
    before = nodes(words)["surface"]
    path.write_text("temperature_c,gradient,rate_c\n0,0,1\n10,0,3\n")
    assert nodes(words)["surface"].settings != before.settings
    with pytest.raises(UserError, match="changed since the run was planned"):
        import_module(registry.module("surface")).run(
            before.settings, making.inputs({}), making.output("surface", tmp_path / "late")
        )


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (
            "temperature_c,gradient,rate_c\n1,2,3\n4,five,6\n",
            r"line 3, column gradient: value 'five'; allowed is a number",
        ),
        (
            "temperature_c,gradient,rate_c\n1,2,3\n4,5,1e30\n",
            r"line 3, column rate_c: value '1e30'; .* from 0 to 100 C",
        ),
        ("temperature_c,gradient,rate_c\n1,2,3\n", "1 points; allowed are 2 or more"),
    ],
)
def test_a_mistake_in_ones_own_table_is_told_when_planned(tmp_path, content, message):
    path = tmp_path / "own.csv"
    path.write_text(content)
    with pytest.raises(UserError, match=rf"network\.data\.table: .*own\.csv: .*{message}|own\.csv: {message}"):
        nodes([f"network.data.table={path}"])


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("network.data.surface=plateau", r"network\.data\.surface"),
        ("network.form.kernel=gausian", r"network\.form\.kernel"),
        ("network.selection.long_generations=3", "long_generations is 3; allowed is 20 or more"),
        ("network.selection.methods=[greedy]", r"methods is \['greedy'\].*genetic must"),
        ("network.data.surfaces.plateau_ramp.temperatures_c=[40,39,50]", "must lie above the one before"),
        ("network.data.table=nowhere.csv", r"network\.data\.table: nowhere\.csv: no such file"),
    ],
)
def test_a_mistake_in_the_study_is_named(word, message):
    with pytest.raises(UserError, match=message):
        nodes([word])


def test_what_one_node_reads_does_not_change_the_keys_of_the_others():
    def settings(*words):
        return {name: node.settings for name, node in nodes(words).items()}

    before = settings()
    for word, changed in {
        "network.anfis.epochs=5": {"network"},
        "network.size.replicates=3": {"network_size"},
        "network.kernels.replicates=3": {"network_kernels"},
        "network.selection.replicates=4": {"network"},
        "network.selection.genetic.mutation=0.2": {"network", "network_size", "network_kernels"},
        "network.data.surface=sigmoid": {"surface"},
        "network.title=other": set(),
    }.items():
        after = settings(word)
        assert {name for name in before if before[name] != after[name]} == changed, word
