"""The engine against PyBaMM's Thevenin model, where it is installed."""

from __future__ import annotations

import importlib
import os
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.experiments.validation.common import (
    Array,
    Case,
    Circuit,
    Trace,
    by_engine,
    common_model,
    compare,
    difference,
)
from pipeline.experiments.validation.records import Found, PeerSettings, Row, at_most, largest

_TOLERANCE = 1e-9
# A jig so heavy that it stays at the ambient temperature.
_JIG_J_K = 1e15


def charged(
    circuit: Circuit, case: Case, time_s: NDArray[np.float64], own_heat: bool
) -> tuple[Trace, NDArray[np.float64]]:
    """Return a charge at given moments, and the energy stored in the pairs of a cell [J].

    Arguments
    ---------
    own_heat : whether a pair's heat is i v, as PyBaMM ships it, energy stored in its capacitor included; else v^2 / R.
    """
    os.environ["PYBAMM_DISABLE_TELEMETRY"] = "true"
    pybamm: Any = importlib.import_module("pybamm")
    model = _model(pybamm, own_heat, len(circuit.pair_ohm))
    values = _parameters(pybamm, circuit, case)
    solver = pybamm.IDAKLUSolver(rtol=_TOLERANCE, atol=1e-12)
    moments = np.unique(np.concatenate([[0.0], time_s, [case.seconds]]))
    if case.limit_v is not None:
        limit_v = case.limit_v / circuit.cells
        steps = (
            pybamm.step.current(-case.current_a, duration=case.seconds, termination=f"{limit_v!r} V"),
            pybamm.step.voltage(limit_v, duration=case.seconds),
        )
        # Without a period the solver keeps its own steps, and its own interpolant between them.
        experiment = pybamm.Experiment([steps], period=None)
        solution = pybamm.Simulation(model, experiment=experiment, parameter_values=values, solver=solver).solve()
    else:
        simulation = pybamm.Simulation(model, parameter_values=values, solver=solver)
        solution = simulation.solve(_edges(case), t_interp=moments)
    names = ("Voltage [V]", "SoC", "Cell temperature [degC]")
    voltage, soc, temperature = (np.asarray(solution[name](time_s), dtype=np.float64) for name in names)
    stored_j = np.zeros_like(time_s)
    for number, (ohm, tau_s) in enumerate(zip(circuit.pair_ohm, circuit.pair_tau_s, strict=True), start=1):
        stored_j += 0.5 * tau_s / ohm * np.asarray(solution[f"Element-{number} overpotential [V]"](time_s)) ** 2
    return Trace(time_s, circuit.cells * voltage, soc, temperature), stored_j


def _edges(case: Case) -> NDArray[np.float64]:
    """Return the moments at which the current jumps: the solver starts anew there."""
    if case.frequency_hz == 0.0:
        return np.array([0.0, case.seconds])
    periods = np.arange(round(case.seconds * case.frequency_hz))
    found = np.concatenate([periods, periods + case.share]) / case.frequency_hz
    return np.append(np.sort(found), case.seconds)


def _model(pybamm: Any, own_heat: bool, pairs: int) -> Any:
    options = {"number of rc elements": pairs}
    if own_heat:
        return pybamm.equivalent_circuit.Thevenin(options=options)

    class Dissipating(pybamm.equivalent_circuit_elements.RCElement):  # type: ignore[misc]
        """A pair whose heat is what its resistance dissipates."""

        def get_coupled_variables(self, variables: dict[str, Any]) -> dict[str, Any]:
            variables = super().get_coupled_variables(variables)
            number = self.element_number
            over = variables[f"Element-{number} overpotential [V]"]
            heat = over**2 / variables[f"R{number} [Ohm]"]
            variables[f"Element-{number} irreversible heat generation [W]"] = heat
            return variables

    class Thevenin(pybamm.equivalent_circuit.Thevenin):  # type: ignore[misc]
        """The shipped model with such pairs."""

        def set_rc_submodels(self) -> None:
            for _ in range(self.options["number of rc elements"]):
                name = f"Element-{self.element_counter} (RC)"
                self.submodels[name] = Dissipating(self.param, self.element_counter, self.options)
                self.element_counter += 1

    return Thevenin(options=options)


def _parameters(pybamm: Any, circuit: Circuit, case: Case) -> Any:
    full_v, slope_v = circuit.open_v
    full_ohm, slope_ohm = circuit.series_ohm

    def open_v(soc: Any) -> Any:
        return full_v + slope_v * (1.0 - soc)

    def series_ohm(temperature: Any, current: Any, soc: Any) -> Any:
        return full_ohm + slope_ohm * (1.0 - soc)

    values = pybamm.ParameterValues("ECM_Example")
    ambient_k = case.ambient_c + ZERO_CELSIUS_K
    steady = case.frequency_hz == 0.0
    found = {
        "Initial SoC": case.initial_soc,
        "Initial temperature [K]": ambient_k,
        "Ambient temperature [K]": ambient_k,
        "Cell capacity [A.h]": circuit.capacity_ah,
        "Nominal cell capacity [A.h]": circuit.capacity_ah,
        "Current function [A]": -case.current_a if steady else _pulses(pybamm, case),
        "Upper voltage cut-off [V]": 100.0,
        "Lower voltage cut-off [V]": 0.0,
        "Cell thermal mass [J/K]": circuit.heat_capacity_j_k,
        "Cell-jig heat transfer coefficient [W/K]": 1.0 / circuit.thermal_resistance_k_w,
        "Jig thermal mass [J/K]": _JIG_J_K,
        "Jig-air heat transfer coefficient [W/K]": 1.0,
        "Open-circuit voltage [V]": open_v,
        "R0 [Ohm]": series_ohm,
        "Entropic change [V/K]": 0.0,
        "Element-0 initial overpotential [V]": 0.0,
    }
    for number, (ohm, tau_s) in enumerate(zip(circuit.pair_ohm, circuit.pair_tau_s, strict=True), start=1):
        found |= {
            f"R{number} [Ohm]": ohm,
            f"C{number} [F]": tau_s / ohm,
            f"Element-{number} initial overpotential [V]": 0.0,
        }
    values.update(found, check_already_exists=False)
    return values


def _pulses(pybamm: Any, case: Case) -> Any:
    def current(time_s: Any) -> Any:
        period_s = 1.0 / case.frequency_hz
        return -case.current_a * (pybamm.Modulo(time_s, period_s) < case.share * period_s)

    return current


BOUNDS = {"voltage": 1e-6, "SOC": 1e-8, "temperature": 1e-6}


def check(settings: Mapping[str, Any]) -> Found:
    """Return how far CC, CC-CV and pulses are apart.

    PyBaMM counts current times voltage of a pair as heat, what its capacitor stores included; here it is v^2 / R. So
    its temperature is compared twice: with pairs that dissipate v^2 / R, which must agree, and as shipped, where the
    difference must be what the energy stored at each moment comes to.
    """
    given = PeerSettings.model_validate(settings)
    found = compare(given, BOUNDS, lambda own, case, time_s: charged(own, case, time_s, False)[0])
    if given.version is None:
        return found
    cell, own, chosen = common_model(given)
    for case in chosen:
        ours = by_engine(cell, case)
        theirs, stored_j = charged(own, case, ours.time_s, True)
        gap = theirs.temperature_c - ours.temperature_c
        stored_k = rise_of(own, ours.time_s, stored_j)
        name = f"{case.name}: temperature, i v as heat"
        found.rows.append(Row(name, largest(gap), "K"))
        found.rows.append(at_most(f"{name}, less the energy stored", largest(gap - stored_k), 1e-6, "K"))
        found.curves.append(difference(case, "temperature", "i v as heat, as shipped", ours.time_s, gap))
        found.curves.append(difference(case, "temperature", "of the energy stored", ours.time_s, stored_k))
    return found


def rise_of(own: Circuit, time_s: Array, stored_j: Array) -> Array:
    """Return the rise of the temperature if stored energy is counted as heat [K]: the lump's answer to its rate."""
    lag_s = own.heat_capacity_j_k * own.thermal_resistance_k_w
    weighted = stored_j * np.exp(time_s / lag_s)
    lost = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time_s) * (weighted[1:] + weighted[:-1]))])
    rise_k: Array = (stored_j - np.exp(-time_s / lag_s) * lost / lag_s) / own.heat_capacity_j_k
    return rise_k
