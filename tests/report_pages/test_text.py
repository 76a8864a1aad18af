"""Numbers, units and names as people write them."""

from __future__ import annotations

import shlex

import pytest

from pipeline.report.pages import view
from pipeline.report.tables import ReportTable
from pipeline.report.text import column, ended, label, number, prose, share, shell, spelt


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "–"),
        ("", "–"),
        (0.0, "0"),
        (-0.0, "0"),
        (-0.00012345678, "−0.0001235"),
        (123456.7, "123457"),
        (1.0, "1"),
        (9.9999, "10"),
        (3, "3"),
        (1.5e12, "1.5 × 10¹²"),
        (-2.2204e-14, "−2.22 × 10⁻¹⁴"),
        ("a-b", "a-b"),
    ],
)
def test_numbers_for_people(value: object, text: str) -> None:
    assert number(value) == text


def test_units_in_prose() -> None:
    assert prose("at 1000 W/m2 and 25 degC") == "at 1000 W/m² and 25 °C"


def test_decimal_points_of_a_column_stand_in_one_line() -> None:
    found = column([1.25, 10, 100.5, None, "never", 2.5e9])
    assert [one.text for one in found] == ["1.25", "10", "100.5", "–", "never", "2.5 × 10⁹"]
    assert [one.room for one in found] == ["", ".00", "0", ".00", "", ""]


def test_whole_numbers_need_no_room() -> None:
    assert [one.room for one in column([1, 20, 300])] == ["", "", ""]


def test_what_rounding_left_over_is_about_nothing() -> None:
    assert [one.text for one in column([100.0, 2.2204e-14, 0.0])] == ["100", "≈ 0", "0"]
    assert [one.text for one in column([1e-13, 2.2204e-14])] == ["1 × 10⁻¹³", "2.22 × 10⁻¹⁴"]


@pytest.mark.parametrize(
    ("name", "with_unit", "text"),
    [
        ("time_to_soc_0.8_s", False, "Time to SOC 0.8"),
        ("time_to_soc_0.8_s", True, "Time to SOC 0.8 [s]"),
        ("peak_temperature_rate_k_s", True, "Peak temperature rate [K/s]"),
        ("published_chosen_mw2_s", True, "Published chosen [mW² s]"),
        ("genetic_mse_median", True, "Genetic MSE median"),
        ("CC-CV", True, "CC-CV"),
        ("charge/same_peak/cc_cv", True, "charge/same_peak/cc_cv"),
        (None, True, "–"),
    ],
)
def test_names_of_quantities_become_words_with_their_units(name: str | None, with_unit: bool, text: str) -> None:
    assert label(name, with_unit) == text


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("energy of cv_pulse in mode same_peak.", "energy of CV pulse in mode same peak."),
        ("Printed 4 x (stop_s / 3600), c_rate 4", "Printed 4 × (stop / 3600), c rate 4"),
        ("Printed p_max_w: 65 W", "Printed p max: 65 W"),
        ("charge/same_peak/cc_cv", "charge/same_peak/cc_cv"),
        ("battery.heat_capacity_j_per_k", "battery.heat_capacity_j_per_k"),
        ("load=master_system", "load=master_system"),
    ],
)
def test_names_within_a_sentence_become_words_and_paths_stay(text: str, told: str) -> None:
    assert spelt(text) == told


def test_a_unit_stands_once_in_a_row() -> None:
    rows = (("peak_temperature_c", "degC", 49.5), ("end_soc", "1", 1.0))
    shown = view(ReportTable("t", "T", "", ("quantity", "unit", "CC-CV"), rows))
    assert [[cell.text for cell in row] for row in shown.groups[0][1]] == [
        ["Peak temperature", "°C", "49.5"],
        ["End SOC", "", "1"],
    ]


@pytest.mark.parametrize(
    ("reason", "told"),
    [
        ("stop: soc 0.99", "stop at SOC 99 %"),
        ("soc 0.9985", "SOC 99.85 %"),
        ("stop: elapsed 1000 s", "stop at time limit of 1000 s"),
        ("elapsed 3600 s", "3600 s over"),
        ("temperature 45 degC", "temperature of 45 °C"),
        ("stop: temperature rate 0.05 K/s", "stop at temperature rate of 0.05 K/s"),
        ("voltage below its peak by 0.02 V", "voltage 0.02 V below its peak"),
        ("current 1e-05 A", "current of 1e-05 A"),
        ("surplus below 1 W", "surplus below 1 W"),
        ("stop: the battery's own", "stop: the battery's own"),
    ],
)
def test_what_ended_a_charge_is_said_in_words(reason: str, told: str) -> None:
    assert ended(reason) == label(reason) == told


def test_what_ended_a_charge_is_said_in_words_among_numbers_too() -> None:
    assert [one.text for one in column(["stop: soc 0.99", 0.5])] == ["stop at SOC 99 %", "0.5"]


def test_names_of_the_energy_balance_are_words() -> None:
    assert label("pair slow") == "RC pair “slow”"
    assert label("pair_slow_store") == "RC pair “slow”, energy it keeps"
    assert label("series resistance") == "series resistance"


def test_a_column_with_a_name_begins_with_capitals_throughout() -> None:
    table = ReportTable("t", "T", "", ("quantity", "value"), (("mean_mse", 1.0), ("points", 2.0)))
    assert [row[0].text for _, rows in view(table).groups for row in rows] == ["Mean MSE", "Points"]
    table = ReportTable("t", "T", "", ("mode", "value"), (("plain rule", 1.0), ("network", 2.0)))
    assert [row[0].text for _, rows in view(table).groups for row in rows] == ["plain rule", "network"]


def test_signs_of_arithmetic_in_prose() -> None:
    assert prose("2 x 561 + 1 of L16(4^3), below 10^-6; A (1 - w) / (1 - w + Kp)") == (
        "2 × 561 + 1 of L16(4³), below 10⁻⁶; A (1 − w) / (1 − w + Kp)"
    )
    assert prose("a quick-start, x 2 and well-known - so") == "a quick-start, x 2 and well-known − so"
    assert share(-0.156) == "−16 %"
    assert spelt("share that c2 explains; level of w with the least sum; conf/search/c2.yaml, c1=2, w = 1") == (
        "share that C2 explains; level of W with the least sum; conf/search/c2.yaml, c1=2, w = 1"
    )


@pytest.mark.parametrize(
    "words",
    [
        ["snakemake", "--cores", "2", "solar_reflex"],
        [
            "snakemake",
            "--cores",
            "2",
            "results/" + 60 * "a",
            "results/" + 60 * "b",
            "--config",
            "overrides=study=x y=2",
        ],
        ["python", "-m", "pipeline", "compare-modes", "--battery", 40 * "a", "--modes", 40 * "b", "key='a b'"],
    ],
)
def test_a_long_command_stands_on_several_lines_of_one_command(words: list[str]) -> None:
    shown = shell(shlex.join(words))
    assert shlex.split(shown.replace("\\\n", " ")) == words
    assert all(len(line) <= 100 for line in shown.splitlines())
    assert ("\n" in shown) == (len(shlex.join(words)) > 88)
