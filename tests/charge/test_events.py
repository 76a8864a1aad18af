"""Stops are located, not stepped over, and say what they were."""

import numpy as np
import pytest

from pipeline.cell.records import Battery
from pipeline.charge.records import EngineSettings, Mode
from pipeline.errors import EngineError
from tests.charge.samples import battery, charge, load, settings, values
from tests.charge.test_exact import PLAIN, constant

PLAIN_BATTERY = Battery(**PLAIN)


@pytest.mark.parametrize(
    ("stop", "when", "reason"),
    [
        ({"soc": 0.3}, 720.0, "stop: soc 0.3"),
        # 2 (2 - 0.5 x + 0.05) = 3.45 at x = 0.65
        ({"voltage_v": 3.45}, 900.0, "stop: voltage 3.45 V"),
        # 2 K times 100 J/K over 2 x 0.05 W
        ({"temperature_c": 27.0}, 2000.0, "stop: temperature 27 degC"),
        ({}, 2500.0, "stop: elapsed 2500 s"),
    ],
)
def test_a_stop_is_located(stop, when, reason):
    found = values(charge(PLAIN_BATTERY, constant(1.0, 2500, **stop), settings(0.1, sample_interval_s=7.0)))
    assert found["end_time_s"] == pytest.approx(when, abs=1e-7)
    assert found["end_reason"] == reason


def test_a_stop_inside_a_pulse_is_located():
    mode = Mode(
        title="Pulse",
        charge_a=2.0,
        charge_share=0.5,
        frequency_hz=0.01,
        phases={"pulse": {"pulse": {}}},
        stop={"elapsed_s": 4000, "soc": 0.3},
    )
    found = values(charge(PLAIN_BATTERY, mode, settings(0.1)))
    # 0.2 Ah at 2 A are 360 s of charging: seven pulses of 50 s, each followed by a rest, and 10 s.
    assert found["end_time_s"] == pytest.approx(710.0, abs=1e-8)


def test_a_current_that_falls_ends_the_phase():
    sheet = load("modes/cc_cv.yaml")
    sheet["phases"]["charge"]["until"] = {"current_a": 0.5}
    result = charge(battery("lead_acid_12v7ah"), Mode(**sheet), settings(0.8))
    assert result.phases["end_reason"] == ["current 0.5 A"]
    assert result.trace["current_min_a"][-1] == pytest.approx(0.5, abs=1e-9)


def test_marks_are_reached_between_samples():
    found = values(
        charge(PLAIN_BATTERY, constant(1.0, 1000), settings(0.1, soc_marks=[0.25, 0.9], sample_interval_s=90))
    )
    assert found["time_to_soc_0.25_s"] == pytest.approx(540.0, abs=1e-7)
    assert found["time_to_soc_0.9_s"] is None


def test_stages_change_at_their_edges():
    phases = {"stages": {"staged": {"currents_a": [2.0, 1.0, 0.5], "soc_edges": [0.2, 0.3, 0.4]}}}
    mode = Mode(title="Staged", phases=phases, stop={"elapsed_s": 5000})
    result = charge(PLAIN_BATTERY, mode, settings(0.1))
    assert result.phases["end_s"] == pytest.approx([180.0, 540.0, 1260.0], abs=1e-8)
    assert result.phases["end_reason"] == ["soc 0.2", "soc 0.3", "soc 0.4"]
    already = charge(PLAIN_BATTERY, mode, settings(0.25))
    assert already.phases["end_s"] == pytest.approx([0.0, 180.0, 900.0], abs=1e-8)


def test_phases_repeat():
    phases = {
        "on": {"constant_current": {"current_a": 1.0}, "until": {"elapsed_s": 60}},
        "off": {"rest": {}, "until": {"elapsed_s": 30}},
    }
    mode = Mode(title="Repeated", phases=phases, repeat=3, stop={"elapsed_s": 1000})
    result = charge(PLAIN_BATTERY, mode, settings(0.1))
    assert result.phases["phase"] == ["on", "off"] * 3
    assert result.phases["end_s"] == pytest.approx([60, 90, 150, 180, 240, 270], abs=1e-9)
    assert values(result)["charge_in_ah"] == pytest.approx(180 / 3600, rel=1e-12)


def test_steps_that_run_out_are_an_error_with_time_and_state():
    with pytest.raises(EngineError, match=r"steps are used up at .* s .*SOC 0\.[0-9]+.*maximum_steps is 10"):
        charge(PLAIN_BATTERY, constant(1.0, 1000), settings(0.1), engine=EngineSettings(maximum_steps=10))


def test_samples_lie_at_their_interval_and_means_add_up():
    result = charge(
        battery("lead_acid_12v7ah"),
        Mode(**(load("modes/cv_reflex.yaml") | {"stop": {"elapsed_s": 9.5}})),
        settings(0.5, sample_interval_s=1.0),
    )
    time, current = result.trace["Test Time / s"], result.trace["Current / A"]
    assert time == pytest.approx([*range(1, 10), 9.5], abs=1e-12)
    taken = np.sum(current * np.diff(time, prepend=0.0)) / 3600
    assert taken == pytest.approx(values(result)["charge_in_ah"] - values(result)["charge_out_ah"], rel=1e-12)
