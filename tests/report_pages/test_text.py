"""Numbers, units and names as people write them."""

from __future__ import annotations

import pytest

from pipeline.report.pages import view
from pipeline.report.tables import ReportTable
from pipeline.report.text import column, label, number, prose, spelt


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
