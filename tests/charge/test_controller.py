"""The sampled controller against a loop written by hand, its sensor, its first law and its mistakes."""

import math

import numpy as np
import pytest

from pipeline.charge.checks import check
from pipeline.charge.records import EngineSettings, Mode
from pipeline.charge.simulate import BENCH, run
from pipeline.errors import UserError
from tests.charge.samples import ENGINE, battery, charge, settings, values

NICKEL = battery("nicd_2s_600mah")
AT_30 = {"ambient_c": 30.0, "sample_interval_s": 1.0}
# The paper's Table II, its lost cells filled; a Gaussian network in K/min.
CENTRES = [(4, 0.2), (20, 0.9), (38, 0.9), (40, 0.5), (43, 0.4), (50, 0.5)]
RATES = [8.0, 8.0, 8.0, 8.0, 2.0, 0.1]
NETWORK = {
    "centres": CENTRES,
    "outputs_c_rate": RATES,
    "widths": [0.03, 0.3],
    "scales": [50.0, 1.0],
    "low": [0.0, 0.0],
    "high": [50.0, 1.0],
    "gradient_seconds": 60.0,
}


def controlled(seconds, knobs=(), **stop):
    phases = {"charge": {"controller": {"network": NETWORK}}}
    return Mode(title="Network", phases=phases, stop={"elapsed_s": seconds} | stop, **dict(knobs))


def switched(seconds, **knobs):
    phases = {"charge": {"rate_switch": {}}}
    return Mode(title="Rule", fast_c_rate=8.0, trickle_c_rate=0.1, phases=phases, stop={"elapsed_s": seconds}, **knobs)


def response(temperature, rate_k_s):
    """The network of equation (1), written anew."""
    temperature, gradient = min(max(temperature, 0.0), 50.0), min(max(60.0 * rate_k_s, 0.0), 1.0)
    shares = [math.exp(-0.5 * (((temperature - t) / 50 / 0.03) ** 2 + ((gradient - g) / 0.3) ** 2)) for t, g in CENTRES]
    return sum(s * r for s, r in zip(shares, RATES, strict=True)) / sum(shares)


def by_hand(law, seconds, interval, soc=0.3, step=0.0, span=1):
    """Charge from sample to sample by charges of constant current, deciding here what each one is."""
    from pipeline.cell.circuit import compile_cell
    from pipeline.charge.books import book_for
    from pipeline.charge.controller import compile_control
    from pipeline.charge.period import new_clock
    from pipeline.charge.program import compile_program
    from pipeline.charge.protocol import resolve
    from pipeline.charge.simulate import launch
    from pipeline.charge.state import new_run

    state, cell = new_run(), compile_cell(NICKEL)
    state["state"][0], state["state"][1] = 1 - soc, 303.15
    readings, currents, decided = [], [], None
    for _ in range(round(seconds / interval)):
        reading = float(state["state"][1]) - 273.15
        if step:
            reading = step * math.floor(reading / step + 0.5)
        readings.append(reading)
        back = min(len(readings) - 1, span)
        rate = (reading - readings[-1 - back]) / (back * interval) if back else 0.0
        now = 0.6 * law(reading, rate)
        currents.append(now if decided is None else decided)
        decided = now
        mode = Mode(
            title="Part",
            phases={"part": {"constant_current": {"current_a": currents[-1]}}},
            stop={"elapsed_s": interval},
        )
        protocol = resolve(mode, 0.6)
        program = compile_program(protocol, 2, "edge")
        state["next_slot"] = 0
        book = book_for(program, settings(soc, **AT_30))
        engine = EngineSettings(tolerance=1e-7, maximum_steps=100_000)
        control = compile_control(protocol, 0.6)
        assert launch(cell, program, control, BENCH, state, book, new_clock(1.0), 303.15, engine) == 0
    return np.array(currents), state["state"]


@pytest.mark.parametrize(("interval", "step", "span"), [(2.0, 0.0, 1), (2.0, 0.25, 1), (1.0, 0.25, 10)])
def test_a_network_commands_as_a_loop_by_hand_does(interval, step, span):
    knobs = {"sample_interval_s": interval, "temperature_step_k": step, "rate_span_s": span * interval}
    seconds = 400.0
    outcome = run(NICKEL, controlled(seconds, knobs), BENCH, settings(0.3, **AT_30), ENGINE)
    currents, state = by_hand(response, seconds, interval, step=step, span=span)
    samples = outcome.book.samples[: outcome.book.filled[0]]
    whole = round(interval)
    assert samples[whole - 1 :: whole, 2] == pytest.approx(currents, rel=1e-6)
    assert outcome.run["state"][:3] == pytest.approx(state[:3], rel=1e-6)
    assert currents[0] == pytest.approx(4.8, rel=1e-2)
    assert currents[-1] < 0.5


def test_the_current_lags_by_one_sample():
    trace = charge(NICKEL, controlled(380, {"sample_interval_s": 20.0}), settings(0.3, **AT_30)).trace
    temperature = np.concatenate([[30.0], trace["Surface Temperature / degC"]])[::20]
    current = trace["Current / A"][::20]
    rate = np.diff(temperature, prepend=temperature[0]) / 20.0
    assert current[0] == pytest.approx(0.6 * response(30.0, 0.0), rel=1e-9)
    for n in range(1, len(current)):
        assert current[n] == pytest.approx(0.6 * response(temperature[n - 1], rate[n - 1]), rel=1e-7)


def test_a_plain_rule_switches_once():
    trace = charge(NICKEL, switched(600, sample_interval_s=1.0, trip_rate_k_s=0.05), settings(0.02, **AT_30)).trace
    current = trace["Current / A"]
    assert set(np.round(current, 6)) == {4.8, 0.06}
    assert np.count_nonzero(np.diff(np.round(current, 6))) == 1
    time = int(np.argmax(current < 1.0))
    temperature = trace["Surface Temperature / degC"]
    # The reading two samples ago, less the one before it, was the first to reach the rate.
    assert temperature[time - 2] - temperature[time - 3] >= 0.05 > temperature[time - 3] - temperature[time - 4]


def test_at_a_short_delay_the_sensor_decides():
    """One step of an eighth of a kelvin within a second is a rate no battery has; over half a minute it is none."""
    rule = {"sample_interval_s": 1.0, "trip_rate_k_s": 0.05, "temperature_step_k": 0.125}
    conditions = settings(0.02, **AT_30)
    short = values(charge(NICKEL, switched(600, **rule), conditions))
    long = values(charge(NICKEL, switched(600, **rule, rate_span_s=30.0), conditions))
    exact = values(charge(NICKEL, switched(600, **(rule | {"temperature_step_k": 0.0})), conditions))
    assert short["end_soc"] < 0.1
    assert long["end_soc"] == pytest.approx(exact["end_soc"], abs=0.05)


def test_noise_is_the_same_every_time_and_another_in_another_stream():
    def noisy(stream):
        knobs = {"sample_interval_s": 1.0, "temperature_noise_k": 0.2, "noise_stream": stream}
        return charge(NICKEL, controlled(600, knobs), settings(0.3, **AT_30)).trace["Current / A"]

    assert np.array_equal(noisy(1), noisy(1))
    assert not np.array_equal(noisy(1), noisy(2))


def test_a_second_phase_starts_afresh():
    """What a phase decided and read is not carried into the next: each begins at its own first reading."""
    phases = {
        "one": {"controller": {"network": NETWORK}, "until": {"elapsed_s": 100}},
        "rest": {"rest": {}, "until": {"elapsed_s": 500}},
        "two": {"controller": {"network": NETWORK}},
    }
    mode = Mode(title="Twice", sample_interval_s=5.0, phases=phases, stop={"elapsed_s": 700})
    trace = charge(NICKEL, mode, settings(0.3, **AT_30)).trace
    before = trace["Surface Temperature / degC"][599]
    assert trace["Current / A"][602] == pytest.approx(0.6 * response(before, 0.0), rel=1e-9)


@pytest.mark.parametrize("knobs", [{}, {"temperature_step_k": 0.25, "temperature_noise_k": 0.1}])
def test_the_first_law_closes(knobs):
    result = charge(NICKEL, controlled(900, {"sample_interval_s": 1.0} | knobs), settings(0.02, **AT_30))
    assert abs(values(result)["energy_balance_residual"]) < 1e-9
    assert np.all(result.trace["soc"] < 1.0)


def test_a_stop_between_samples_is_located():
    found = values(charge(NICKEL, controlled(900, {"sample_interval_s": 7.0}, soc=0.5), settings(0.3, **AT_30)))
    assert found["end_soc"] == pytest.approx(0.5, abs=1e-9)
    assert found["end_time_s"] % 7.0 > 0.1


def test_the_sheet_reads_what_it_writes():
    for network in (NETWORK, {"from": "network", "value": "network"}):
        sheet = Mode(
            title="Network",
            sample_interval_s=1.0,
            phases={"charge": {"controller": {"network": network}}},
            stop={"elapsed_s": 10},
        )
        assert Mode.model_validate(sheet.model_dump(mode="json", by_alias=True)) == sheet
    assert sheet.model_dump(mode="json")["phases"]["charge"]["controller"]["network"]["from"] == "network"


def test_a_network_still_to_be_found_passes_the_check_but_not_the_charge():
    network = {"from": "network", "value": "network"}
    sheet = Mode(
        title="Network",
        sample_interval_s=1.0,
        phases={"charge": {"controller": {"network": network}}},
        stop={"elapsed_s": 10},
    )
    check(NICKEL, sheet, settings(0.2))
    with pytest.raises(UserError, match=r"phases\.charge\.network: still to be found by 'network'"):
        charge(NICKEL, sheet, settings(0.2))


@pytest.mark.parametrize(
    ("knobs", "message"),
    [
        ({}, r"phases\.charge\.sample_interval_s: not given, and the mode has no knob sample_interval_s"),
        ({"sample_interval_s": 1e-5}, r"sample_interval_s: 1e-05 s; allowed is 0\.001 s or more"),
        ({"sample_interval_s": 2.0, "rate_span_s": 5.0}, r"rate_span_s: 5 s is no whole number of samples of 2 s"),
        ({"sample_interval_s": 2.0, "temperature_step_k": -1.0}, r"temperature_step_k: -1; it must be greater than 0"),
        ({"sample_interval_s": 2.0, "noise_stream": 1.5}, r"noise_stream: 1\.5; allowed is a whole number"),
        ({"sample_interval_s": 0.001, "stopped_s": 1e6}, r"sample_interval_s: 0\.001 s up to stop\.elapsed_s 1e\+06 s"),
        ({"sample_interval_s": 2.0, "sensor_step_k": 1.0}, r"sensor_step_k: no phase uses this knob"),
    ],
)
def test_a_mistake_is_named(knobs, message):
    seconds = knobs.pop("stopped_s", 600) if "stopped_s" in knobs else 600
    with pytest.raises(UserError, match=message):
        check(NICKEL, controlled(seconds, knobs), settings(0.02, ambient_c=30.0, sample_interval_s=60.0))


def test_a_trickle_above_the_fast_current_is_refused():
    sheet = switched(600, sample_interval_s=1.0, trip_rate_k_s=0.05)
    sheet = Mode.model_validate(sheet.model_dump() | {"trickle_c_rate": 9.0})
    with pytest.raises(UserError, match=r"phases\.charge\.trickle_a: 5\.4 A is not below fast_a, 4\.8 A"):
        check(NICKEL, sheet, settings(0.02, **AT_30))


def test_two_different_controllers_in_a_mode_are_refused():
    phases = {
        "one": {"controller": {"network": NETWORK}, "until": {"elapsed_s": 10}},
        "two": {"rate_switch": {"fast_a": 4.8, "trickle_a": 0.1, "trip_rate_k_s": 0.1}},
    }
    with pytest.raises(UserError, match="a mode has one controller"):
        check(NICKEL, Mode(title="Two", sample_interval_s=1.0, phases=phases, stop={"elapsed_s": 99}), settings(0.2))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"outputs_c_rate": [8.0]}, "centres are 6 but outputs_c_rate are 1"),
        ({"widths": [0.0, 1.0]}, r"widths is \[0\.0, 1\.0\]; each must be greater than 0"),
        ({"low": [60.0, 0.0]}, r"low \[60\.0, 0\.0\] must lie below high"),
        ({"kernel": "gauss"}, "kernel"),
    ],
)
def test_a_network_that_is_none_is_refused(change, message):
    with pytest.raises(ValueError, match=message):
        Mode(
            title="Network",
            phases={"charge": {"controller": {"network": NETWORK | change}}},
            stop={"elapsed_s": 10},
        )
