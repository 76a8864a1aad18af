"""The sentence behind a verdict: what all values are is said once, units are those that the tables declare."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from pipeline.published.artefacts import Lookup
from pipeline.published.operands import Value
from pipeline.published.predicates import apply
from pipeline.published.records import Check
from pipeline.published.wording import Wording, opened, plain
from pipeline.quantity import Quantity
from tests import making

PLAIN = str.maketrans("−⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "--0123456789")
CC, REFLEX = "charge/same_peak/cc_cv", "charge/same_peak/cv_reflex"
OTHER = "charge/same_mean/cc_cv"
CHECK: TypeAdapter[Any] = TypeAdapter(Check)
CALLED = {"cc_cv": "CC-CV", "cv_reflex": "CV-Reflex", "v_mp_v": "Vmp"}
POWER = "max_power_w of panel where irradiance_w_m2=1000"


@pytest.mark.parametrize(
    ("check", "sentence"),
    [
        (
            {"less": {"value": f"rise_k of {REFLEX}", "than": f"rise_k of {CC}"}},
            "rise (same peak): CV-Reflex 4 K, CC-CV 5 K; required: CV-Reflex < CC-CV",
        ),
        (
            {"less": {"value": f"rise_k of {REFLEX}", "than": f"rise_k of {OTHER}", "by": 0.5}},
            "rise: CV-Reflex (same peak) 4 K, CC-CV (same mean) 6 K; "
            "required: CV-Reflex (same peak) < CC-CV (same mean) by at least 0.5 K; found 2 K",
        ),
        (
            {"greater": {"value": f"rise_k of {CC}", "than": 4.5, "by": 0.25}},
            "rise of CC-CV (same peak): 5 K; required: > 4.75 K",
        ),
        (
            {"smallest": {"value": f"end_s of {CC}", "among": [f"end_s of {REFLEX}"]}},
            "end (same peak): CC-CV 7200 s, CV-Reflex 8000 s; required: CC-CV smallest",
        ),
        (
            {"close": {"value": POWER, "to": "p_max_w of reference/solar_table1", "tolerance": 0.5}},
            "max power (irradiance 1000 W/m²): 65.25 W; required: 65 ± 0.5 W, as printed",
        ),
        (
            {"close": {"value": {"ratio": [f"end_s of {REFLEX}", f"end_s of {CC}"]}, "to": 1, "tolerance": 0.2}},
            "end of CV-Reflex (same peak) / end of CC-CV (same peak): 1.111; required: 1 ± 0.2",
        ),
        (
            {"close": {"value": f"rise_k of {REFLEX}", "to": f"rise_k of {CC}", "tolerance": 2}},
            "rise (same peak): CV-Reflex 4 K, CC-CV 5 K; required: equal within 2 K; found 1 K apart",
        ),
        (
            {"greater": {"value": POWER, "than": {"product": [21, 12]}}},
            "max power (irradiance 1000 W/m²): 65.2 W; 21 × 12 = 252 W; required: the first larger",
        ),
        (
            {"within": {"value": f"rise_k of {CC}", "low": 4, "high": 6}},
            "rise of CC-CV (same peak): 5 K; required: 4 to 6 K",
        ),
        (
            {"less": {"value": "v_mp_v of reference/solar_table1", "than": "v_oc_v of reference/solar_table1"}},
            "printed Vmp: 17.4; printed v_oc_v: 21.7; required: the first smaller",
        ),
        (
            {
                "greater": {
                    "of": "time to the end",
                    "called": ["Reflex", "the plain charge"],
                    "value": f"end_s of {REFLEX}",
                    "than": f"end_s of {CC}",
                    "by": 1000,
                }
            },
            "time to the end: Reflex 8000 s, the plain charge 7200 s; "
            "required: Reflex > the plain charge by at least 1000 s; found 800 s",
        ),
        (
            {
                "all": [
                    {"greater": {"value": f"rise_k of {CC}", "than": 4}},
                    {
                        "less": {
                            "called": ["half of it"],
                            "value": {"product": [0.5, f"rise_k of {CC}"]},
                            "than": 2,
                        }
                    },
                ]
            },
            "Rise of CC-CV (same peak): 5 K; required: > 4 K. Half of it: 2.5; required: < 2",
        ),
        (
            {"all": [{"greater": {"value": POWER, "than": 65}}, {"less": {"value": POWER, "than": 66}}]},
            "Irradiance 1000 W/m². Max power: 65.25 W; required: > 65 W. Max power: 65.25 W; required: < 66 W",
        ),
    ],
)
def test_sentence(check: dict[str, Any], sentence: str, lookup: Callable[..., Lookup]) -> None:
    rises = {CC: {"rise_k": 5.0, "end_s": 7200.0}, REFLEX: {"rise_k": 4.0, "end_s": 8000.0}, OTHER: {"rise_k": 6.0}}
    assert apply(CHECK.validate_python(check), lookup(rises), "1", CALLED).sentence == sentence


@pytest.mark.parametrize(
    ("name", "unit", "words"),
    [
        ("frequency_hz", "Hz", "frequency: 4 Hz"),
        ("ise_mw2_s", "mW2 s", "ISE: 4 mW² s"),
        ("peak_temperature_rate_k_s", "K/s", "peak temperature rate: 4 K/s"),
        ("drift_v_per_k", "V/K", "drift: 4 V/K"),
        ("lowest_c", "degC", "lowest: 4 °C"),
        ("published_p_w", "1", "published p w: 4"),
        ("published_chosen_w", "1", "published chosen w: 4"),
        ("discharge_resistor_w", "W", "discharge resistor: 4 W"),
    ],
)
def test_a_names_ending_is_left_out_where_it_repeats_the_declared_unit(
    name: str, unit: str, words: str, tmp_path: Path
) -> None:
    making.output("search", tmp_path).numbers([Quantity(name, 4.0, unit, "")])
    told = Wording(Lookup(making.inputs({"search": tmp_path})), "1")
    assert told.compared([Value(quantity=name, artefact="search", table="quantities")], [4.0]) == words


def test_rows_of_one_table_are_told_apart_by_their_columns() -> None:
    rows = [{"factor": "c1", "level": level} for level in (1.0, 2.0)]
    values = [Value(quantity="mean", artefact="tuning", table="rerun_levels", where=row) for row in rows]
    told = Wording(Lookup(making.inputs({})), "1", {"c1": "C1"})
    assert told.compared(values, [6.0, 7.0]) == "mean (C1): 6 (level 1), 7 (level 2)"


@pytest.mark.parametrize(
    ("value", "unit", "apart", "told"),
    [
        (10165.3, "s", 449.8, "10165 s"),
        (5.12407, "K", 0.0, "5.12 K"),
        (5.12407, "K", 0.0087, "5.1241 K"),
        (-61.106, "s", 0.0, "−61.1 s"),
        (0.00356, "1", 0.0, "0.00356"),
        (2.7561e-06, "J", 1e-6, "2.76 µJ"),
        (2.1133e-05, "Hz", 0.0, "2.11 × 10⁻⁵ Hz"),
        (1e-9, "1", 0.0, "10⁻⁹"),
        (39.2, "A", 0.8, "39.2 A"),
        (-1e-30, "1", 0.0, "−10⁻³⁰"),
        (1.0, "1", 1e-9, "1"),
        (30.124, "degC", 0.0, "30.1 °C"),
        (math.inf, "s", 0.0, "never"),
        (-math.inf, "V", 0.0, "without bound"),
    ],
)
def test_a_number_has_the_digits_that_a_person_reads(value: float, unit: str, apart: float, told: str) -> None:
    assert plain(value, unit, apart) == told


@given(st.floats(-1e12, 1e12))
def test_what_is_told_is_the_number_to_half_a_percent(value: float) -> None:
    raised = re.fullmatch("(−?)(?:([0-9.]+) × )?10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)", plain(value))
    text = plain(value) if raised is None else f"{raised[1]}{raised[2] or 1}e{raised[3]}"
    text = text.translate(PLAIN)
    assert float(text) == pytest.approx(value, rel=0.005, abs=1e-300)


@pytest.mark.parametrize(
    ("text", "told"),
    [("dT/dt at 4C", "dT/dt at 4C"), ("p-value", "p-value"), ("SOC", "SOC"), ("a charge", "A charge"), ("", "")],
)
def test_a_symbol_keeps_its_letter_where_a_sentence_begins(text: str, told: str) -> None:
    assert opened(text) == told


def test_names_beside_a_predicate_are_as_many_as_its_values() -> None:
    with pytest.raises(ValidationError, match="called has 1 names for 2 values"):
        CHECK.validate_python({"less": {"called": ["one"], "value": f"rise_k of {CC}", "than": f"rise_k of {REFLEX}"}})
