"""The sentence behind a verdict: what all values are is said once, units are those that the tables declare."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from pydantic import TypeAdapter

from pipeline.published.artefacts import Lookup
from pipeline.published.operands import Value
from pipeline.published.predicates import apply
from pipeline.published.records import Check
from pipeline.published.wording import Wording
from pipeline.quantity import Quantity
from tests import making

CC, REFLEX = "charge/same_peak/cc_cv", "charge/same_peak/cv_reflex"
OTHER = "charge/same_mean/cc_cv"
CHECK: TypeAdapter[Any] = TypeAdapter(Check)
POWER = "max_power_w of panel where irradiance_w_m2=1000"


@pytest.mark.parametrize(
    ("check", "sentence"),
    [
        (
            {"less": {"value": f"rise_k of {REFLEX}", "than": f"rise_k of {CC}"}},
            "rise (same peak): cv_reflex 4 K, cc_cv 5 K; required: cv_reflex < cc_cv",
        ),
        (
            {"less": {"value": f"rise_k of {REFLEX}", "than": f"rise_k of {OTHER}", "by": 0.5}},
            "rise: cv_reflex (same peak) 4 K, cc_cv (same mean) 6 K; "
            "required: cv_reflex (same peak) < cc_cv (same mean) by at least 0.5 K; found 2 K",
        ),
        (
            {"greater": {"value": f"rise_k of {CC}", "than": 4.5, "by": 0.25}},
            "rise of cc_cv (same peak): 5 K; required: > 4.5 K by at least 0.25 K; found 0.5 K",
        ),
        (
            {"smallest": {"value": f"end_s of {CC}", "among": [f"end_s of {REFLEX}"]}},
            "end (same peak): cc_cv 7200 s, cv_reflex 8000 s; required: cc_cv smallest",
        ),
        (
            {"close": {"value": POWER, "to": "p_max_w of reference/solar_table1", "tolerance": 0.5}},
            "max power of panel, irradiance 1000 W/m2: 65.25 W; printed: 65 W; tolerance ±0.5 W",
        ),
        (
            {"close": {"value": {"ratio": [f"end_s of {REFLEX}", f"end_s of {CC}"]}, "to": 1, "tolerance": 0.2}},
            "end of cv_reflex (same peak) / end of cc_cv (same peak): 1.1111; required: 1, tolerance ±0.2",
        ),
        (
            {"close": {"value": f"rise_k of {REFLEX}", "to": f"rise_k of {CC}", "tolerance": 2}},
            "rise (same peak): cv_reflex 4 K, cc_cv 5 K; tolerance ±2 K",
        ),
        (
            {"greater": {"value": POWER, "than": {"product": [21, 12]}}},
            "max power of panel, irradiance 1000 W/m2: 65.25 W; 21 x 12 = 252 W; required: first > second",
        ),
        (
            {"within": {"value": f"rise_k of {CC}", "low": 4, "high": 6}},
            "rise of cc_cv (same peak): 5 K; required: 4 K to 6 K",
        ),
        (
            {"less": {"value": "v_mp_v of reference/solar_table1", "than": "v_oc_v of reference/solar_table1"}},
            "printed v_mp_v: 17.4; printed v_oc_v: 21.7; required: first < second",
        ),
    ],
)
def test_sentence(check: dict[str, Any], sentence: str, lookup: Callable[..., Lookup]) -> None:
    rises = {CC: {"rise_k": 5.0, "end_s": 7200.0}, REFLEX: {"rise_k": 4.0, "end_s": 8000.0}, OTHER: {"rise_k": 6.0}}
    assert apply(CHECK.validate_python(check), lookup(rises), "1").sentence == sentence


@pytest.mark.parametrize(
    ("name", "unit", "words"),
    [
        ("frequency_hz", "Hz", "frequency of search: 4 Hz"),
        ("ise_mw2_s", "mW2 s", "ISE of search: 4 mW2 s"),
        ("peak_temperature_rate_k_s", "K/s", "peak temperature rate of search: 4 K/s"),
        ("drift_v_per_k", "V/K", "drift of search: 4 V/K"),
        ("lowest_c", "degC", "lowest of search: 4 degC"),
        ("published_p_w", "1", "published p w of search: 4"),
        ("published_chosen_w", "1", "published chosen w of search: 4"),
        ("discharge_resistor_w", "W", "discharge resistor of search: 4 W"),
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
    told = Wording(Lookup(making.inputs({})), "1")
    assert told.compared(values, [6.0, 7.0]) == "mean: level 1 6, level 2 7"
