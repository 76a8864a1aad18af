"""The replay of a measured current is the engine's cell."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.cell.circuit import CELL, ZERO_CELSIUS_K, compile_cell
from pipeline.cell.records import Arrhenius, Battery, Pair, Polynomial, Thermal
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode, Window
from pipeline.charge.simulate import BENCH, simulate
from pipeline.experiments.own_battery.replay import replays
from pipeline.experiments.validation.plain import constant
from tests.experiments.own_battery.making import card, drive

START_C = 28.0
CASES = {
    # battery: current [A], time [s], spacing [s], bounds of voltage [V] and temperature [K]
    "lfp_8ah": (8.0, 1800, 1.0, 1e-7, 1e-5),
    "lead_acid_12v7ah": (2.1, 3600, 1.0, 1e-6, 1e-5),
    "lead_acid_generic": (2.1, 3600, 1.0, 1e-6, 1e-4),
    "nmc_5ah": (2.5, 3600, 1.0, 1e-7, 1e-5),
    "nicd_2s_600mah": (0.6, 2400, 1.0, 1e-5, 1e-3),
}


def _cells(*batteries: Battery) -> np.ndarray:
    cells = np.zeros(len(batteries), dtype=np.dtype((np.record, CELL)))
    for place, one in enumerate(batteries):
        cells[place] = compile_cell(one)
    return cells


@pytest.mark.parametrize("name", CASES)
def test_a_constant_current_is_that_of_the_engine(name: str) -> None:
    current, seconds, spacing, volts, kelvin = CASES[name]
    battery = card(name)
    window = Window(start_s=seconds - 1.0, length_s=1.0)
    settings = ChargeSettings(
        initial_soc=0.25, ambient_c=25.0, initial_temperature_c=START_C, sample_interval_s=60.0, windows=[window]
    )
    engine = EngineSettings(driver="edge", tolerance=1e-10)
    charge = simulate(battery, constant(current, float(seconds)), BENCH, settings, engine)
    rows = drive([current] * round(seconds / spacing), spacing)
    made = replays(_cells(battery), np.array([0.25]), np.array([START_C + ZERO_CELSIUS_K]), rows)
    assert made.voltage_v[0, -1] == pytest.approx(charge.waveform["voltage_v"][-1], abs=volts)
    assert made.temperature_k[0, -1] - ZERO_CELSIUS_K == pytest.approx(charge.waveform["temperature_c"][-1], abs=kelvin)
    assert 1.0 - made.depth[0, -1] == pytest.approx(charge.waveform["soc"][-1], abs=1e-8)


@pytest.mark.parametrize("name", ["lead_acid_12v7ah", "nicd_2s_600mah"])
def test_overcharge_stays_finite_and_comes_to_the_engine(name: str) -> None:
    battery = card(name)
    rate = {"lead_acid_12v7ah": 0.7, "nicd_2s_600mah": 0.6}[name]
    seconds = 3 * 3600
    charge = simulate(
        battery, constant(rate, float(seconds)), BENCH,
        ChargeSettings(initial_soc=0.9, ambient_c=25.0, windows=[Window(start_s=seconds - 1.0, length_s=1.0)]),
        EngineSettings(driver="edge"),
    )  # fmt: skip
    made = replays(_cells(battery), np.array([0.9]), np.array([25.0 + ZERO_CELSIUS_K]), drive([rate] * seconds, 1.0))
    assert np.isfinite(made.voltage_v).all()
    assert made.depth.min() > 0.0
    assert made.voltage_v[0, -1] == pytest.approx(charge.waveform["voltage_v"][-1], abs=2e-3)


def test_pairs_follow_scipy_for_a_current_straight_in_time() -> None:
    from scipy.integrate import solve_ivp

    tau, slope = (3.0, 70.0), 0.02
    battery = Battery(
        name="two",
        title="Two pairs",
        cells_in_series=1,
        capacity_ah=1.0,
        open_circuit_voltage_v=Polynomial(polynomial=[4.0, -1.0]),
        series_resistance_ohm=0.02,
        series_resistance_temperature=Arrhenius(activation_energy_j_mol=20000.0),
        pairs={
            "fast": Pair(resistance_ohm=Polynomial(polynomial=[0.01, 0.03]), time_constant_s=tau[0]),
            "slow": Pair(resistance_ohm=0.03, time_constant_s=tau[1]),
        },
        thermal=Thermal(heat_capacity_j_k=80.0, resistance_k_w=5.0),
    )
    count, spacing = 300, 1.0
    rows = drive([0.0] * count, spacing)
    straight = slope * rows.time_s
    rows = rows._replace(before_a=straight, after_a=straight, read_a=straight)

    def rates(time: float, y: np.ndarray) -> list[float]:
        x, fast, slow, kelvin = y
        current = slope * time
        factor = math.exp(20000.0 / 8.314462618 * (1.0 / kelvin - 1.0 / 298.15))
        ohm = (0.01 + 0.03 * x, 0.03)
        # C = tau / R changes with x: of the v^2 / 2 stored in it, that part is no heat.
        stored = 0.5 * fast * fast * tau[0] * 0.03 / ohm[0] ** 2 * (current / 3600.0)
        heat = 0.02 * factor * current**2 + fast**2 / ohm[0] - stored + slow**2 / ohm[1]
        return [
            -current / 3600.0, (ohm[0] * current - fast) / tau[0], (ohm[1] * current - slow) / tau[1],
            (heat - (kelvin - 298.15) / 5.0) / 80.0,
        ]  # fmt: skip

    exact = solve_ivp(rates, (0.0, count * spacing), [0.5, 0.0, 0.0, 298.15], rtol=1e-11, atol=1e-13)
    x, fast, slow, kelvin = exact.y[:, -1]
    factor = math.exp(20000.0 / 8.314462618 * (1.0 / kelvin - 1.0 / 298.15))
    expected = 4.0 - x + fast + slow + 0.02 * factor * slope * count
    made = replays(_cells(battery), np.array([0.5]), np.array([298.15]), rows)
    assert made.voltage_v[0, -1] == pytest.approx(expected, abs=2e-6)
    assert made.temperature_k[0, -1] == pytest.approx(kelvin, abs=2e-3)


def test_a_population_is_each_of_its_cells_alone() -> None:
    first, second = card("lead_acid_12v7ah"), card("lead_acid_12v7ah").model_copy(update={"capacity_ah": 9.0})
    rows = drive([1.0] * 200 + [0.0] * 100 + [-2.0] * 100, 1.0)
    start, soc = np.full(2, 298.15), np.array([0.6, 0.4])
    both = replays(_cells(first, second), soc, start, rows)
    for place, battery in enumerate((first, second)):
        alone = replays(_cells(battery), soc[place : place + 1], start[:1], rows)
        np.testing.assert_array_equal(both.voltage_v[place], alone.voltage_v[0])
        np.testing.assert_array_equal(both.temperature_k[place], alone.temperature_k[0])


@pytest.mark.parametrize("name", ["lead_acid_12v7ah", "lfp_8ah", "nmc_5ah"])
def test_a_held_voltage_with_its_limit_is_the_charge_of_the_engine(name: str) -> None:
    battery = card(name)
    rate, volts, soc = {
        "lead_acid_12v7ah": (2.1, 14.4, 0.7),
        "lfp_8ah": (8.0, 3.45, 0.8),
        "nmc_5ah": (2.5, 4.2, 0.8),
    }[name]
    seconds = 5400
    sheet = {"constant_voltage": {"voltage_v": volts, "max_current_a": rate}}
    mode = Mode.model_validate({"title": "charge", "phases": {"charge": sheet}, "stop": {"elapsed_s": seconds}})
    ends = (600.0, 1200.0, 1800.0)
    windows = [Window(start_s=end - 1.0, length_s=1.0) for end in ends]
    settings = ChargeSettings(initial_soc=soc, ambient_c=25.0, sample_interval_s=60.0, windows=windows)
    charge = simulate(battery, mode, BENCH, settings, EngineSettings(driver="edge", tolerance=1e-10))
    rows = drive([99.0] * seconds, 1.0)
    rows = rows._replace(held_v=np.full(seconds + 1, volts), limit_a=np.full(seconds + 1, rate))
    made = replays(_cells(battery), np.array([soc]), np.array([298.15]), rows)
    times = np.asarray(charge.waveform["time_s"])
    for end in ends:
        at = int(np.flatnonzero(times <= end + 1e-6)[-1])
        assert made.current_a[0, int(end)] == pytest.approx(charge.waveform["current_a"][at], rel=2e-3)
        assert made.voltage_v[0, int(end)] == pytest.approx(charge.waveform["voltage_v"][at], abs=2e-4)
        warm_c = made.temperature_k[0, int(end)] - ZERO_CELSIUS_K
        assert warm_c == pytest.approx(charge.waveform["temperature_c"][at], abs=2e-3)
    assert made.current_a[0, 1:].max() == rate
    assert made.current_a[0, -1] < 0.2 * rate


def test_a_charger_that_holds_a_voltage_takes_nothing_back_and_keeps_its_limit() -> None:
    battery = card("lfp_8ah")
    rows = drive([0.0] * 300, 1.0)
    for volts, expected in ((3.0, 0.0), (3.9, 4.0)):
        held = rows._replace(held_v=np.full(301, volts), limit_a=np.full(301, 4.0))
        made = replays(_cells(battery), np.array([0.5]), np.array([298.15]), held)
        np.testing.assert_array_equal(made.current_a[0, 1:], expected)
    with_current = replays(_cells(battery), np.array([0.5]), np.array([298.15]), drive([4.0] * 300, 1.0))
    np.testing.assert_allclose(made.voltage_v[0, 1:], with_current.voltage_v[0, 1:], atol=1e-12)
