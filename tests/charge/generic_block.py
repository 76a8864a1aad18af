"""The generic lead-acid block by scipy's own integrator, on its published equations written anew.

Tremblay and Dessaint (2009), current positive when charging: q is the charge extracted, i* the lagged current,
V = E0 - K Q q / (Q - q) + K Q / (q + Q / 10) i* + Exp + R i, and dExp/dt = B |i| (A u - Exp), u being 1 on charge.
"""

import numpy as np
from scipy.integrate import solve_ivp

E0, K, Q, A, B, R, TAU = 12.26899, 0.048152, 7.29167, 0.820809, 128.571, 0.017143, 10.0


def polarisation_ohm(q):
    return K * Q / (q + 0.1 * Q)


def potential_v(q):
    return E0 - K * Q * q / (Q - q)


def integrate(soc, segments, time, drawn, lag="voltage"):
    """Return the terminal voltages at some times, where the current tells which side of an edge is meant.

    Segments are (length, current); lag on the current is the block's, on the voltage the project's.
    """

    def slopes(_, y, current):
        q, slow, exponential = y
        drive = current if lag == "current" else polarisation_ohm(q) * current
        target = A if current > 0 else 0.0
        return [-current / 3600, (drive - slow) / TAU, B * abs(current) * (target - exponential) / 3600]

    state, start, voltage = np.array([Q * (1 - soc), 0.0, 0.0]), 0.0, np.full(len(time), np.nan)
    for length, current in segments:
        options = {"rtol": 1e-12, "atol": 1e-13, "args": (current,), "dense_output": True}
        found = solve_ivp(slopes, (0, length), state, "DOP853", **options)
        rows = (time > start - 1e-9) & (time < start + length + 1e-9) & (np.abs(drawn - current) < 1e-9)
        q, slow, exponential = found.sol(np.clip(time[rows] - start, 0.0, length))
        held = polarisation_ohm(q) * slow if lag == "current" else slow
        voltage[rows] = potential_v(q) + held + exponential + R * current
        state, start = found.y[:, -1], start + length
    return voltage
