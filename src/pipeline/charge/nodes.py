"""The circuit at the three nodes of a step and, fourth, its start."""

from __future__ import annotations

import math

from pipeline.cell.circuit import REFERENCE_K, Cell, hysteresis_at, side_current, side_exponent
from pipeline.charge.moment import charge_transfer
from pipeline.charge.state import (
    CURRENT_CONTROL,
    DEPTH,
    ENTROPY,
    ENTROPY_SLOPE,
    ETA,
    ETA_BY_DEPTH,
    ETA_SLOPE,
    HEAT,
    HYSTERESIS,
    HYSTERESIS_V,
    MAIN,
    NODE_V,
    OHM,
    OHM_SLOPE,
    OPEN_SLOPE,
    RELAXATIONS,
    REVERSIBLE,
    SIDE,
    SIDE_SLOPE,
    SLOW_V,
    START,
    TEMPERATURE,
    TERMINAL_V,
    TOTAL,
    VOLTAGE_CONTROL,
    Run,
    T,
    X,
    passed,
    put,
)
from pipeline.jit import inlined

# Change of the side reaction's exponent up to which nine terms of the exponential give all its digits.
SERIES_BELOW = 0.1
_TERMS = tuple(1.0 / math.factorial(k) for k in range(10))


@inlined
def move(run: Run, per_charge: float) -> bool:
    """Move 1 - SOC with the main currents; False where more is charged than there is room for."""
    x, main, depth = run.at[X], run.at[MAIN], run.state[DEPTH]
    put(
        x,
        depth - per_charge * passed(main, 0),
        depth - per_charge * passed(main, 1),
        depth - per_charge * passed(main, 2),
        depth,
    )
    return bool(min(x[0], min(x[1], x[2])) > 0.0)


@inlined
def circuit_near(cell: Cell, run: Run, per_charge: float) -> None:
    """Do as `circuit_at` for nodes so near the start that straight lines from there serve."""
    at, slope, main, t = run.at, run.depth_slope, run.at[MAIN], run.at[T]
    a, b, c = -per_charge * passed(main, 0), -per_charge * passed(main, 1), -per_charge * passed(main, 2)
    u, v, w = t[0] - t[START], t[1] - t[START], t[2] - t[START]
    open_v, entropy, ohm = at[SLOW_V, START], at[ENTROPY, START], at[OHM, START]
    by_depth, ohm_by_depth = slope[OPEN_SLOPE, START], slope[OHM_SLOPE, START]
    entropy_by_depth = slope[ENTROPY_SLOPE, START]
    put(
        at[ENTROPY],
        entropy + entropy_by_depth * a,
        entropy + entropy_by_depth * b,
        entropy + entropy_by_depth * c,
        entropy,
    )
    put(
        at[SLOW_V],
        open_v + by_depth * a + entropy * u,
        open_v + by_depth * b + entropy * v,
        open_v + by_depth * c + entropy * w,
        open_v,
    )
    put(at[OHM], ohm + ohm_by_depth * a, ohm + ohm_by_depth * b, ohm + ohm_by_depth * c, ohm)
    put(slope[OPEN_SLOPE], by_depth, by_depth, by_depth, by_depth)
    put(slope[OHM_SLOPE], ohm_by_depth, ohm_by_depth, ohm_by_depth, ohm_by_depth)
    for k in range(cell.pairs + cell.acceptance):
        r, s, bend, i = run.resistance[k, START], run.slope[k, START], run.bend[k], run.inverse[k, START]
        put(run.resistance[k], r + s * a, r + s * b, r + s * c, r)
        put(run.slope[k], s + bend * a, s + bend * b, s + bend * c, s)
        drift = i * i * s
        put(run.inverse[k], i - drift * a, i - drift * b, i - drift * c, i)


@inlined
def follow_hysteresis(cell: Cell, run: Run) -> None:
    """Add to the slow voltages at the nodes what the hysteresis has changed since the start."""
    at = run.at
    before = run.state[HYSTERESIS]
    for j in range(3):
        after, by_depth = hysteresis_at(cell, before, at[X, j] - at[X, START])
        at[HYSTERESIS_V, j] = after
        at[SLOW_V, j] += after - before
        run.depth_slope[OPEN_SLOPE, j] += by_depth


@inlined
def relax(cell: Cell, run: Run, slot: int, bypassed: bool) -> None:
    """Let the pairs follow the main currents; the sum of their voltages goes to the row of node voltages."""
    main = run.at[MAIN]
    m0, m1, m2 = main[0], main[1], main[2]
    s0 = s1 = s2 = s3 = 0.0
    for k in range(cell.pairs + cell.acceptance):
        through = 0.0 if bypassed and k == cell.pairs else 1.0
        before, r, d, w = run.state[RELAXATIONS + k], run.resistance[k], run.decay[slot, k], run.node[slot, k]
        g0, g1, g2 = through * r[0] * m0, through * r[1] * m1, through * r[2] * m2
        v0 = d[0] * before + w[0, 0] * g0 + w[1, 0] * g1 + w[2, 0] * g2
        v1 = d[1] * before + w[0, 1] * g0 + w[1, 1] * g1 + w[2, 1] * g2
        v2 = d[2] * before + w[0, 2] * g0 + w[1, 2] * g1 + w[2, 2] * g2
        v3 = d[3] * before + w[0, 3] * g0 + w[1, 3] * g1 + w[2, 3] * g2
        put(run.value[k], v0, v1, v2, v3)
        put(run.forcing[k], g0, g1, g2, 0.0)
        s0, s1, s2, s3 = s0 + v0, s1 + v1, s2 + v2, s3 + v3
    put(run.at[NODE_V], s0, s1, s2, s3)


@inlined
def close(cell: Cell, run: Run, control: int, target: float, near: bool) -> None:
    """Finish the circuit at the nodes for their main currents and write what the control misses there.

    The row of node voltages holds those of the pairs.
    """
    at = run.at
    if cell.transfer == 1:
        for j in range(3):
            overpotential = charge_transfer(cell, at[X, j], at[T, j], at[MAIN, j])
            at[ETA, j], at[ETA_SLOPE, j], run.depth_slope[ETA_BY_DEPTH, j] = overpotential
    slow, node, eta = at[SLOW_V], at[NODE_V], at[ETA]
    put(
        node,
        slow[0] + node[0] + eta[0],
        slow[1] + node[1] + eta[1],
        slow[2] + node[2] + eta[2],
        slow[3] + node[3] + eta[3],
    )
    side_currents(cell, run, near)
    main, side, total, ohm, v = at[MAIN], at[SIDE], at[TOTAL], at[OHM], at[TERMINAL_V]
    put(total, main[0] + side[0], main[1] + side[1], main[2] + side[2], main[3] + side[3])
    put(
        v,
        node[0] + ohm[0] * total[0],
        node[1] + ohm[1] * total[1],
        node[2] + ohm[2] * total[2],
        node[3] + ohm[3] * total[3],
    )
    missed = run.residual
    if control == CURRENT_CONTROL:
        put(missed, total[0] - target, total[1] - target, total[2] - target, 0.0)
    elif control == VOLTAGE_CONTROL:
        k, t = run.lift_v_k, at[T]
        a, b, c = t[0] - REFERENCE_K, t[1] - REFERENCE_K, t[2] - REFERENCE_K
        put(missed, v[0] - (target + k * a), v[1] - (target + k * b), v[2] - (target + k * c), 0.0)
    else:
        put(missed, v[0] * total[0] - target, v[1] * total[1] - target, v[2] * total[2] - target, 0.0)


@inlined
def side_currents(cell: Cell, run: Run, near: bool) -> None:
    """Evaluate the side reaction at the nodes: near the start from its value there, which spares exponentials."""
    if cell.side == 0:
        return
    at = run.at
    e0, scale0 = side_exponent(cell, at[NODE_V, 0], at[T, 0])
    e1, scale1 = side_exponent(cell, at[NODE_V, 1], at[T, 1])
    e2, scale2 = side_exponent(cell, at[NODE_V, 2], at[T, 2])
    e3, scale3 = side_exponent(cell, at[NODE_V, START], at[T, START])
    e0, e1, e2, e3 = e0 - e3, e1 - e3, e2 - e3, e3 - e3
    if near and max(abs(e0), max(abs(e1), abs(e2))) < SERIES_BELOW:
        side = at[SIDE, START]
        s0, s1, s2, s3 = side * growth(e0), side * growth(e1), side * growth(e2), side * growth(e3)
        put(at[SIDE], s0, s1, s2, s3)
        put(at[SIDE_SLOPE], s0 / scale0, s1 / scale1, s2 / scale2, s3 / scale3)
    else:
        for j in range(3):
            at[SIDE, j], at[SIDE_SLOPE, j] = side_current(cell, at[NODE_V, j], at[T, j])


@inlined
def growth(exponent: float) -> float:
    """Return exp of a small number."""
    e = exponent
    high = _TERMS[6] + e * (_TERMS[7] + e * (_TERMS[8] + e * _TERMS[9]))
    return 1.0 + e * (1.0 + e * (_TERMS[2] + e * (_TERMS[3] + e * (_TERMS[4] + e * (_TERMS[5] + e * high)))))


@inlined
def warm(cell: Cell, run: Run, slot: int, ambient_k: float) -> float:
    """Move the node temperatures to what the heat at the nodes makes of them; return the largest change [K]."""
    at, state = run.at, run.state
    if cell.recombination == 1:
        k = cell.relaxations - 1
        before, g, d, w = state[RELAXATIONS + k], at[SIDE], run.decay[slot, k], run.node[slot, k]
        for j in range(3):
            run.value[k, j] = d[j] * before + w[0, j] * g[0] + w[1, j] * g[1] + w[2, j] * g[2]
    _heat(cell, run)
    heat, t, loss = at[HEAT], at[T], 1.0 / cell.thermal_resistance_k_w
    put(
        heat,
        heat[0] - (t[0] - ambient_k) * loss,
        heat[1] - (t[1] - ambient_k) * loss,
        heat[2] - (t[2] - ambient_k) * loss,
        heat[3] - (t[3] - ambient_k) * loss,
    )
    if cell.warming == 1:
        for j in range(3):
            _warm_stores(cell, run, j)
    per_heat, start = run.length_s[slot] / cell.heat_capacity_j_k, state[TEMPERATURE]
    t0, t1 = start + per_heat * passed(heat, 0), start + per_heat * passed(heat, 1)
    t2, t3 = start + per_heat * passed(heat, 2), start
    change = max(abs(t0 - t[0]), max(abs(t1 - t[1]), abs(t2 - t[2])))
    put(t, t0, t1, t2, t3)
    return float(change)


@inlined
def per_warmth(cell: Cell, run: Run, k: int, j: int) -> float:
    """Return what a store C v^2 / 2 = tau v^2 / (2 R f(T)) gives up for each kelvin, over v^2 [A/(V K)]."""
    return float(0.5 * cell.tau_s[k] * run.inverse[k, j] * run.warming[k, j])


@inlined
def of_stores(cell: Cell, run: Run, j: int) -> float:
    """Return by how much the net heat at moment j is raised by what its own warming takes from the pairs' stores [1].

    The warming of a battery, dT/dt = heat / C_th, changes the stores of its pairs, whose change is heat again.
    """
    given = 0.0
    for k in range(cell.pairs + cell.acceptance):
        v = run.state[RELAXATIONS + k] if j == START else run.value[k, j]
        given += v * v * per_warmth(cell, run, k, j)
    return float(1.0 / (1.0 - cell.cells * given / cell.heat_capacity_j_k))


@inlined
def _warm_stores(cell: Cell, run: Run, j: int) -> None:
    """Let the stores of the pairs at a node follow its warming: net heat, and what turns v^2 into heat."""
    run.at[HEAT, j] *= of_stores(cell, run, j)
    rate_k_s = run.at[HEAT, j] / cell.heat_capacity_j_k
    for k in range(cell.pairs + cell.acceptance):
        run.conductance[k, j] += per_warmth(cell, run, k, j) * rate_k_s


@inlined
def _heat(cell: Cell, run: Run) -> None:
    """Write the heat of the whole battery at the nodes [W], the relaxation of gas included."""
    at = run.at
    main, total, side, ohm, eta, node = at[MAIN], at[TOTAL], at[SIDE], at[OHM], at[ETA], at[NODE_V]
    slow, hysteresis, t, entropy, reversible = at[SLOW_V], at[HYSTERESIS_V], at[T], at[ENTROPY], at[REVERSIBLE]
    if cell.thermoneutral == 1:
        for j in range(3):
            reversible[j] = main[j] * (slow[j] - hysteresis[j] - cell.thermoneutral_v)
    else:
        put(
            reversible,
            main[0] * t[0] * entropy[0],
            main[1] * t[1] * entropy[1],
            main[2] * t[2] * entropy[2],
            main[3] * t[3] * entropy[3],
        )
    gas_v = cell.gas_v
    h0 = reversible[0] + ohm[0] * total[0] ** 2 + (eta[0] + hysteresis[0]) * main[0] + side[0] * (node[0] - gas_v)
    h1 = reversible[1] + ohm[1] * total[1] ** 2 + (eta[1] + hysteresis[1]) * main[1] + side[1] * (node[1] - gas_v)
    h2 = reversible[2] + ohm[2] * total[2] ** 2 + (eta[2] + hysteresis[2]) * main[2] + side[2] * (node[2] - gas_v)
    h3 = reversible[3] + ohm[3] * total[3] ** 2 + (eta[3] + hysteresis[3]) * main[3] + side[3] * (node[3] - gas_v)
    m0, m1, m2, m3 = main[0], main[1], main[2], main[3]
    for k in range(cell.pairs + cell.acceptance):
        # v^2 becomes heat by 1/R - (dC/dt)/2 with C = tau / R.
        half, i, s, v = 0.5 * cell.tau_s[k] * cell.per_as, run.inverse[k], run.slope[k], run.value[k]
        c0 = (1.0 - half * s[0] * i[0] * m0) * i[0]
        c1 = (1.0 - half * s[1] * i[1] * m1) * i[1]
        c2 = (1.0 - half * s[2] * i[2] * m2) * i[2]
        c3 = (1.0 - half * s[3] * i[3] * m3) * i[3]
        h0, h1, h2, h3 = h0 + v[0] ** 2 * c0, h1 + v[1] ** 2 * c1, h2 + v[2] ** 2 * c2, h3 + v[3] ** 2 * c3
        put(run.conductance[k], c0, c1, c2, c3)
    if cell.recombination == 1:
        v = run.value[cell.relaxations - 1]
        h0, h1, h2 = h0 + v[0] * gas_v, h1 + v[1] * gas_v, h2 + v[2] * gas_v
    n = cell.cells
    put(at[HEAT], n * h0, n * h1, n * h2, n * h3)
