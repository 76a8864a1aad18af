"""The closed form against exact solutions, an integrated circuit, the Fourier series and its own limits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from pipeline.objective.optimum import (
    Steps,
    mean_current_a,
    pair_loss_w,
    pair_slope_j,
    passed_square_a2,
    ripple_square_a2,
    steps,
    switched_currents_a,
)
from pipeline.objective.records import Pairs, Waveform

CYCLES = np.geomspace(1e-3, 1e3, 61)


@st.composite
def waveforms(draw):
    charge_share = draw(st.floats(0.05, 0.95))
    discharge_share = draw(st.floats(0.0, 1.0)) * (0.99 - charge_share)
    return Waveform(
        charge_a=draw(st.floats(0.1, 20.0)),
        charge_share=charge_share,
        discharge_a=draw(st.floats(0.0, 20.0)),
        discharge_share=max(discharge_share, 0.0),
    )


def fourier(period: Steps, cycles: float, harmonics: int) -> float:
    n = np.arange(1, harmonics + 1)
    ends = np.cumsum(period.share)
    starts = ends - np.asarray(period.share)
    coefficient = sum(
        current * (np.exp(-2j * np.pi * n * start) - np.exp(-2j * np.pi * n * end)) / (2j * np.pi * n)
        for current, start, end in zip(period.current_a, starts, ends, strict=True)
    )
    return float(np.sum(2.0 * np.abs(coefficient) ** 2 / (1.0 + (2.0 * np.pi * n * cycles) ** 2)))


def test_square_wave_is_the_textbook_solution():
    # +-1 A, half a period each: y runs between -tanh and tanh of a quarter period, and mean(y^2) follows.
    half = 1.0 / (2.0 * CYCLES)
    expected = 1.0 - np.tanh(half / 2.0) / (half / 2.0)
    found = passed_square_a2(Steps((1.0, -1.0), (0.5, 0.5)), CYCLES)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=1e-15)


@pytest.mark.parametrize("frequency", [1.0, 26.5, 90.0, 500.0])
def test_loss_is_that_of_the_integrated_circuit(reflex, frequency):
    period, pair = steps(reflex), Pairs((0.015,), (0.006,))
    resistance, time_constant = pair.resistance_ohm[0], pair.time_constant_s[0]
    mean = mean_current_a(period)
    periods = int(np.ceil(40 * time_constant * frequency)) + 1
    voltage, energy = 0.0, 0.0
    for number in range(periods):
        for current, share in zip(period.current_a, period.share, strict=True):
            drive = resistance * (current - mean)
            solved = solve_ivp(
                lambda _, y, drive=drive: [(drive - y[0]) / time_constant, y[0] ** 2 / resistance],
                (0.0, share / frequency),
                [voltage, 0.0],
                method="DOP853",
                rtol=1e-11,
                atol=1e-16,
            )
            voltage = solved.y[0, -1]
            energy += solved.y[1, -1] if number == periods - 1 else 0.0
    assert pair_loss_w(period, pair, frequency) == pytest.approx(energy * frequency, rel=1e-8)


def test_loss_is_the_limit_of_the_fourier_sum(reflex):
    period = steps(reflex)
    for cycles in (0.006, 0.54, 5.4):
        exact = float(passed_square_a2(period, np.array(cycles)))
        missing = [exact - fourier(period, cycles, harmonics) for harmonics in (1_000, 10_000, 100_000)]
        assert missing[0] > missing[1] > missing[2] > -1e-14, "a truncated series lies below the closed form"
        assert missing[2] < 1e-8 * exact


def test_a_truncated_series_loses_part_of_the_ripple(reflex):
    # 25 mOhm under 4000 harmonics: 12.578 mW of 12.582 mW.
    period = steps(reflex)
    assert 25.0 * ripple_square_a2(period) == pytest.approx(12.582, abs=5e-4)
    assert 25.0 * fourier(period, 0.0, 4000) == pytest.approx(12.578, abs=5e-4)


@given(waveforms())
def test_ripple_passes_whole_at_low_and_not_at_high_frequency(waveform):
    period = steps(waveform)
    whole = ripple_square_a2(period)
    passed = passed_square_a2(period, CYCLES)
    assert passed_square_a2(period, np.array(1e-13)) == pytest.approx(whole, rel=1e-6, abs=1e-9)
    assert np.all(passed <= whole * (1.0 + 1e-12))
    assert np.all(np.diff(passed) <= 1e-12 * whole)


@given(waveforms())
def test_high_frequency_leaves_the_mean_square_of_the_charge(waveform):
    # At high frequency y is the integral of the ripple over tau: mean(y^2) (f tau)^2 is that of a piecewise line.
    period = steps(waveform)
    lengths = np.asarray(period.share)
    ripple = np.asarray(period.current_a) - mean_current_a(period)
    at_end = np.cumsum(ripple * lengths)
    at_start = at_end - ripple * lengths
    mean = np.dot(0.5 * (at_start + at_end), lengths)
    a, b = at_start - mean, at_end - mean
    expected = np.dot((a * a + a * b + b * b) / 3.0, lengths)
    assert passed_square_a2(period, np.array(300.0)) * 300.0**2 == pytest.approx(expected, rel=1e-4, abs=1e-7)


@pytest.mark.parametrize("frequency", [0.954, 10.0, 90.0, 1000.0])
def test_slope_is_the_derivative(reflex, pairs, frequency):
    period, step = steps(reflex), 1e-4 * frequency
    around = pair_loss_w(period, pairs, [frequency - step, frequency + step])
    assert pair_slope_j(period, pairs, frequency) == pytest.approx((around[1] - around[0]) / (2.0 * step), rel=1e-6)


def test_loss_bends_upwards_everywhere_so_that_there_is_one_minimum(reflex):
    slope = pair_slope_j(steps(reflex), Pairs((1.0,), (1.0,)), CYCLES)
    assert np.all(slope < 0.0)
    assert np.all(np.diff(slope) > -1e-12)


def test_populations_of_any_shape_come_out_as_one_by_one(reflex, pairs):
    period = steps(reflex)
    frequencies = np.linspace(1.0, 500.0, 24).reshape(2, 3, 4)
    together = pair_loss_w(period, pairs, frequencies)
    assert together.shape == (2, 3, 4)
    for index in np.ndindex(2, 3, 4):
        assert together[index] == pytest.approx(float(pair_loss_w(period, pairs, frequencies[index])), rel=1e-13)


def test_order_and_zero_lengths_of_the_parts(reflex):
    assert steps(Waveform(charge_a=2.0, charge_share=1.0)) == Steps((2.0,), (1.0,))
    assert passed_square_a2(steps(Waveform(charge_a=2.0, charge_share=1.0)), np.array(0.5)) == 0.0
    rest = steps(Waveform(charge_a=2.1, charge_share=0.9))
    assert rest.current_a == (2.1, 0.0)
    # A wave and its reverse in time lose the same, whatever the order of its parts.
    period = steps(reflex)
    reversed_ = Steps(period.current_a[::-1], period.share[::-1])
    np.testing.assert_allclose(passed_square_a2(reversed_, CYCLES), passed_square_a2(period, CYCLES), rtol=1e-7)


def test_each_switch_in_use_switches_its_own_current(reflex):
    assert switched_currents_a(reflex) == (2.1, 0.5)
    assert switched_currents_a(Waveform(charge_a=2.33, charge_share=0.8)) == (2.33,)
    assert switched_currents_a(Waveform(charge_a=2.1, charge_share=1.0)) == ()
