"""Voltages that follow the battery's temperature, resistances that do, and a start away from the ambient."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

from pipeline.cell.circuit import compile_cell, pair_ohm, series_ohm
from pipeline.cell.records import Arrhenius, Battery
from pipeline.charge.checks import check
from pipeline.charge.records import EngineSettings, Mode
from pipeline.errors import UserError
from tests.charge.samples import BATTERIES, battery, charge, settings, values

DRIVERS = ["edge", "averaged"]
FINE = {"tolerance": 1e-10, "maximum_step_s": 2.0}
CELLS, CAPACITY_AS, GAS = 6, 2.0 * 3600.0, 8.314462618
OHM, PAIR_OHM, TAU_S, ENTROPY = 0.02, 0.03, 8.0, 3e-4
HEAT_J_K, COOLING_K_W = 60.0, 1.0
TABLE = {"temperature_c": [-10.0, 10.0, 25.0, 45.0], "factor": [3.0, 1.4, 1.0, 0.7]}
ARRHENIUS = {"activation_energy_j_mol": 24000.0, "reference_temperature_c": 20.0}
SLOPE, REFERENCE_C, LOW_C, HIGH_C = -0.004, 20.0, 24.0, 31.0
LIMIT_V = 13.8


def cell(series=None, pair=None):
    one = {"resistance_ohm": {"polynomial": [PAIR_OHM, 0.01]}, "time_constant_s": TAU_S}
    return Battery(
        name="warm",
        title="Warm",
        cells_in_series=CELLS,
        capacity_ah=CAPACITY_AS / 3600.0,
        open_circuit_voltage_v={"polynomial": [2.15, -0.2]},
        entropic_coefficient_v_k=ENTROPY,
        series_resistance_ohm={"polynomial": [OHM, 0.005]},
        series_resistance_temperature=series,
        pairs={"one": one | ({"resistance_temperature": pair} if pair else {})},
        thermal={"heat_capacity_j_k": HEAT_J_K, "resistance_k_w": COOLING_K_W},
    )


def factor_of(warmth):
    """Return f(T) and its slope, written anew."""
    if warmth is None:
        return lambda t: (1.0, 0.0)
    if "factor" in warmth:
        cubic = PchipInterpolator(np.array(warmth["temperature_c"]) + 273.15, warmth["factor"])
        return lambda t: (float(cubic(t)), float(cubic(t, 1)))
    energy, reference = warmth["activation_energy_j_mol"] / GAS, warmth["reference_temperature_c"] + 273.15

    def f(t):
        factor = np.exp(energy * (1.0 / t - 1.0 / reference))
        return factor, -energy / t**2 * factor

    return f


def lifted(t_k):
    return LIMIT_V / CELLS + SLOPE * (min(max(t_k - 273.15, LOW_C), HIGH_C) - REFERENCE_C)


def slopes(current_of, ambient_k, series, pair):
    """Return the equations of the circuit: heat by its state function, so that a changing C gives up what it holds."""
    ohm_at, pair_at = factor_of(series), factor_of(pair)

    def f(_, y):
        s, v, t = y[:3]
        x = 1.0 - s
        (fs, _), (fp, dfp) = ohm_at(t), pair_at(t)
        ohm, resistance = (OHM + 0.005 * x) * fs, (PAIR_OHM + 0.01 * x) * fp
        slow = 2.15 - 0.2 * x + ENTROPY * (t - 298.15) + v
        i = current_of(slow, ohm, t)
        ds, dv = i / CAPACITY_AS, (resistance * i - v) / TAU_S
        # d(C v^2 / 2)/dt with C = tau / R(s, T); its part with dT/dt goes to the left of the heat balance.
        by_soc = -TAU_S / resistance**2 * (-0.01 * fp) * ds
        by_t = -TAU_S / resistance**2 * (PAIR_OHM + 0.01 * x) * dfp
        stored = TAU_S / resistance * v * dv + 0.5 * v * v * by_soc
        heat = CELLS * (ohm * i * i + v * i - stored + i * t * ENTROPY)
        dt = (heat - (t - ambient_k) / COOLING_K_W) / (HEAT_J_K + CELLS * 0.5 * v * v * by_t)
        return [ds, dv, dt, CELLS * (slow + ohm * i) * i]

    return f


def solved(current_of, start, span, ambient_k, series=None, pair=None, event=None):
    return solve_ivp(
        slopes(current_of, ambient_k, series, pair), span, start, "DOP853", rtol=1e-12, atol=1e-13, max_step=20.0,
        events=event,
    )  # fmt: skip


COMPENSATED = {
    "temperature_coefficient_v_per_k_cell": SLOPE,
    "reference_temperature_c": REFERENCE_C,
    "lowest_compensated_c": LOW_C,
    "highest_compensated_c": HIGH_C,
}


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize("begin_c", [15.0, 36.0])
def test_a_held_voltage_follows_the_temperature_between_its_clamps(begin_c, driver):
    """The battery starts beyond one clamp and passes both, at its current or held from the start, as in scipy.

    The line is integrated from clamp to clamp, so that neither solution steps over a bend.
    """
    ambient_c, current = (34.0, 2.8) if begin_c < LOW_C else (12.0, 20.0)
    mode = Mode(
        title="Held", voltage_v=LIMIT_V, max_current_a=current, phases={"only": {"constant_voltage": {}}},
        stop={"elapsed_s": 300.0}, **COMPENSATED,
    )  # fmt: skip
    conditions = settings(0.8, ambient_c=ambient_c, initial_temperature_c=begin_c, sample_interval_s=1.0)
    found = charge(cell(), mode, conditions, engine=EngineSettings(driver=driver, **FINE)).trace

    def over(_, y):
        return (
            y[1]
            + 2.15
            - 0.2 * (1 - y[0])
            + ENTROPY * (y[2] - 298.15)
            + (OHM + 0.005 * (1 - y[0])) * current
            - (lifted(y[2]))
        )

    def passes(at_c):
        def f(_, y):
            return y[2] - at_c - 273.15

        f.terminal = True
        return f

    over.terminal = True
    y, t, times, rows = [0.8, 0.0, begin_c + 273.15, 0.0], 0.0, [], []
    ambient_k = ambient_c + 273.15
    held = over(0.0, y) > 0.0
    while t < 300.0:
        law = (lambda slow, ohm, k: (lifted(k) - slow) / ohm) if held else (lambda slow, ohm, k: current)
        clamps = [passes(c) for c in (LOW_C, HIGH_C) if abs(y[2] - 273.15 - c) > 1e-6]
        part = solved(law, y, (t, 300.0), ambient_k, event=[*clamps, *([] if held else [over])])
        times += part.t[1:].tolist()
        rows += part.y[:, 1:].T.tolist()
        t, y = part.t[-1], part.y[:, -1].copy()
        held = held or abs(over(0.0, y)) < 1e-9
        if t < 300.0:
            y[2] += 1e-9 * np.sign(slopes(law, ambient_k, None, None)(0, y)[2])
    assert held
    warmest = max(row[2] for row in rows) - 273.15
    assert warmest > HIGH_C if begin_c < LOW_C else min(row[2] for row in rows) - 273.15 < LOW_C
    end = rows[-1]
    assert found["soc"][-1] == pytest.approx(end[0], abs=2e-8)
    assert found["Surface Temperature / degC"][-1] + 273.15 == pytest.approx(end[2], abs=2e-5)
    limited = found["voltage_limited_share"] == 1.0
    expected = CELLS * np.array([lifted(c + 273.15) for c in found["Surface Temperature / degC"][limited]])
    # Within a sample the battery's temperature moves by less than 0.45 K.
    assert found["Voltage / V"][limited] == pytest.approx(expected, abs=CELLS * abs(SLOPE) * 0.45)
    assert found["voltage_max_v"][limited] == pytest.approx(expected, abs=CELLS * abs(SLOPE) * 0.45)
    assert expected.max() - expected.min() > CELLS * abs(SLOPE) * 1.0
    energy = 3600.0 * (found["Charging Energy / Wh"][-1])
    assert energy == pytest.approx(end[3], rel=1e-7)


@pytest.mark.parametrize(("temperature_c", "lift"), [(20.0, 0.02), (30.0, -0.02), (-20.0, 0.1), (60.0, -0.1)])
def test_a_battery_at_the_ambient_is_held_at_the_voltage_of_its_temperature(temperature_c, lift):
    """-4 mV/K a cell about 25 degC, no further than 25 K: no heat is left that would move the battery away."""
    still = cell().model_copy(update={"thermal": cell().thermal.model_copy(update={"heat_capacity_j_k": 1e9})})
    mode = Mode(
        title="Held", voltage_v_cell=2.3, max_current_c_rate=4.0, phases={"only": {"constant_voltage": {}}},
        stop={"elapsed_s": 4000.0}, temperature_coefficient_v_per_k_cell=-0.004, lowest_compensated_c=0.0,
        highest_compensated_c=50.0,
    )  # fmt: skip
    found = charge(still, mode, settings(0.8, ambient_c=temperature_c), engine=EngineSettings(**FINE)).trace
    held = found["voltage_limited_share"] == 1.0
    assert held.any()
    assert found["Voltage / V"][held] == pytest.approx(6 * (2.3 + lift), abs=1e-6)


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize("name", ["lead_acid_12v7ah", "lead_acid_generic", "nicd_2s_600mah", "lfp_8ah"])
def test_compensation_in_a_bath_is_the_same_sheet_with_other_volts(name, driver):
    """Every battery, pulses that meet their limit: at one temperature only the volts differ, bit for bit of physics."""
    used = battery(name)
    bath = used.model_copy(update={"thermal": used.thermal.model_copy(update={"heat_capacity_j_k": 1e12})})
    limit = {"lead_acid_12v7ah": 2.354, "lead_acid_generic": 13.0 / 6, "nicd_2s_600mah": 1.41, "lfp_8ah": 3.368}[name]
    lift = -0.002 * (35.0 - 25.0)
    knobs = {"charge_c_rate": 0.5, "charge_share": 0.8, "frequency_hz": 20.0}

    def run(volts, **more):
        phases = {"only": {"pulse": {}, "limit": {"voltage_v_cell": volts}}}
        mode = Mode(title="Pulse", phases=phases, stop={"elapsed_s": 200.0}, **knobs, **more)
        return charge(bath, mode, settings(0.93, ambient_c=35.0), engine=EngineSettings(driver=driver))

    one = run(limit, temperature_coefficient_v_per_k_cell=-0.002)
    other = run(limit + lift)
    assert values(one)["time_at_voltage_limit_s"] > 0.0
    for column in ("soc", "Voltage / V", "Current / A", "voltage_max_v"):
        assert one.trace[column] == pytest.approx(other.trace[column], rel=1e-9 if driver == "edge" else 1e-5), column


def test_a_voltage_reached_is_that_of_the_temperature():
    mode = Mode(
        title="Bulk", phases={"bulk": {"constant_current": {"current_a": 1.0}, "until": {"voltage_v_cell": 2.2}}},
        stop={"elapsed_s": 7000.0}, temperature_coefficient_v_per_k_cell=-0.005, reference_temperature_c=25.0,
    )  # fmt: skip
    found = charge(cell(), mode, settings(0.3, ambient_c=35.0))
    end_c = found.trace["Surface Temperature / degC"][-1]
    soc = found.trace["soc"][-1]
    # The pair lags its falling resistance by its time constant.
    pair_v = PAIR_OHM + 0.01 * (1 - soc) + 0.01 * TAU_S / CAPACITY_AS
    volts = 2.15 - 0.2 * (1 - soc) + ENTROPY * (end_c - 25.0) + (OHM + 0.005 * (1 - soc)) + pair_v
    assert volts == pytest.approx(2.2 - 0.005 * (end_c - 25.0), abs=1e-6)
    assert values(found)["end_reason"] == "voltage 13.2 V"


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize(
    ("series", "pair"), [(ARRHENIUS, None), (None, ARRHENIUS), (ARRHENIUS, TABLE), (TABLE, ARRHENIUS)]
)
def test_resistances_that_follow_the_temperature_are_scipys(series, pair, driver):
    """From -5 degC in air of 30: R(s) f(T), C = tau / R, against state functions and scipy."""
    start, ambient_k = [0.2, 0.0, 268.15, 0.0], 303.15
    mode = Mode(
        title="CC", phases={"only": {"constant_current": {"current_a": 3.0}}}, stop={"elapsed_s": 900.0}
    )  # fmt: skip
    conditions = settings(0.2, ambient_c=30.0, initial_temperature_c=-5.0)
    done = charge(cell(series, pair), mode, conditions, engine=EngineSettings(driver=driver, **FINE))
    end = solved(lambda slow, ohm, t: 3.0, start, (0.0, 900.0), ambient_k, series, pair).y[:, -1]
    found = values(done)
    assert done.trace["soc"][-1] == pytest.approx(end[0], abs=1e-9)
    assert found["end_temperature_c"] + 273.15 == pytest.approx(end[2], abs=1e-5)
    assert 3600.0 * found["energy_in_wh"] == pytest.approx(end[3], rel=1e-8)
    assert abs(found["energy_balance_residual"]) < 1e-9
    # Over the ambient, from which this battery begins 35 K away.
    assert found["peak_temperature_rise_k"] == pytest.approx(found["peak_temperature_c"] - 30.0, abs=1e-9)


WARMTH = Arrhenius(activation_energy_j_mol=20000.0)


@pytest.mark.parametrize("name", BATTERIES)
def test_pulses_into_a_cold_battery_close_the_first_law_and_agree_between_drivers(name):
    used = battery(name)
    pairs = {key: one.model_copy(update={"resistance_temperature": WARMTH}) for key, one in used.pairs.items()}
    changes = {"pairs": pairs, "series_resistance_temperature": WARMTH}
    if used.acceptance:
        changes["acceptance"] = used.acceptance.model_copy(update={"resistance_temperature": WARMTH})
    cold = used.model_copy(update=changes)
    knobs = {"charge_c_rate": 0.5, "charge_share": 0.8, "discharge_c_rate": 0.2, "discharge_share": 0.1}
    mode = Mode(title="R", frequency_hz=20.0, phases={"only": {"reflex": {}}}, stop={"elapsed_s": 60.0}, **knobs)
    conditions = settings(0.6, ambient_c=25.0, initial_temperature_c=0.0)
    edge, strides = (values(charge(cold, mode, conditions, engine=EngineSettings(driver=driver))) for driver in DRIVERS)
    assert abs(edge["energy_balance_residual"]) < 1e-7
    assert abs(strides["energy_balance_residual"]) < 1e-6
    fine = EngineSettings(driver="edge", tolerance=1e-11)
    assert abs(values(charge(cold, mode, conditions, engine=fine))["energy_balance_residual"]) < 1e-9
    for name_ in ("end_soc", "end_temperature_c", "energy_in_wh", "energy_out_wh"):
        assert strides[name_] == pytest.approx(edge[name_], rel=1e-6), name_
    plain = values(charge(used, mode, conditions, engine=EngineSettings(driver="edge")))
    # exp(20 kJ/mol / R (1/273 - 1/298)) = 2.1: twice the resistance shows.
    assert edge["energy_in_wh"] > plain["energy_in_wh"]


def test_a_factor_is_one_at_its_reference_and_constant_beyond_a_table():
    compiled = compile_cell(cell(ARRHENIUS, TABLE))
    assert series_ohm(compiled, 0.0, 293.15) == pytest.approx(OHM, rel=1e-14)
    assert series_ohm(compiled, 0.0, 273.15) == pytest.approx(
        OHM * np.exp(24000.0 / GAS * (1 / 273.15 - 1 / 293.15)), rel=1e-13
    )
    for temperature_c, expected in ((-40.0, 3.0), (-10.0, 3.0), (10.0, 1.4), (25.0, 1.0), (45.0, 0.7), (90.0, 0.7)):
        assert pair_ohm(compiled, 0, 0.0, temperature_c + 273.15) == pytest.approx(PAIR_OHM * expected, rel=1e-12)


@pytest.mark.parametrize(
    ("series", "message"),
    [
        ({"temperature_c": [0.0, 10.0], "factor": [1.0, 0.0]}, "each must be greater than 0"),
        ({"temperature_c": [10.0, 0.0], "factor": [1.0, 2.0]}, "temperature_c must rise"),
        ({"temperature_c": [0.0, 10.0], "factor": [1.0]}, "factor"),
    ],
)
def test_factors_that_cannot_be_are_refused(series, message):
    with pytest.raises(ValidationError, match=message):
        cell(series)


def test_a_compensation_that_cannot_be_is_refused():
    sheet = {"title": "Held", "voltage_v": 13.5, "max_current_a": 1.0, "phases": {"only": {"constant_voltage": {}}}}
    stop = {"stop": {"elapsed_s": 100.0}}
    with pytest.raises(ValidationError, match=r"lowest_compensated_c 30 is not below highest_compensated_c 20"):
        Mode(**sheet, **stop, **COMPENSATED | {"lowest_compensated_c": 30.0, "highest_compensated_c": 20.0})
    with pytest.raises(ValidationError, match="needs temperature_coefficient_v_per_k_cell"):
        Mode(**sheet, **stop, highest_compensated_c=20.0)
    kept = Mode(**sheet, **stop, **COMPENSATED)
    assert Mode.model_validate(kept.model_dump()) == kept
    steep = Mode(**sheet, **stop, temperature_coefficient_v_per_k_cell=-0.02)
    with pytest.raises(UserError, match=r"voltage_v: 13.5 V \(12.3 V at its temperature\) does not charge"):
        check(cell(), steep, settings(0.8, ambient_c=35.0))
