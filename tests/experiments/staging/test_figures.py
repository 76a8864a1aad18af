"""The figures and tables of the staged charge, drawn from artefacts that its own steps made in small."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import StepPatch

from pipeline.experiments.staging.page import tables
from pipeline.report import style
from pipeline.report.records import FigureCard
from pipeline.report.tables import ReportData, report_data, to_csv
from tests.experiments.looking import faults_of_words, shows_published
from tests.experiments.staging.staging_world import SEARCHED, make, nodes, small
from tests.making import inputs

UNIT = re.compile(r"\[(A|V|K|s|h|min|%|°C|mΩ|mV/K)\]")
COUNTED = {"Stage", "Charges computed", "Objective above the best there is, as a share of it"}
"""What has no unit: numbers and ratios."""
DIAGRAMS = {"thevenin", "control_loop"}
CARDS = {
    node.label: node
    for node in nodes()
    if node.step == "figures" and "functions" not in FigureCard.model_validate(node.settings["card"]).reads()
}


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("world")
    make(folder, (*SEARCHED, "charge"))
    return folder


def card_of(name: str) -> FigureCard:
    return FigureCard.model_validate(CARDS[name].settings["card"])


def data_of(name: str, world: Path, only: tuple[str, ...] = ()) -> ReportData:
    folders = {of: world / of for of in CARDS[name].inputs if not only or of in only}
    return report_data(CARDS[name].settings, inputs(folders))


def drawn(name: str, data: ReportData):
    with style.active():
        found = card_of(name).drawing().draw(card_of(name), data)
        found.draw_without_rendering()
    return found


def texts(found) -> str:
    return "\n".join(text.get_text() for axes in found.get_axes() for text in axes.texts)


@pytest.mark.parametrize("name", CARDS)
def test_every_figure_draws_with_units_on_its_axes(name, world):
    found = drawn(name, data_of(name, world))
    with style.active():
        assert faults_of_words(found) == []
    assert shows_published(found) or not any(option.startswith("published") for option in card_of(name).options)
    fields = found.get_axes()
    if card_of(name).draw in DIAGRAMS:
        assert len(fields[0].texts) > 4
        return
    labels = {label for axes in fields for label in (axes.get_xlabel(), axes.get_ylabel())} - {""}
    assert labels
    for label in labels - COUNTED:
        assert UNIT.search(label), label


@pytest.mark.parametrize("name", ["figure_8_weights", "figure_1_equivalent_circuit"])
def test_a_figure_is_the_same_bytes_twice(name, world, tmp_path):
    made = []
    for folder in (tmp_path / "first", tmp_path / "second"):
        folder.mkdir()
        with style.active():
            style.save(card_of(name).drawing().draw(card_of(name), data_of(name, world)), folder, name)
        made.append([path.read_bytes() for path in sorted(folder.iterdir())])
    assert len(made[0]) == 2
    assert made[0] == made[1]


def test_the_circuit_carries_the_configured_values(world):
    found = texts(drawn("figure_1_equivalent_circuit", data_of("figure_1_equivalent_circuit", world)))
    resistance = small().battery.series_resistance_ohm
    low, high = (1e3 * resistance.scale * end(resistance.value) for end in (min, max))
    assert f"{low:.3g} to {high:.3g} mΩ" in found
    assert "τ = 30 s" in found


def test_the_loop_is_the_settings_of_the_search(world):
    found = texts(drawn("figure_4_control_loop", data_of("figure_4_control_loop", world)))
    assert "Ki = 0.05, leak = 0.9" in found
    assert "w = 1" in found
    assert "D: none" in found


def test_the_steps_drawn_are_the_currents(world):
    data = data_of("figure_8_weights", world)
    stages = data.table("staging", "currents")
    patches = [one for one in drawn("figure_8_weights", data).get_axes()[0].patches if isinstance(one, StepPatch)]
    wanted = [stages["current_a"][stages["case"] == name] for name in card_of("figure_8_weights").options["cases"]]
    assert len(patches) == len(wanted) == 4
    for patch, currents in zip(patches, wanted, strict=True):
        np.testing.assert_array_equal(patch.get_data().values, currents)


def test_the_temperature_drawn_ends_where_the_charge_does(world):
    data = data_of("figure_7_temperature", world)
    rise = drawn("figure_7_temperature", data).get_axes()[1]
    line = next(line for line in rise.lines if line.get_label() == "computed")
    numbers = data.quantities("charges", "staged_printed")
    assert line.get_xdata()[-1] == pytest.approx(numbers["end_time_s"])
    assert max(line.get_ydata()) == pytest.approx(numbers["peak_temperature_rise_k"], abs=0.01)


def test_the_printed_charge_lies_above_the_front(world):
    data = data_of("time_rise_front", world)
    front = data.table("front", "front")
    for reading in ("peak", "final"):
        rows = (front["method"] == "scan") & (front["rise"] == reading)
        at_printed = np.interp(data.numbers("staging")["printed_time_s"], front["time_s"][rows], front["rise_k"][rows])
        assert data.numbers("staging")[f"printed_{reading}_k"] > at_printed or rows.sum() < 8


@pytest.mark.parametrize("name", ["figure_3_cc_cv", "figure_7_temperature"])
def test_a_charge_that_is_not_there_is_said_to_be_missing(name, world):
    found = drawn(name, data_of(name, world, only=("charge/charges/staged_found",)))
    assert "is not charged in this run" in texts(found)


def test_a_search_that_is_no_cuckoo_search_is_said_to_be_none(world):
    data = data_of("figure_4_control_loop", world)
    other = ReportData(data.inputs, data.modes, data.comparisons, {"stage_search": {"kind": "swarm"}})
    assert "no cuckoo search" in texts(drawn("figure_4_control_loop", other))


def test_the_tables_are_the_artefacts(world):
    data = ReportData(inputs({of: world / of for of in ("staging", "front")}), {}, {})
    shown = {table.name: table for table in tables(data)}
    assert set(shown) == {"table_3", "stage_cases", "stage_searches", "calibrations", "calibration_rises"}
    numbers = data.numbers("staging")
    printed = next(row for row in shown["stage_cases"].rows if row[0] == "printed")
    assert printed[1] == pytest.approx(numbers["printed_time_s"])
    assert printed[-1] == pytest.approx(0.0)
    best = next(row for row in shown["stage_cases"].rows if row[0] == "best, same highest rise")
    assert best[-1] == pytest.approx(-100.0 * numbers["same_peak_share"])
    assert {row[0] for row in shown["table_3"].rows} == {"5:5", "3:7", "7:3"}
    assert [row[0] for row in shown["stage_searches"].rows] == ["plain", "integral", "swarm"]
    for table in shown.values():
        assert all(len(row) == len(table.header) for row in table.rows)
        assert to_csv(table).count("\n") == len(table.rows) + 1


def test_a_run_without_stages_has_none_of_the_tables():
    assert tables(ReportData(inputs({}), {}, {})) == []
