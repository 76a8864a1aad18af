"""Energy by path: what the end of a step adds, and the balance of a whole charge against state functions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import Cell, enthalpy, hysteresis_at, pair_ohm
from pipeline.cell.relaxation import RADAU, fill_moments
from pipeline.charge.state import (
    CHARGE,
    DEPTH,
    ELECTRICAL,
    ETA,
    HYSTERESIS,
    HYSTERESIS_HEAT,
    HYSTERESIS_V,
    MAIN,
    OHM,
    PAIR_HEAT,
    RELAXATIONS,
    REVERSIBLE,
    REVERSIBLE_HEAT,
    SERIES_HEAT,
    SIDE,
    SIDE_CHARGE,
    SIDE_HEAT,
    SLOW_V,
    TEMPERATURE,
    TO_AMBIENT,
    TOTAL,
    TRANSFER_HEAT,
    VOLTAGE_TIME,
    Run,
    T,
)
from pipeline.jit import inlined


def pair_stores(cell: Cell, state: NDArray[np.float64]) -> list[float]:
    """Return C v^2 / 2 of each pair, the acceptance pair last, for the whole battery [J]."""
    stores = []
    for k in range(cell.pairs + cell.acceptance):
        resistance = pair_ohm(cell, k, float(state[DEPTH]), float(state[TEMPERATURE]))
        voltage = float(state[RELAXATIONS + k])
        stores.append(cell.cells * 0.5 * cell.tau_s[k] * voltage * voltage / resistance if resistance > 0 else 0.0)
    return stores


def gas_store(cell: Cell, state: NDArray[np.float64]) -> float:
    """Return the energy of gas not yet recombined, for the whole battery [J]."""
    if not cell.recombination:
        return 0.0
    return float(cell.cells * cell.gas_v * cell.tau_s[cell.relaxations - 1] * state[RELAXATIONS + cell.relaxations - 1])


def balance(
    cell: Cell,
    gains: NDArray[np.float64],
    before: NDArray[np.float64],
    after: NDArray[np.float64],
    pairs: Sequence[str],
) -> dict[str, Any]:
    """Return the rows of the energy table.

    The residual is electrical energy less every change of a state function less the heat to the ambient; the heat that
    warmed the battery was added up from the dissipations, so the residual shows what they miss.

    Arguments
    ---------
    gains : sums over the run, (10 + relaxations,).
    before, after : states, (3 + relaxations,).
    pairs : names of the pairs.
    """
    chemical = cell.cells * (enthalpy(cell, after[DEPTH]) - enthalpy(cell, before[DEPTH]))
    stored = np.array(pair_stores(cell, after)) - np.array(pair_stores(cell, before))
    gas = gas_store(cell, after) - gas_store(cell, before)
    sensible = cell.heat_capacity_j_k * (after[TEMPERATURE] - before[TEMPERATURE])
    names = [*pairs, *(["acceptance"] if cell.acceptance else [])]
    residual = gains[ELECTRICAL] - chemical - stored.sum() - gas - sensible - gains[TO_AMBIENT]
    rows = [
        ("electrical", "input", gains[ELECTRICAL], "electrical energy put in, less that taken out"),
        ("chemical", "stored", chemical, "change of the stored chemical energy H(SOC)"),
        *((f"pair {n} store", "stored", e, "change of C v^2 / 2") for n, e in zip(names, stored, strict=True)),
        ("gas", "stored", gas, "change of the energy of gas not yet recombined"),
        ("series resistance", "loss", gains[SERIES_HEAT], "R0 I^2"),
        *((f"pair {name}", "loss", gains[PAIR_HEAT + k], "v^2 / R - (v^2 / 2) dC/dt") for k, name in enumerate(names)),
        ("charge transfer", "loss", gains[TRANSFER_HEAT], "overpotential times main current"),
        *([("hysteresis", "loss", gains[HYSTERESIS_HEAT], "hysteresis times main current")] if cell.hysteresis else []),
        ("side reaction", "loss", gains[SIDE_HEAT], "side current times voltage, less energy of the gas"),
        ("reversible", "loss", gains[REVERSIBLE_HEAT], "main current times T dU/dT"),
        ("sensible", "heat", sensible, "heat that warmed the battery"),
        ("ambient", "heat", gains[TO_AMBIENT], "heat to the ambient"),
        ("residual", "residual", residual, "electrical less stored, less heat"),
    ]
    path, role, energy, description = zip(*rows, strict=True)
    return {
        "path": list(path),
        "role": list(role),
        "energy_j": np.array(energy, dtype=np.float64),
        "description": list(description),
    }


@inlined
def finish(cell: Cell, run: Run, slot: int, bypassed: bool, ambient_k: float) -> None:
    """Write the state at the end and what the step adds, exact for quadratic currents and exponential voltages."""
    at, gain, end, state = run.at, run.gain, run.end, run.state
    if run.moments_s[slot] != run.length_s[slot]:
        fill_moments(run, slot, cell.tau_s, cell.relaxations)
    h, n = run.length_s[slot], cell.cells
    # Sums in local names: the record's own cells would be stored and loaded again at every addition.
    main_as = total_as = side_as = voltage_vs = electrical = series = transfer = reversible = side_heat = warm_ks = 0.0
    hysteresis = 0.0
    for j in range(3):
        b = h * RADAU[2, j]
        main, side, ohm = at[MAIN, j], at[SIDE, j], at[OHM, j]
        slow_v, total = at[SLOW_V, j] + at[ETA, j], at[TOTAL, j]
        main_as += b * main
        total_as += b * total
        side_as += b * side
        voltage_vs += b * (slow_v + ohm * total)
        electrical += b * (slow_v + ohm * total) * total
        series += b * ohm * total * total
        transfer += b * at[ETA, j] * main
        hysteresis += b * at[HYSTERESIS_V, j] * main
        reversible += b * at[REVERSIBLE, j]
        side_heat += b * side * slow_v
        warm_ks += b * (at[T, j] - ambient_k)
    end[DEPTH] = state[DEPTH] - main_as / cell.charge_as
    if cell.hysteresis == 1:
        end[HYSTERESIS], _ = hysteresis_at(cell, state[HYSTERESIS], end[DEPTH] - state[DEPTH])
    pair_heat = 0.0
    for k in range(cell.pairs + cell.acceptance):
        through = bypassed and k == cell.pairs
        heat, part_vs, part_j, part_side = _finish_pair(cell, run, slot, k, state[RELAXATIONS + k], through)
        gain[PAIR_HEAT + k] = n * heat
        pair_heat += heat
        voltage_vs += part_vs
        electrical += part_j
        side_heat += part_side
    if cell.recombination == 1:
        k = cell.relaxations - 1
        w = run.node[slot, k]
        before = state[RELAXATIONS + k]
        end[RELAXATIONS + k] = (
            run.decay[slot, k, 2] * before + w[0, 2] * at[SIDE, 0] + w[1, 2] * at[SIDE, 1] + w[2, 2] * at[SIDE, 2]
        )
        side_heat -= cell.gas_v * cell.tau_s[k] * (end[RELAXATIONS + k] - before)
    to_ambient = warm_ks / cell.thermal_resistance_k_w
    heat = n * (series + transfer + hysteresis + reversible + side_heat + pair_heat)
    end[TEMPERATURE] = state[TEMPERATURE] + (heat - to_ambient) / cell.heat_capacity_j_k
    gain[CHARGE], gain[SIDE_CHARGE], gain[TO_AMBIENT] = total_as, side_as, to_ambient
    gain[VOLTAGE_TIME], gain[ELECTRICAL] = n * voltage_vs, n * electrical
    gain[SERIES_HEAT], gain[TRANSFER_HEAT], gain[HYSTERESIS_HEAT] = n * series, n * transfer, n * hysteresis
    gain[REVERSIBLE_HEAT], gain[SIDE_HEAT] = n * reversible, n * side_heat


@inlined
def _finish_pair(
    cell: Cell, run: Run, slot: int, k: int, before: float, bypassed: bool
) -> tuple[float, float, float, float]:
    """Advance one pair of one cell over the step.

    int v^2 dt = int v g dt - (tau/2) change of v^2; what the slow factor 1/R changes over the step meets
    v exactly once and once by its values at the nodes.

    Returns
    -------
    Its heat [J], the integral of its voltage [V s], its energy from the total current and from the side current [J].
    """
    at = run.at
    if bypassed:
        run.end[RELAXATIONS + k] = 0.0
        return 0.0, 0.0, 0.0, 0.0
    g0 = run.resistance[k, 0] * at[MAIN, 0]
    g1 = run.resistance[k, 1] * at[MAIN, 1]
    g2 = run.resistance[k, 2] * at[MAIN, 2]
    w, decay, s, m = run.node[slot, k], run.decay[slot, k, 2], run.start_moment[slot, k], run.moment[slot, k]
    after = decay * before + w[0, 2] * g0 + w[1, 2] * g1 + w[2, 2] * g2
    run.end[RELAXATIONS + k] = after
    # Integral of the voltage times the basis function of each node.
    v0 = s[0] * before + m[0, 0] * g0 + m[1, 0] * g1 + m[2, 0] * g2
    v1 = s[1] * before + m[0, 1] * g0 + m[1, 1] * g1 + m[2, 1] * g2
    v2 = s[2] * before + m[0, 2] * g0 + m[1, 2] * g1 + m[2, 2] * g2
    squared = v0 * g0 + v1 * g1 + v2 * g2 - 0.5 * cell.tau_s[k] * (after * after - before * before)
    c0, c1, c2 = run.conductance[k, 0], run.conductance[k, 1], run.conductance[k, 2]
    mean = RADAU[2, 0] * c0 + RADAU[2, 1] * c1 + RADAU[2, 2] * c2
    value = run.value[k]
    heat = mean * squared + (v0 * value[0] * (c0 - mean) + v1 * value[1] * (c1 - mean) + v2 * value[2] * (c2 - mean))
    electrical = v0 * at[TOTAL, 0] + v1 * at[TOTAL, 1] + v2 * at[TOTAL, 2]
    side = v0 * at[SIDE, 0] + v1 * at[SIDE, 1] + v2 * at[SIDE, 2]
    return heat, v0 + v1 + v2, electrical, side
