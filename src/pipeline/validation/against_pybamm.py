"""The engine against PyBaMM's Thevenin model, where it is installed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.validation import pybamm_peer
from pipeline.validation.common import Circuit, by_engine
from pipeline.validation.peers import Array, common_model, compare, difference
from pipeline.validation.records import Found, PeerSettings, Row, at_most, largest

BOUNDS = {"voltage": 1e-6, "SOC": 1e-8, "temperature": 1e-6}


def check(settings: Mapping[str, Any]) -> Found:
    """Return how far CC, CC-CV and pulses are apart.

    PyBaMM counts current times voltage of a pair as heat, what its capacitor stores included; here it is v^2 / R. So
    its temperature is compared twice: with pairs that dissipate v^2 / R, which must agree, and as shipped, where the
    difference must be what the energy stored at each moment comes to.
    """
    given = PeerSettings.model_validate(settings)
    found = compare(given, BOUNDS, lambda own, case, time_s: pybamm_peer.charged(own, case, time_s, False)[0])
    if given.version is None:
        return found
    cell, own, chosen = common_model(given)
    for case in chosen:
        ours = by_engine(cell, case)
        theirs, stored_j = pybamm_peer.charged(own, case, ours.time_s, True)
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
