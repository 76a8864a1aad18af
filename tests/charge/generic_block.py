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


def integrate(soc, segments, lag="voltage", tau=TAU):
    """Run through segments of (length, current); lag on the current is the block's, on the voltage the project's.

    Returns two arrays, times and terminal voltages, with a hundred rows a segment.
    """

    def slopes(_, y, current):
        q, slow, exponential = y
        drive = current if lag == "current" else polarisation_ohm(q) * current
        target = A if current > 0 else 0.0
        return [-current / 3600, (drive - slow) / tau, B * abs(current) * (target - exponential) / 3600]

    state, start, times, voltages = np.array([Q * (1 - soc), 0.0, 0.0]), 0.0, [], []
    for length, current in segments:
        grid = np.linspace(0, length, 100)
        found = solve_ivp(slopes, (0, length), state, "DOP853", grid, rtol=1e-12, atol=1e-13, args=(current,))
        q, slow, exponential = found.y
        held = polarisation_ohm(q) * slow if lag == "current" else slow
        times.append(start + grid)
        voltages.append(potential_v(q) + held + exponential + R * current)
        state, start = found.y[:, -1], start + length
    return np.concatenate(times), np.concatenate(voltages)
