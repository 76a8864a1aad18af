"""Powers from the panel over the bus to the battery: what could flow, and what did."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.converter.efficiency import boost_efficiency, buck_efficiency
from pipeline.converter.records import Converter, PowerChain

Array = NDArray[np.float64]
_STEPS, _CLOSE = 60, 1e-12


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


def available(
    panel_w: ArrayLike, tracked_w: ArrayLike, load_w: ArrayLike, chain: PowerChain, panel_voltage_v: ArrayLike = np.nan
) -> Available:
    """Follow what the tracker could draw to the battery.

    Arguments
    ---------
    panel_w, tracked_w, load_w : maximum power, what of it is tracked, the load's demand [W], shape (n,).
    chain : the converters.
    panel_voltage_v : voltage at maximum power, which a boost converter of parts depends on [V], shape (n,).
    """
    panel, tracked, load = np.broadcast_arrays(
        *(np.asarray(part, dtype=float) for part in (panel_w, tracked_w, load_w))
    )
    bus = tracked * boost_efficiency(chain, panel_voltage_v, tracked)
    served = np.minimum(load, bus)
    left = bus - served
    battery = left * buck_efficiency(chain, chain.nominal_battery_voltage_v, left)
    return Available(panel.copy(), tracked.copy(), bus, load.copy(), served, battery)


def flows(
    charge_w: ArrayLike,
    discharge_w: ArrayLike,
    could: Available,
    chain: PowerChain,
    panel_voltage_v: ArrayLike = np.nan,
) -> Flows:
    """Follow what the battery took back to the panel.

    Arguments
    ---------
    charge_w, discharge_w : means at the battery's terminals, both positive [W], shape (n,).
    could : what could flow in the same intervals.
    chain, panel_voltage_v : as for `available`.
    """
    charge, discharge = np.asarray(charge_w, dtype=float), np.asarray(discharge_w, dtype=float)
    share = buck_efficiency(chain, chain.nominal_battery_voltage_v, charge, of_output=True)
    buck = np.divide(charge, share, out=np.zeros_like(charge), where=share > 0.0)
    bus = could.served_w + buck
    drawn = _boost_input_w(bus, could, chain, panel_voltage_v)
    return Flows(drawn, could.tracked_w - drawn, bus, buck, charge, discharge)


def kept_by_bus_j(capacitance_f: float, swing_share: float, could: Available, chain: PowerChain) -> Array:
    """Return the energy that a swing of the bus about its voltage brings to the battery's terminals [J], shape (n,).

    Arguments
    ---------
    capacitance_f : capacitance on the bus [F].
    swing_share : swing from peak to peak over the voltage [1].
    could, chain : powers and converters, for the efficiency on the way.
    """
    left = could.bus_w - could.served_w
    efficiency = np.divide(could.battery_w, left, out=np.zeros_like(left), where=left > 0.0)
    return capacitance_f * chain.bus_voltage_v**2 * swing_share * efficiency


def _boost_input_w(bus_w: Array, could: Available, chain: PowerChain, panel_voltage_v: ArrayLike) -> Array:
    """Return what the boost converter draws for a power onto the bus, by iteration on its losses [W], shape (n,)."""
    if isinstance(chain.boost, Converter):
        return bus_w / chain.boost.efficiency
    drawn = bus_w.copy()
    for _ in range(_STEPS):
        following = bus_w + drawn * (1.0 - boost_efficiency(chain, panel_voltage_v, drawn))
        # What the tracker could draw is enough for what the bus could have, and for nothing more.
        following = np.minimum(following, np.maximum(could.tracked_w, bus_w))
        settled = np.max(np.abs(following - drawn), initial=0.0) <= _CLOSE * np.max(bus_w, initial=1.0)
        drawn = following
        if settled:
            break
    return drawn
