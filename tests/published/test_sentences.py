"""The sentence behind a verdict: what all values are is said once, units come from the values' names."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from pydantic import TypeAdapter

from pipeline.published.artefacts import Lookup
from pipeline.published.operands import Value
from pipeline.published.predicates import apply
from pipeline.published.records import Check
from pipeline.published.wording import compared, stated

CC, REFLEX = "charge/same_peak/cc_cv", "charge/same_peak/cv_reflex"
CHECK: TypeAdapter[Any] = TypeAdapter(Check)
POWER = "max_power_w of panel where irradiance_w_m2=1000"


@pytest.mark.parametrize(
    ("check", "sentence"),
    [
        (
            {"less": {"value": f"rise_k of {REFLEX}", "than": f"rise_k of {CC}"}},
            "rise: cv_reflex (same peak) 4 K, cc_cv (same peak) 5 K; the first is asked to be below the second",
        ),
        (
            {"greater": {"value": f"rise_k of {CC}", "than": 4.5, "by": 0.25}},
            "rise of cc_cv (same peak) 5 K; asked to be above 4.5 by 0.25",
        ),
        (
            {"smallest": {"value": f"end_s of {CC}", "among": [f"end_s of {REFLEX}"]}},
            "end: cc_cv (same peak) 7200 s, cv_reflex (same peak) 8000 s; the first is asked to be the smallest",
        ),
        (
            {"close": {"value": POWER, "to": "p_max_w of reference/solar_table1", "tolerance": 0.5}},
            "max power of panel 65.25 W; asked to be within 0.5 W of printed 65 W",
        ),
        (
            {"close": {"value": {"ratio": [f"end_s of {REFLEX}", f"end_s of {CC}"]}, "to": 1, "tolerance": 0.2}},
            "end of cv_reflex (same peak) / end of cc_cv (same peak) 1.1111; asked to be within 0.2 of 1",
        ),
        (
            {"greater": {"value": POWER, "than": {"product": [21, 12]}}},
            "max power of panel 65.25 W; asked to be above 21 x 12 = 252",
        ),
        (
            {"within": {"value": f"rise_k of {CC}", "low": 4, "high": 6}},
            "rise of cc_cv (same peak) 5 K; asked to lie in 4 to 6",
        ),
    ],
)
def test_sentence(check: dict[str, Any], sentence: str, lookup: Callable[..., Lookup]) -> None:
    reader = lookup({CC: {"rise_k": 5.0, "end_s": 7200.0}, REFLEX: {"rise_k": 4.0, "end_s": 8000.0}})
    assert apply(CHECK.validate_python(check), reader, "1").sentence == sentence


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("frequency_hz", "frequency of search 4 Hz"),
        ("ise_mw2_s", "ise of search 4 mW2 s"),
        ("published_p_w", "published p w of search 4"),
        ("published_chosen_w", "published chosen w of search 4"),
        ("discharge_resistor_w", "discharge resistor of search 4 W"),
    ],
)
def test_a_names_unit(name: str, words: str) -> None:
    assert stated(Value(quantity=name, artefact="search", table="quantities"), 4.0, "1") == words


def test_rows_of_one_table_are_told_apart_by_their_columns() -> None:
    rows = [{"factor": "c1", "level": level} for level in (1.0, 2.0)]
    values = [Value(quantity="mean", artefact="tuning", table="rerun_levels", where=row) for row in rows]
    assert compared(values, [6.0, 7.0], "1") == "mean: level 1 6, level 2 7"
