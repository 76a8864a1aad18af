"""The figures of a charger's network show what the tables hold."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.kernel import registry
from pipeline.report import style
from pipeline.report.records import FigureCard
from pipeline.report.tables import ModeLabel, ReportData
from tests import making
from tests.experiments.looking import faults_of_words
from tests.experiments.network.artefacts import network_half


@pytest.fixture(scope="module")
def data():
    return ReportData(making.inputs(network_half()), {}, {})


def drawn(name: str, data: ReportData, **options: str):
    card = FigureCard(draw=name, title="title", caption="caption", options=options)
    with style.active():
        return card.drawing().draw(card, data)


@pytest.mark.parametrize("name", ["surface", "convergence", "selections", "size"])
def test_it_is_drawn_twice_the_same(data, tmp_path, name):
    made = []
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        with style.active():
            figure = drawn(f"network_{name}", data)
            made.append([path.read_bytes() for path in style.save(figure, tmp_path / folder, "one")])
    assert made[0] == made[1]
    with style.active():
        assert faults_of_words(figure) == []


def test_the_surface_shows_the_centres_and_where_the_network_errs(data):
    found = drawn("network_surface", data)
    networks, response = data.table("network", "networks"), data.table("network", "response")
    own = networks["network"] == "genetic"
    _, answer, miss = found.get_axes()[:3]
    for axes in (answer, miss):
        centres = axes.get_lines()[0]
        np.testing.assert_array_equal(centres.get_xdata(), networks["temperature_c"][own])
        np.testing.assert_array_equal(centres.get_ydata(), networks["gradient"][own])
    shown = np.asarray(miss.collections[0].get_array()).T.ravel()
    np.testing.assert_array_equal(shown, response["network_c"] - response["rate_c"])


def test_data_off_a_grid_are_no_surface(data, monkeypatch):
    response = {key: values[:-1] for key, values in data.table("network", "response").items()}
    tables = {"response": response, "networks": data.table("network", "networks")}
    monkeypatch.setattr(ReportData, "table", lambda self, source, name: tables[name])
    found = drawn("network_surface", data)
    assert "on no grid" in found.get_axes()[0].texts[0].get_text()


def test_the_course_drawn_is_that_of_the_best_run(data):
    found = drawn("network_convergence", data)
    course, numbers = data.table("network", "course"), data.numbers("network")
    line = next(line for line in found.get_axes()[0].get_lines() if line.get_label() == "best run: best")
    values = np.asarray(line.get_ydata())
    assert values[int(numbers["generations"])] == numbers["genetic_mse"]
    rows = [course["best_mse"][course["replicate"] == one] for one in np.unique(course["replicate"])]
    assert any(np.array_equal(values, one) for one in rows)
    assert f"best {numbers['genetic_mse']:.4g}" in found.get_axes()[0].get_title(loc="left")


def test_every_selection_is_a_dot_and_every_median_a_bar(data):
    found = drawn("network_selections", data)
    table, lines = data.table("network", "selections"), found.get_axes()[0].get_lines()
    dots = np.sort(np.concatenate([line.get_xdata() for line in lines if line.get_marker() == "o"]))
    np.testing.assert_array_equal(dots, np.sort(table["mse"]))
    bars = {float(np.asarray(line.get_xdata())[0]) for line in lines if line.get_marker() == "|"}
    assert data.numbers("network")["genetic_mse_median"] in bars


def test_the_sizes_drawn_are_the_tables(data):
    found = drawn("network_size", data)
    numbers = data.numbers("network_size")
    line = next(line for line in found.get_axes()[0].get_lines() if "median" in str(line.get_label()))
    assert line.get_ydata().tolist() == [numbers[f"size_{count}_mse_median"] for count in (2, 3, 4)]


@pytest.mark.parametrize(("words", "capacity"), [((), 0.6), (("+battery.scaled_to_capacity_ah=1.2",), 1.2)])
def test_the_charger_is_drawn_with_the_capacity_in_use(data, words, capacity):
    study = study_from(compose_tree(("study=nicd_grnn", *words)))
    settings = {"system": registry.labels()["system"].make(study)}
    shown = ReportData(data.inputs, {"grnn": ModeLabel("network")}, {}, settings)
    loop, source = (
        "\n".join(text.get_text() for text in drawn("charger", shown, part=part).get_axes()[0].texts)
        for part in ("loop", "current_source")
    )
    assert f"C-rate × {capacity:g} Ah" in loop
    networks = data.table("network", "networks")
    highest = float(networks["rate_c"][networks["network"] == "genetic"].max())
    assert f"up to {highest * capacity:g} A" in source
