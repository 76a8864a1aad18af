"""Every predicate, its margin, and what it does about values that are not there."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import pytest
from pydantic import TypeAdapter

from pipeline.errors import UserError
from pipeline.published.artefacts import Lookup, Unanswerable
from pipeline.published.operands import Operand, Value, values
from pipeline.published.predicates import Outcome, apply, number
from pipeline.published.records import Check

CC, REFLEX, PULSE = "charge/p/cc_cv", "charge/p/cv_reflex", "charge/p/cv_pulse"
CHECK: TypeAdapter[Any] = TypeAdapter(Check)
OPERAND: TypeAdapter[Any] = TypeAdapter(Operand)


@pytest.fixture
def reader(lookup: Callable[..., Lookup]) -> Lookup:
    return lookup(
        {
            CC: {"rise_k": 5.0, "time_to_soc_0.95_s": 5000.0, "nothing": math.nan},
            REFLEX: {"rise_k": 4.0, "time_to_soc_0.95_s": math.nan, "nothing": math.nan},
            PULSE: {"rise_k": 4.5, "time_to_soc_0.95_s": 6000.0},
        }
    )


def outcome(check: dict[str, Any], reader: Lookup) -> Outcome:
    return apply(CHECK.validate_python(check), reader, "K")


def rise(charge: str) -> str:
    return f"rise_k of {charge}"


def time(charge: str) -> str:
    return f"time_to_soc_0.95_s of {charge}"


@pytest.mark.parametrize(
    ("check", "holds", "margin"),
    [
        ({"close": {"value": rise(CC), "to": 5.25, "tolerance": 0.5}}, True, 0.25),
        ({"close": {"value": rise(CC), "to": 4.5, "tolerance": 0.5}}, True, 0.0),
        ({"close": {"value": rise(CC), "to": 6.0, "tolerance": 0.5}}, False, -0.5),
        ({"close": {"value": rise(CC), "to": -4.0, "relative_tolerance": 0.5}}, False, -7.0),
        ({"close": {"value": rise(CC), "to": 4.0, "relative_tolerance": 0.5}}, True, 1.0),
        ({"less": {"value": rise(REFLEX), "than": rise(CC)}}, True, 1.0),
        ({"less": {"value": rise(REFLEX), "than": rise(CC), "by": 0.75}}, True, 0.25),
        ({"less": {"value": rise(REFLEX), "than": rise(CC), "by": 1.0}}, False, 0.0),
        ({"less": {"value": rise(CC), "than": rise(CC)}}, False, 0.0),
        ({"greater": {"value": rise(CC), "than": 4.5}}, True, 0.5),
        ({"greater": {"value": rise(CC), "than": 4.5, "by": 1.5}}, False, -1.0),
        ({"smallest": {"value": rise(REFLEX), "among": [rise(CC), rise(PULSE)]}}, True, 0.5),
        ({"smallest": {"value": rise(PULSE), "among": [rise(CC), rise(REFLEX)]}}, False, -0.5),
        ({"largest": {"value": rise(CC), "among": [rise(REFLEX), rise(PULSE)], "by": 0.25}}, True, 0.25),
        ({"largest": {"value": rise(PULSE), "among": [rise(REFLEX), rise(CC)]}}, False, -0.5),
        ({"within": {"value": rise(CC), "low": 4.0, "high": 5.5}}, True, 0.5),
        ({"within": {"value": rise(CC), "low": 5.0, "high": 6.0}}, True, 0.0),
        ({"within": {"value": rise(CC), "low": 6.0, "high": 7.0}}, False, -1.0),
    ],
)
def test_holds_with_exact_margin(check: dict[str, Any], holds: bool, margin: float, reader: Lookup) -> None:
    found = outcome(check, reader)
    assert (found.holds, found.margin) == (holds, margin)


def test_all_takes_the_part_that_is_nearest_to_failing(reader: Lookup) -> None:
    near = {"close": {"value": rise(CC), "to": 5.25, "tolerance": 0.5}}
    far = {"less": {"value": rise(REFLEX), "than": 40}}
    broken = {"greater": {"value": rise(REFLEX), "than": 8}}
    found = outcome({"all": [far, near]}, reader)
    assert (found.holds, found.margin) == (True, 0.5)
    found = outcome({"all": [far, near, broken]}, reader)
    assert (found.holds, found.margin) == (False, -0.5)


def test_a_mark_never_reached_is_later_than_any_time(reader: Lookup) -> None:
    found = outcome({"smallest": {"value": time(CC), "among": [time(PULSE), time(REFLEX)]}}, reader)
    assert (found.holds, found.margin) == (True, 1000.0)
    found = outcome({"less": {"value": time(REFLEX), "than": time(CC)}}, reader)
    assert (found.holds, found.margin) == (False, -math.inf)
    found = outcome({"close": {"value": {"ratio": [time(REFLEX), time(CC)]}, "to": 1, "tolerance": 0.1}}, reader)
    assert not found.holds


@pytest.mark.parametrize(
    "check",
    [
        {"less": {"value": f"nothing of {CC}", "than": 1}},
        {"less": {"value": 1, "than": f"nothing of {CC}"}},
        {"less": {"value": time(REFLEX), "than": time(REFLEX)}},
        {"within": {"value": "rise_k of charge/p/left_out", "low": 0, "high": 1}},
        {"greater": {"value": {"ratio": [1, {"difference": [rise(CC), rise(CC)]}]}, "than": 0}},
        {"less": {"value": {"at_time": {"value": f"soc of {CC}.trace", "time": time(REFLEX)}}, "than": 1}},
        {"less": {"value": "max_power_w of panel where irradiance_w_m2=500", "than": 1}},
        {"less": {"value": "max_power_w of panel", "than": 1}},
        {"all": [{"less": {"value": 1, "than": 2}}, {"less": {"value": f"nothing of {CC}", "than": 1}}]},
    ],
)
def test_nothing_is_concluded_from_a_value_that_is_not_there(check: dict[str, Any], reader: Lookup) -> None:
    with pytest.raises(Unanswerable):
        outcome(check, reader)


@pytest.mark.parametrize(
    ("operand", "expected"),
    [
        (2, 2.0),
        ({"difference": [rise(CC), 1.5]}, 3.5),
        ({"ratio": [rise(CC), rise(REFLEX)]}, 1.25),
        ({"product": [rise(CC), rise(REFLEX), 2]}, 40.0),
        ({"product": [{"difference": [rise(CC), 1]}, {"ratio": [1, 2]}]}, 2.0),
        ({"total": "max_power_w of panel"}, 77.25),
        ({"total": "p_max_w of reference/solar_table1 where v_mp_v=17.4"}, 65.0),
        ({"at_time": {"value": f"soc of {CC}.trace", "time": 5050}}, 0.99 * 0.505),
        ({"at_time": {"value": f"soc of {CC}.trace", "time": 1e6}}, 0.99),
        (f"end_s of {CC}.phases where phase=bulk", 3600.0),
        ("max_power_w of panel where irradiance_w_m2=200 and cell_temperature_c=25", 12.0),
    ],
)
def test_operands(operand: Any, expected: float, reader: Lookup) -> None:
    assert number(OPERAND.validate_python(operand), reader) == pytest.approx(expected, rel=1e-14)


def test_every_value_of_a_nested_operand_is_found() -> None:
    nested = {
        "product": [{"ratio": [rise(CC), 2]}, {"at_time": {"value": f"soc of {REFLEX}.trace", "time": time(PULSE)}}]
    }
    found = values(OPERAND.validate_python(nested))
    assert {value.artefact for value in found} == {CC, REFLEX, PULSE}


def test_the_compact_form_reads_back_what_it_writes() -> None:
    text = "end_s of charge/p/cc_cv.phases where phase=bulk and start_s=0"
    value = OPERAND.validate_python(text)
    assert value == Value(
        quantity="end_s", artefact="charge/p/cc_cv", table="phases", where={"phase": "bulk", "start_s": 0.0}
    )
    assert str(value) == text
    assert OPERAND.validate_python(value.model_dump()) == value


@pytest.mark.parametrize("operand", ["rise_k", "rise_k of", "a of b where c", True, {"quotient": [1, 2]}, [1, 2], None])
def test_what_is_no_operand_is_refused(operand: Any) -> None:
    with pytest.raises(ValueError, match=r"must be a number|is not a value|does not choose a row"):
        OPERAND.validate_python(operand)


@pytest.mark.parametrize(
    ("check", "message"),
    [
        ({"closer": {}}, "must be one of close"),
        ({"close": {"value": 1, "to": 2}}, "exactly one of tolerance"),
        ({"close": {"value": 1, "to": 2, "tolerance": 1, "relative_tolerance": 1}}, "exactly one of tolerance"),
        ({"within": {"value": 1, "low": 2, "high": 2}}, "low 2 must be below high 2"),
        ({"less": {"value": 1, "than": 2, "bye": 1}}, "Extra inputs"),
        ({"less": {"value": 1, "than": 2}, "greater": {"value": 1, "than": 2}}, "Extra inputs"),
        ({"all": []}, "at least 1 item"),
    ],
)
def test_what_is_no_predicate_is_refused(check: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        CHECK.validate_python(check)


def test_a_named_number_that_this_run_left_out_concludes_nothing(reader: Lookup) -> None:
    """Whether any run could have it is checked when planned, against the vocabulary of the step."""
    with pytest.raises(Unanswerable, match=r"rize_k of charge/p/cc_cv\.summary is not part of this run"):
        outcome({"less": {"value": f"rize_k of {CC}", "than": 1}}, reader)


def test_an_unknown_column_names_the_best_match(reader: Lookup) -> None:
    with pytest.raises(UserError, match="max_power_w"):
        outcome({"less": {"value": "max_powr_w of panel where irradiance_w_m2=200", "than": 1}}, reader)


def test_an_empty_number_that_is_no_time_is_no_answer(reader: Lookup) -> None:
    with pytest.raises(Unanswerable, match="is empty"):
        number(OPERAND.validate_python(f"nothing of {CC}"), reader)
    assert number(OPERAND.validate_python(time(REFLEX)), reader) == math.inf


@pytest.mark.parametrize(
    ("operand", "unit"),
    [
        (time(CC), "s"),
        (f"nothing of {CC}", "1"),
        (f"rize_k of {CC}", None),
        (f"soc of {CC}.trace", "1"),
        ("max_power_w of panel where irradiance_w_m2=200", "W"),
        ("rise_k of charge/p/left_out", None),
        ("p_max_w of reference/solar_table1", None),
    ],
)
def test_units_are_those_that_the_tables_declare(operand: str, unit: str | None, reader: Lookup) -> None:
    assert reader.unit(OPERAND.validate_python(operand)) == unit
