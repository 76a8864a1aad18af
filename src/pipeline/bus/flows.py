"""Powers from the panel over the bus to the battery: what could flow, and what did."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.bus.records import Switching
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


OFF, MODE_1, MODE_2, ENDED = "off", "mode_1", "mode_2", "ended"
STATES = (OFF, MODE_1, MODE_2, ENDED)


class Span(NamedTuple):
    """A stretch of time [s]."""

    start_s: float
    end_s: float


class Closed(NamedTuple):
    """Share of the time for which each switch is closed [1]."""

    s2: float
    s3: float
    s4: float


class Change(NamedTuple):
    """A change of state: when, from what to what, why, and the switches from then on."""

    time_s: float
    before: str
    after: str
    reason: str
    closed: Closed
    pulses_hz: float


def charging_spans(
    time_s: NDArray[np.float64], power_w: NDArray[np.float64], end_s: float, switching: Switching
) -> list[Span]:
    """Return when the surplus lets the charger draw, with hysteresis.

    Arguments
    ---------
    time_s, power_w : power left for the battery, constant from each time to the next, shape (n,).
    end_s : end of the last row [s].
    """
    found: list[Span] = []
    since: float | None = None
    for at_s, power in zip(time_s.tolist(), power_w.tolist(), strict=True):
        if since is None and power >= switching.start_power_w:
            since = at_s
        elif since is not None and power < switching.stop_power_w:
            found.append(Span(since, at_s))
            since = None
    return found if since is None else [*found, Span(since, end_s)]


def closed(state: str, charge_share: float = 1.0, discharge_share: float = 0.0) -> Closed:
    """Return how the switches stand in a state.

    Arguments
    ---------
    charge_share, discharge_share : shares of a period of the pulses, for Mode 2.
    """
    if state == MODE_1:
        return Closed(1.0, 1.0, 0.0)
    if state == MODE_2:
        return Closed(1.0, charge_share, discharge_share)
    return Closed(0.0, 0.0, 0.0)


def state_at(changes: Sequence[Change], time_s: NDArray[np.float64]) -> list[str]:
    """Return the state at each time."""
    starts = [change.time_s for change in changes]
    rows = np.searchsorted(starts, time_s, side="right") - 1
    return [changes[row].after if row >= 0 else OFF for row in rows.tolist()]
