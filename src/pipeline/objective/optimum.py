"""The loss over the frequency of a Reflex charge; its optimum, how flat it is, and what moves it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.objective.records import Pairs, Problem, Transistor, Waveform


class Steps(NamedTuple):
    """One period: the currents [A] and the shares of the period [1] they last, in order; the shares sum to 1."""

    current_a: tuple[float, ...]
    share: tuple[float, ...]


def steps(waveform: Waveform) -> Steps:
    """Return the parts of one period that have a length: charge, discharge, rest."""
    rest = 1.0 - waveform.charge_share - waveform.discharge_share
    parts = (
        (waveform.charge_a, waveform.charge_share),
        (-waveform.discharge_a, waveform.discharge_share),
        (0.0, rest),
    )
    kept = [(current, share) for current, share in parts if share > 1e-12]
    return Steps(tuple(current for current, _ in kept), tuple(share for _, share in kept))


def mean_current_a(period: Steps) -> float:
    """Return the mean current [A]."""
    return float(np.dot(period.current_a, period.share))


def ripple_square_a2(period: Steps) -> float:
    """Return the mean square of the current less its mean [A^2]: the sum of 2 |c_n|^2 over all harmonics."""
    ripple = np.asarray(period.current_a) - mean_current_a(period)
    return float(np.dot(ripple**2, period.share))


def switched_currents_a(waveform: Waveform) -> tuple[float, ...]:
    """Return the current [A] that each switch in use turns on and off once in a period."""
    switched: list[float] = []
    if waveform.charge_share < 1.0:
        switched.append(waveform.charge_a)
    if waveform.discharge_a > 0.0 and waveform.discharge_share > 0.0:
        switched.append(waveform.discharge_a)
    return tuple(switched)


Values = TypeVar("Values", bound=NDArray[Any])

_COMPLEX_STEP = 1e-30


def passed_square_a2(period: Steps, cycles: Values) -> Values:
    """Return the mean square of the ripple current through a pair's resistor.

    Arguments
    ---------
    period : the current.
    cycles : frequency times time constant [1], any shape, above 0; complex values pass through.

    Returns
    -------
    Mean square [A^2], same shape: the ripple's own as `cycles` goes to 0, falling with its inverse square at the end.
    Rounding grows with that square, to 1e-8 of the result at 1e3 cycles, where a pair passes nearly nothing.
    """
    ripple = np.asarray(period.current_a) - mean_current_a(period)
    lengths = [share / cycles for share in period.share]  # of each part, in time constants
    risen = [-np.expm1(-length) for length in lengths]
    # The state where the period begins, from the condition that it ends there too.
    gained, left = risen[-1] * ripple[-1], 1.0 - risen[-1]
    for current, rise in zip(ripple[-2::-1], risen[-2::-1], strict=True):
        gained = gained + left * rise * current
        left = left * (1.0 - rise)
    state = gained / -np.expm1(-1.0 / cycles)
    total = np.zeros_like(cycles)
    for current, length, rise in zip(ripple, lengths, risen, strict=True):
        total += current * (current * length - (current - state) * rise)
        state = state + (current - state) * rise
    result: Values = total * cycles
    return result


def pair_loss_w(period: Steps, pairs: Pairs, frequency_hz: ArrayLike) -> Array:
    """Return the loss of the ripple in all pairs together.

    Arguments
    ---------
    period : the current.
    pairs : the battery's pairs.
    frequency_hz : frequencies of the period [Hz], any shape, above 0.

    Returns
    -------
    Loss beside that of the mean current [W], same shape.
    """
    frequency = np.asarray(frequency_hz, dtype=float)
    loss = np.zeros(frequency.shape)
    for resistance, time_constant in zip(*pairs, strict=True):
        loss += resistance * passed_square_a2(period, frequency * time_constant)
    return loss


def pair_slope_j(period: Steps, pairs: Pairs, frequency_hz: ArrayLike) -> Array:
    """Return the derivative of `pair_loss_w` by frequency [W/Hz = J], exact to rounding.

    The closed form is analytic, so its imaginary part after an imaginary step is the derivative without a difference
    (Squire and Trapp, SIAM Rev. 40 (1998) 110, DOI 10.1137/S003614459631241X).
    """
    frequency = np.asarray(frequency_hz, dtype=float)
    slope = np.zeros(frequency.shape)
    for resistance, time_constant in zip(*pairs, strict=True):
        cycles = frequency * time_constant
        moved = passed_square_a2(period, cycles + 1j * _COMPLEX_STEP)
        slope += resistance * time_constant * moved.imag / _COMPLEX_STEP
    return slope


def impedance_ohm(
    frequency_hz: float, inductance_h: float, series_ohm: float, pair_ohm: float, pair_f: float
) -> complex:
    """Return the impedance [ohm] of inductance, series resistance and one pair at a frequency [Hz]."""
    omega = 2.0 * math.pi * frequency_hz
    return 1j * omega * inductance_h + series_ohm + pair_ohm / (1.0 + 1j * omega * pair_ohm * pair_f)


def impedance_minimum_hz(inductance_h: float, series_ohm: float, pair_ohm: float, pair_f: float) -> float:
    """Return the frequency of least |Z|.

    Arguments
    ---------
    inductance_h : inductance of battery and leads [H].
    series_ohm : series resistance R_0 [ohm].
    pair_ohm, pair_f : charge-transfer resistance R [ohm] and double-layer capacitance C [F].

    Returns
    -------
    Frequency [Hz] from d|Z|^2/dw = 0; 0 where |Z| rises from direct current on.
    """
    time_constant = pair_ohm * pair_f
    root = math.sqrt(
        2.0 * inductance_h * pair_ohm**2 * pair_f + pair_ohm**3 * pair_f**2 * (2.0 * series_ohm + pair_ohm)
    )
    square = (root / inductance_h - 1.0) / time_constant**2
    return math.sqrt(max(square, 0.0)) / (2.0 * math.pi)


def resonance_hz(inductance_h: float, pair_ohm: float, pair_f: float) -> float:
    """Return the frequency [Hz] at which Z is real, 1/(L C) - 1/(R C)^2 = w^2; 0 where there is none."""
    square = 1.0 / (inductance_h * pair_f) - 1.0 / (pair_ohm * pair_f) ** 2
    return math.sqrt(max(square, 0.0)) / (2.0 * math.pi)


Array = NDArray[np.float64]

_BISECTIONS = 50  # of nine decades: 2e-14 of the frequency


class Band(NamedTuple):
    """The frequencies [Hz] between which an objective stays within a share of its minimum."""

    low_hz: float
    high_hz: float


def optimal_frequency_hz(
    period: Steps, pairs: Pairs, energy_j: ArrayLike, low_hz: float = 1e-3, high_hz: float = 1e6
) -> Array:
    """Return the frequency of least loss for each switching energy.

    Arguments
    ---------
    period : the current.
    pairs : the battery's pairs.
    energy_j : switching energies of a period [J], any shape, above 0.
    low_hz, high_hz : where to look [Hz].

    Returns
    -------
    Frequency [Hz], same shape; the loss falls and then rises, so it is the only one. NaN where it lies outside.
    """
    energy = np.asarray(energy_j, dtype=float)
    return _bisected(lambda frequency: pair_slope_j(period, pairs, frequency) + energy, energy.shape, low_hz, high_hz)


def energy_for_optimum_j(period: Steps, pairs: Pairs, frequency_hz: ArrayLike) -> Array:
    """Return the switching energy [J] with which each frequency [Hz] would be the best: the contours of the map."""
    return -pair_slope_j(period, pairs, frequency_hz)


def band_hz(period: Steps, pairs: Pairs, energy_j: float, share: float) -> Band:
    """Return the band around the optimum in which the ISE exceeds its minimum by at most a share.

    Arguments
    ---------
    period : the current.
    pairs : the battery's pairs.
    energy_j : switching energy of a period [J].
    share : allowed excess over the minimum [1].

    Returns
    -------
    Both ends [Hz]; the window of the integral cancels.
    """
    best = float(optimal_frequency_hz(period, pairs, energy_j))
    limit = np.sqrt(1.0 + share) * frequency_loss_w(period, pairs, energy_j, best)

    def over(frequency: Array) -> Array:
        excess: Array = frequency_loss_w(period, pairs, energy_j, frequency) - limit
        return excess

    low = _bisected(lambda frequency: -over(frequency), (), 1e-6 * best, best)
    high = _bisected(over, (), best, 1e6 * best)
    return Band(float(low), float(high))


def frequency_map_hz(period: Steps, pairs: Pairs, pair: int, capacitance_f: Array, energy_j: Array) -> Array:
    """Return the best frequency over one pair's capacitance and the switching energy.

    Arguments
    ---------
    period : the current.
    pairs : the battery's pairs.
    pair : index of the pair whose capacitance varies, its resistance kept.
    capacitance_f : capacitances [F], shape (m,).
    energy_j : switching energies of a period [J], shape (n,).

    Returns
    -------
    Frequency [Hz], shape (m, n).
    """
    rows = [optimal_frequency_hz(period, with_capacitance(pairs, pair, value), energy_j) for value in capacitance_f]
    return np.stack(rows)


def contour_energy_j(period: Steps, pairs: Pairs, pair: int, capacitance_f: Array, frequency_hz: float) -> Array:
    """Return, for each capacitance [F], the switching energy [J] that puts the optimum at a frequency: one contour."""
    found = [
        energy_for_optimum_j(period, with_capacitance(pairs, pair, value), frequency_hz) for value in capacitance_f
    ]
    return np.array(found, dtype=float)


def with_capacitance(pairs: Pairs, pair: int, capacitance_f: float) -> Pairs:
    """Return the pairs with another capacitance [F] of one of them."""
    constants = list(pairs.time_constant_s)
    constants[pair] = pairs.resistance_ohm[pair] * float(capacitance_f)
    return pairs._replace(time_constant_s=tuple(constants))


def _bisected(rising: Callable[[Array], Array], shape: tuple[int, ...], low_hz: float, high_hz: float) -> Array:
    """Return where a function that rises through zero does so, all entries together, on a logarithmic axis."""
    low, high = np.full(shape, np.log(low_hz)), np.full(shape, np.log(high_hz))
    inside = (rising(np.exp(low)) <= 0.0) & (rising(np.exp(high)) >= 0.0)
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        above = rising(np.exp(middle)) > 0.0
        high = np.where(above, middle, high)
        low = np.where(above, low, middle)
    found: Array = np.where(inside, np.exp(0.5 * (low + high)), np.nan)
    return found


def switching_energy_j(transistor: Transistor, switched_currents_a: tuple[float, ...]) -> float:
    """Return the energy the switches take in one period.

    Arguments
    ---------
    transistor : data of each switch.
    switched_currents_a : the current each switch in use turns on and off once [A].

    Returns
    -------
    Energy [J]: overlap of voltage and current at both edges, the output capacitance, the gate's charge (Erickson and
    Maksimovic, Fundamentals of Power Electronics, section 4.3, DOI 10.1007/b100747).
    """
    overlap_s = transistor.rise_time_s + transistor.fall_time_s
    overlap_j = 0.5 * transistor.blocked_voltage_v * overlap_s * sum(switched_currents_a)
    capacitance_j = 0.5 * transistor.output_capacitance_f * transistor.blocked_voltage_v**2
    gate_j = transistor.gate_charge_c * transistor.gate_voltage_v
    return overlap_j + len(switched_currents_a) * (capacitance_j + gate_j)


def frequency_loss_w(period: Steps, pairs: Pairs, energy_j: float, frequency_hz: ArrayLike) -> Array:
    """Return the loss that depends on frequency [W]: the ripple's in the pairs and the switching."""
    return pair_loss_w(period, pairs, frequency_hz) + energy_j * np.asarray(frequency_hz, dtype=float)


def discharge_resistor_loss_w(waveform: Waveform, battery_voltage_v: float) -> float:
    """Return the mean power that the discharging part takes out of the battery into the resistor [W]."""
    return battery_voltage_v * waveform.discharge_a * waveform.discharge_share


def breakdown(
    period: Steps, pairs: Pairs, series_resistance_ohm: float, energy_j: float, frequency_hz: ArrayLike
) -> dict[str, Array]:
    """Return every part of the loss over frequency.

    Arguments
    ---------
    period : the current.
    pairs : the battery's pairs.
    series_resistance_ohm : R_0 of the battery [ohm]; its ripple loss does not depend on frequency.
    energy_j : switching energy of a period [J].
    frequency_hz : frequencies [Hz], shape (n,).

    Returns
    -------
    Columns [W], shape (n,) each; `total_w` is all of it but the loss of the mean current.
    """
    frequency = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
    mean_square = mean_current_a(period) ** 2
    columns = {
        "frequency_hz": frequency,
        "mean_current_w": np.full(frequency.shape, mean_square * (series_resistance_ohm + sum(pairs.resistance_ohm))),
        "series_ripple_w": np.full(frequency.shape, ripple_square_a2(period) * series_resistance_ohm),
        "pair_ripple_w": pair_loss_w(period, pairs, frequency),
        "switching_w": energy_j * frequency,
    }
    columns["total_w"] = columns["series_ripple_w"] + columns["pair_ripple_w"] + columns["switching_w"]
    return columns


MILLIWATT_PER_WATT = 1e3


def error_mw(period: Steps, pairs: Pairs, energy_j: float, frequency_hz: ArrayLike) -> Array:
    """Return e [mW], the loss at infinite frequency without switching less the loss there is; never positive."""
    return -MILLIWATT_PER_WATT * frequency_loss_w(period, pairs, energy_j, frequency_hz)


def integral_square_error(error: ArrayLike, window_s: float) -> Array:
    """Return the integral of a constant error's square over the window [mW^2 s] (eq. 5)."""
    return np.asarray(error, dtype=float) ** 2 * window_s


def objective(period: Steps, pairs: Pairs, energy_j: float, window_s: float) -> Callable[[Array], Array]:
    """Return the function a search minimises: positions (n, 1), the frequency [Hz], to ISE (n,) [mW^2 s]."""

    def evaluate(position: Array) -> Array:
        return integral_square_error(error_mw(period, pairs, energy_j, position[:, 0]), window_s)

    return evaluate


def objective_of(problem: Problem) -> Callable[[Array], Array]:
    """Return the function a search minimises, from its record."""
    energy = switching_energy_j(problem.transistor, switched_currents_a(problem.waveform))
    return objective(steps(problem.waveform), problem.pairs, energy, problem.window_s)
