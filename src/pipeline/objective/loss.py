"""Where the power of a Reflex charge goes, by frequency: ripple, switching, mean current, discharge resistor."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.objective.records import Pairs, Problem, Transistor, Waveform
from pipeline.objective.ripple import Steps, mean_current_a, pair_loss_w, ripple_square_a2, steps, switched_currents_a

Array = NDArray[np.float64]


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
