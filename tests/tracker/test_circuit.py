"""The circuit between two measurements: its equilibrium, scipy's integration of it, the boundary of continuity."""

from __future__ import annotations

import numpy as np
import pytest
from pvlib.pvsystem import i_from_v
from scipy.integrate import solve_ivp

from pipeline.tracker.loop import Light, run
from pipeline.tracker.source import of_all_panels, parts
from tests.tracker.conftest import tracker


def rates(source, irradiance, duty):
    """The averaged circuit written down once more, its panel by pvlib."""
    (photo, saturation, shunt, ideality), series = of_all_panels(source, [irradiance], 25.0)
    boost, bus = source.boost, source.bus_voltage_v + source.boost.rectifier_voltage_v

    def of(_time, state):
        voltage, current = state
        panel = float(i_from_v(voltage, photo[0], saturation[0], series, 1.0 / shunt[0], ideality[0]))
        period = boost.switching_period_s
        rest = 1.0 - duty
        if voltage > 0:
            rest = min(rest, 2 * boost.inductance_h * current / (period * duty * voltage) - duty)
        ohm = boost.inductor_resistance_ohm + duty * boost.on_resistance_ohm
        ohm += (1 - duty) * boost.rectifier_resistance_ohm
        push = (duty + rest) * voltage - rest * bus - ohm * current
        return [(panel - current) / boost.input_capacitance_f, push / boost.inductance_h]

    return of


def held(source, irradiance, duty, time, start_v):
    """The loop's own course at one duty."""
    still = tracker("perturb_observe", duty_step=1e-12, perturbation_period_s=10.0, measurement_bits=12)
    still = still.model_copy(update={"start_voltage_share": 1.0 - (duty - 0.0)})
    diode, series = of_all_panels(source, np.full(len(time), irradiance), 25.0)
    rows = Light(
        np.diff(time, append=2 * time[-1] - time[-2]), diode, series, np.zeros((1, 2)), 1.0,
        np.full(len(time), -1, dtype=np.int64),
    )  # fmt: skip
    fixed = still.model_copy(update={"least_duty": duty, "most_duty": duty})
    return run(source, fixed, rows, start_voltage_v=start_v)


@pytest.mark.parametrize(
    ("irradiance", "duty"), [(1000.0, 0.3), (1000.0, 0.5), (300.0, 0.35), (100.0, 0.3), (20.0, 0.2)]
)
def test_it_ends_where_the_circuit_stands_still(source, irradiance, duty):
    time = np.linspace(0.0, 0.9, 10)
    found = held(source, irradiance, duty, time, 20.0)
    end = [found.voltage_v[-1], found.current_a[-1]]
    change = rates(source, irradiance, duty)(0.0, end)
    assert abs(change[0]) * source.boost.input_capacitance_f < 1e-6
    assert abs(change[1]) * source.boost.inductance_h < 1e-5


def test_a_fixed_duty_sets_the_voltage_of_the_ideal_converter(source):
    ideal = source._replace(
        boost=source.boost.model_copy(
            update={
                "rectifier": "synchronous",
                "inductor_resistance_ohm": 0.0,
                "on_resistance_ohm": 0.0,
                "rectifier_resistance_ohm": 0.0,
            }
        )
    )
    for duty in (0.2, 0.25, 0.3):
        found = held(ideal, 800.0, duty, np.linspace(0.0, 0.9, 10), 15.0)
        assert found.voltage_v[-1] == pytest.approx((1 - duty) * 24.0, rel=1e-6)


def test_the_transient_is_scipys(source):
    """Short rows make the steps short; the start is far from where it ends."""
    irradiance, duty, time = 900.0, 0.32, np.arange(0.0, 0.01, 1e-5)
    expected = solve_ivp(
        rates(source, irradiance, duty), (0.0, 0.01), [19.0, 0.0], "LSODA", time[1:], rtol=1e-9, atol=1e-9
    )
    found = held(source, irradiance, duty, time, 19.0)
    np.testing.assert_allclose(found.voltage_v[:-1], expected.y[0], atol=0.02)
    swing = np.ptp(expected.y[0])
    assert swing > 3.0


def test_long_rows_capture_what_short_ones_do(source):
    """A second in rows of 50 ms, and in rows of 0.1 ms."""
    totals = []
    for length in (0.05, 1e-4):
        found = held(source, 900.0, 0.32, np.arange(0.0, 1.0 - 0.5 * length, length), 17.0)
        totals.append(found.energy_j.sum())
    assert totals[0] == pytest.approx(totals[1], rel=3e-4)


def test_every_part_of_the_circuit_counts(source):
    base = parts(source)
    changed = source._replace(boost=source.boost.model_copy(update={"input_capacitance_f": 1e-3}), bus_voltage_v=30.0)
    assert set(np.flatnonzero(parts(changed) != base)) == {1, 2}
