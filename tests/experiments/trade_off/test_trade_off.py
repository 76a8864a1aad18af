"""Time against temperature: every row is the charge it says, and the numbers follow from the rows."""

import math

import pytest
from pydantic import ValidationError

from pipeline.charge.records import Mode
from pipeline.experiments.trade_off.records import TRADE_OFF_NUMBERS, TradeOff, fields
from pipeline.experiments.trade_off.summary import Row, behind, quantities, trade_off
from pipeline.kernel.tables import read
from tests import making
from tests.charge.samples import ENGINE, battery, charge, settings, values
from tests.charge.test_controller import NETWORK

NICKEL = battery("nicd_2s_600mah")
CHOSEN = {
    "c_rates": [2.0, 8.0],
    "stops": {"voltage_drop": {"voltage_drop_v": 0.02}, "temperature": {"temperature_c": 38.0}},
    "conditions": {
        "paper": {"title": "30 degC", "ambient_c": 30.0, "initial_soc": 0.02},
        "warm": {"title": "35 degC", "ambient_c": 35.0, "initial_soc": 0.5},
    },
    "sensors": {
        "steps": {"title": "steps", "sample_interval_s": 1.0, "temperature_step_k": 0.25},
        "filtered": {"title": "f", "sample_interval_s": 1.0, "temperature_step_k": 0.25, "rate_span_s": 30.0},
    },
    "candidate": "net",
    "rule": "rule",
}
STOP = {"elapsed_s": 900.0}
MODES = {
    "net": Mode(title="net", sample_interval_s=2.0, phases={"charge": {"controller": {"network": NETWORK}}}, stop=STOP),
    "rule": Mode(
        title="rule",
        sample_interval_s=2.0,
        fast_c_rate=8.0,
        trickle_c_rate=0.1,
        trip_rate_k_s=0.05,
        phases={"charge": {"rate_switch": {}}},
        stop=STOP,
    ),
    "constant": Mode(
        title="constant", phases={"charge": {"constant_current": {"current_a": 1.0}}}, stop={"elapsed_s": 10.0}
    ),
}


@pytest.fixture(scope="module")
def chosen():
    return TradeOff.model_validate(CHOSEN)


@pytest.fixture(scope="module")
def rows(chosen):
    return trade_off(NICKEL, MODES, settings(0.5, sample_interval_s=1.0), ENGINE, chosen)


def test_there_is_a_row_for_every_charge(rows):
    constants = [(row.c_rate, row.stop, row.condition) for row in rows if row.law == "constant_current"]
    stops = ("voltage_drop", "temperature", "timer")
    assert constants == [(rate, stop, of) for of in ("paper", "warm") for rate in (2.0, 8.0) for stop in stops]
    sampled = [(row.law, row.condition, row.sensor) for row in rows if row.law != "constant_current"]
    own = [(law, of, "own") for of in ("paper", "warm") for law in ("net", "rule")]
    assert sampled == own + [(law, "paper", of) for of in ("steps", "filtered") for law in ("net", "rule")]


def test_a_row_is_the_charge_it_says(rows):
    mode = Mode(
        title="8C",
        current_c_rate=8.0,
        phases={"charge": {"constant_current": {}}},
        stop={"elapsed_s": 900.0, "voltage_drop_v": 0.02},
    )
    found = values(charge(NICKEL, mode, settings(0.5, ambient_c=35.0, soc_marks=[0.95], sample_interval_s=1.0)))
    row = next(one for one in rows if (one.c_rate, one.stop, one.condition) == (8.0, "voltage_drop", "warm"))
    assert row.time_to_full_s == found["time_to_soc_0.95_s"]
    assert row.end_time_s == found["end_time_s"]
    assert row.peak_temperature_c == found["peak_temperature_c"]
    assert row.charge_in_share == pytest.approx(found["charge_in_ah"] / 0.6, rel=1e-15)
    assert row.end_reason == "voltage below its peak by 0.02 V"


def test_a_timer_puts_the_capacity_in_once(rows):
    timed = [row for row in rows if row.stop == "timer"]
    assert [row.charge_in_share for row in timed] == pytest.approx([1.0] * 4, rel=1e-6)
    assert [row.end_time_s for row in timed] == pytest.approx([1800.0, 450.0] * 2, abs=1e-6)


def test_a_charge_cut_short_was_never_full(rows):
    short = next(row for row in rows if (row.c_rate, row.stop, row.condition) == (8.0, "temperature", "paper"))
    assert short.end_soc < 0.95
    assert math.isnan(short.time_to_full_s)


def test_a_sensor_is_put_before_a_mode_by_its_knobs(chosen):
    seen = behind(MODES["rule"], chosen.sensors["filtered"])
    assert seen.knobs["rate_span_s"] == 30.0
    assert seen.knobs["sample_interval_s"] == 1.0
    assert seen.knobs["trip_rate_k_s"] == 0.05


def test_the_tables_are_as_declared_and_every_number_has_a_known_name(rows, chosen, tmp_path):
    output, declared = making.output("trade_off", tmp_path), making.declared("trade_off")
    output.rows("trade_off", rows)
    output.numbers(quantities(rows, chosen))
    table, numbers = (read(one.table, tmp_path / one.file) for one in declared.values())
    assert len(table["law"]) == len(rows)
    found = set(map(str, numbers["quantity"]))
    assert len(found) == len(numbers["quantity"])
    assert found <= TRADE_OFF_NUMBERS.names(fields(chosen))
    # Every declared pattern is found but those of constant currents that the settings leave out, and of rivals.
    left = TRADE_OFF_NUMBERS.names(fields(chosen)) - found
    assert {name for name in left if not name.startswith(("constant_", "rival_", "coolest_"))} == set()
    constants = {name for name in left if name.startswith("constant_")}
    assert not {name for name in constants if name.startswith(("constant_2c_", "constant_8c_"))}


def made(law, time, peak, rate=math.nan, stop="", sensor=""):
    return Row(law, rate, stop, "paper", sensor, time, peak, time, 1.0, 1.0, "somehow")


def test_rivals_are_the_best_that_are_no_worse(chosen):
    rows = [
        made("constant_current", 400.0, 50.0, 8.0, "voltage_drop"),
        made("constant_current", 420.0, 44.0, 7.0, "voltage_drop"),
        made("constant_current", 440.0, 40.0, 6.0, "voltage_drop"),
        made("constant_current", math.nan, 30.0, 9.0, "temperature"),
        made("net", 421.0, 45.0, sensor="own"),
    ]
    found = {one.name: one.value for one in quantities(rows, chosen)}
    assert found["rival_c_rate_paper"] == 7.0
    assert found["rival_time_to_full_paper_s"] == 420.0
    assert found["coolest_c_rate_paper"] == 7.0
    assert found["coolest_peak_paper_c"] == 44.0
    better = [*rows[:-1], made("net", 399.0, 39.0, sensor="own")]
    found = {one.name: one.value for one in quantities(better, chosen)}
    assert "rival_c_rate_paper" not in found
    assert "coolest_c_rate_paper" not in found


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"c_rates": [4.0, 2.0]}, r"c_rates are \[4\.0, 2\.0\]; they must rise from above 0"),
        ({"stops": {"both": {"soc": 0.9, "elapsed_s": 9.0}}}, r"stops\.both has \['elapsed_s', 'soc'\]; allowed"),
        ({"stops": {"none": {}}}, r"stops\.none has nothing; allowed is one number"),
        ({"stops": {"timer": {"soc": 0.9}}}, "stops has 'timer', which timer_share sets"),
        ({"full_soc": 1.0}, "full_soc"),
    ],
)
def test_a_mistake_is_named(change, message):
    with pytest.raises(ValidationError, match=message):
        TradeOff.model_validate(CHOSEN | change)
