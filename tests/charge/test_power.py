"""A constant power against scipy and against what its name says, with its limits found where they are met."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pipeline.cell.records import Battery
from pipeline.charge.checks import check
from pipeline.charge.comparison import constant_current_a
from pipeline.charge.records import EngineSettings, Mode
from pipeline.charge.simulate import Supply
from pipeline.errors import UserError
from tests.charge.samples import battery, charge, settings, values

CELLS, OHM, PAIR_OHM, TAU_S, ENTROPY = 3, 0.04, 0.06, 20.0, 2e-4
HEAT_J_K, COOLING_K_W, AMBIENT_K = 90.0, 6.0, 298.15
CELL = Battery(
    name="power",
    title="Power",
    cells_in_series=CELLS,
    capacity_ah=1.5,
    open_circuit_voltage_v={"polynomial": [4.0, -0.7, 0.2]},
    entropic_coefficient_v_k=ENTROPY,
    series_resistance_ohm=OHM,
    pairs={"one": {"resistance_ohm": PAIR_OHM, "time_constant_s": TAU_S}},
    thermal={"heat_capacity_j_k": HEAT_J_K, "resistance_k_w": COOLING_K_W},
)
POWER_W, MOST_A, LIMIT_V, TAIL_A = 17.0, 1.45, 11.9, 0.3
DRIVERS = ["edge", "averaged"]


def mode(limits=None, until=None, stop=None, **knobs):
    phase = {"constant_power": {}} | ({"limit": limits} if limits else {}) | ({"until": until} if until else {})
    given = {"power_w": POWER_W} | knobs
    return Mode(title="Power", phases={"only": phase}, stop={"elapsed_s": 20000.0} | (stop or {}), **given)


def slow_v(y):
    x = 1.0 - y[0]
    return 4.0 - 0.7 * x + 0.2 * x * x + ENTROPY * (y[2] - AMBIENT_K) + y[1]


def of_power(y, power_w=POWER_W):
    e = slow_v(y)
    return (-e + np.sqrt(e * e + 4.0 * OHM * power_w / CELLS)) / (2.0 * OHM)


def of_voltage(y):
    return (LIMIT_V / CELLS - slow_v(y)) / OHM


def slopes(current_of):
    def f(_, y):
        i = current_of(y)
        heat = CELLS * (OHM * i * i + y[1] ** 2 / PAIR_OHM + i * y[2] * ENTROPY)
        return [
            i / 5400.0,
            (PAIR_OHM * i - y[1]) / TAU_S,
            (heat - (y[2] - AMBIENT_K) / COOLING_K_W) / HEAT_J_K,
            CELLS * (slow_v(y) + OHM * i) * i,
        ]

    return f


def until(current_of, start, begin_s, event):
    def met(_, y):
        return event(y)

    met.terminal = True
    found = solve_ivp(slopes(current_of), (begin_s, 2e4), start, "DOP853", rtol=1e-12, atol=1e-13, events=met)
    return found.t[-1], found.y[:, -1]


@pytest.mark.parametrize("driver", DRIVERS)
def test_current_power_voltage_and_tail_follow_one_another_as_in_scipy(driver):
    """The most current first, then the power, then the voltage, to the tail: every change where scipy has it."""
    start = np.array([0.1, 0.0, AMBIENT_K, 0.0])
    # The current limit holds until the voltage has risen so far that the power is enough for less.
    first_s, state = until(
        lambda y: MOST_A, start, 0.0, lambda y: CELLS * MOST_A * (slow_v(y) + OHM * MOST_A) - POWER_W
    )
    powered = state[3]
    second_s, state = until(of_power, state, first_s, lambda y: CELLS * (slow_v(y) + OHM * of_power(y)) - LIMIT_V)
    assert state[3] - powered == pytest.approx(POWER_W * (second_s - first_s), rel=1e-9)
    third_s, state = until(of_voltage, state, second_s, lambda y: of_voltage(y) - TAIL_A)
    assert 100.0 < first_s < second_s - 100.0 < third_s - 200.0
    done = charge(
        CELL, mode({"voltage_v": LIMIT_V}, {"current_a": TAIL_A}, max_current_a=MOST_A), settings(0.1),
        engine=EngineSettings(driver=driver, tolerance=1e-10, maximum_step_s=5.0),
    )  # fmt: skip
    found = values(done)
    assert found["end_reason"] == "current 0.3 A"
    assert found["end_time_s"] == pytest.approx(third_s, abs=1e-3)
    assert found["time_at_voltage_limit_s"] == pytest.approx(third_s - second_s, abs=1e-3)
    assert found["time_at_supply_limit_s"] == 0.0
    assert found["end_soc"] == pytest.approx(state[0], abs=1e-8)
    assert found["end_temperature_c"] + 273.15 == pytest.approx(state[2], abs=1e-5)
    assert 3600.0 * found["energy_in_wh"] == pytest.approx(state[3], rel=1e-8)
    assert found["control_changes"] == 2


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize("cell", ["lead_acid_12v7ah", "lead_acid_generic", "nicd_2s_600mah", "lfp_8ah"])
def test_every_battery_takes_the_power_it_is_given(cell, driver):
    used = battery(cell)
    power = {"power_w_cell": 0.25 * used.capacity_ah}
    sheet = Mode(title="P", phases={"only": {"constant_power": {}}}, stop={"elapsed_s": 600.0}, **power)
    found = values(charge(used, sheet, settings(0.6), engine=EngineSettings(driver=driver)))
    expected = 0.25 * used.capacity_ah * used.cells * 600.0 / 3600.0
    assert found["energy_in_wh"] == pytest.approx(expected, rel=1e-7)
    assert abs(found["energy_balance_residual"]) < 1e-9


def test_the_lesser_of_sheet_and_supply_is_drawn():
    supply = Supply(np.array([0.0, 100.0, 300.0]), np.array([50.0, 10.0, 16.999]))
    found = values(charge(CELL, mode(stop={"elapsed_s": 600.0}), settings(0.3), supply))
    assert 3600.0 * found["energy_in_wh"] == pytest.approx(100 * 17.0 + 200 * 10.0 + 300 * 16.999, rel=1e-9)
    assert found["time_at_supply_limit_s"] == pytest.approx(500.0)


def test_a_falling_voltage_is_watched_for_under_a_power_of_the_sheet():
    nickel = battery("nicd_2s_600mah")
    phases = {"only": {"constant_power": {}, "until": {"voltage_drop_v_cell": 0.01}}}
    sheet = Mode(title="P", power_w_cell=3.5, phases=phases, stop={"elapsed_s": 4000.0})
    found = values(charge(nickel, sheet, settings(0.5, sample_interval_s=1.0)))
    assert found["end_reason"] == "voltage below its peak by 0.02 V"
    assert 0.99 < found["end_soc"] < 1.0


def test_a_power_out_of_all_bounds_is_refused():
    with pytest.raises(UserError, match=r"phases.only.power_w: 17000 W; allowed is up to 100 C"):
        check(CELL, mode(power_w=17000.0), settings(0.1))
    with pytest.raises(
        UserError, match=r"phases.only.power_w: not given, and the mode has no knob power_w or power_w_c"
    ):
        check(CELL, Mode(title="P", phases={"only": {"constant_power": {}}}, stop={"elapsed_s": 1.0}), settings(0.1))
    with pytest.raises(UserError, match="none has a constant current"):
        constant_current_a(mode(), CELL)
