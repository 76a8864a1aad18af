"""Powers from the panel over the bus to the battery: what could flow, and what did."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.converter.records import PowerChain

Array = NDArray[np.float64]


class Available(NamedTuple):
    """What could flow if the battery took all of it, constant over each interval [W], shape (n,) each.

    Arguments
    ---------
    panel_w : the panel's maximum power.
    tracked_w : what the tracker could draw of it.
    bus_w : what the boost converter could bring to the bus.
    load_w, served_w : what the load asks for, and what the bus can give it: it is served first.
    battery_w : what the buck converter could bring to the battery's terminals.
    """

    panel_w: Array
    tracked_w: Array
    bus_w: Array
    load_w: Array
    served_w: Array
    battery_w: Array


class Flows(NamedTuple):
    """What did flow, means over intervals [W], shape (n,) each.

    Arguments
    ---------
    drawn_w : out of the panel.
    curtailed_w : what the tracker could have drawn beside that: the bus had no use for it.
    bus_w : onto the bus.
    buck_w : out of the bus into the buck converter.
    charge_w, discharge_w : into the battery by charging, out of it through the resistor.
    """

    drawn_w: Array
    curtailed_w: Array
    bus_w: Array
    buck_w: Array
    charge_w: Array
    discharge_w: Array


def available(panel_w: ArrayLike, tracked_w: ArrayLike, load_w: ArrayLike, chain: PowerChain) -> Available:
    """Follow what the tracker could draw to the battery.

    Arguments
    ---------
    panel_w, tracked_w, load_w : maximum power, what of it is tracked, the load's demand [W], shape (n,).
    chain : the converters.
    """
    panel, tracked, load = np.broadcast_arrays(
        *(np.asarray(part, dtype=float) for part in (panel_w, tracked_w, load_w))
    )
    bus = tracked * chain.boost.efficiency
    served = np.minimum(load, bus)
    return Available(panel.copy(), tracked.copy(), bus, load.copy(), served, (bus - served) * chain.buck.efficiency)


def flows(charge_w: ArrayLike, discharge_w: ArrayLike, could: Available, chain: PowerChain) -> Flows:
    """Follow what the battery took back to the panel.

    Arguments
    ---------
    charge_w, discharge_w : means at the battery's terminals, both positive [W], shape (n,).
    could : what could flow in the same intervals.
    chain : the converters.
    """
    charge, discharge = np.asarray(charge_w, dtype=float), np.asarray(discharge_w, dtype=float)
    buck = charge / chain.buck.efficiency
    bus = could.served_w + buck
    drawn = bus / chain.boost.efficiency
    return Flows(drawn, could.tracked_w - drawn, bus, buck, charge, discharge)
