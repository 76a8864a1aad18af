"""What can be said of a chain before anything is computed; light to import."""

from __future__ import annotations

from pipeline.converter.records import AnyConverter, Converter, Load, PowerChain
from pipeline.errors import UserError


def check(panel_power_w: float, panel_voltage_v: float, chain: PowerChain, load: Load) -> None:
    """Refuse a supply that can never charge.

    Arguments
    ---------
    panel_power_w : the most the panel gives in this weather, about [W].
    panel_voltage_v : voltage of all panels at maximum power [V].
    chain : tracker, boost and buck.
    load : the master system.

    Raises
    ------
    UserError : the boost converter would have to step down, or the load takes all the bus has.
    """
    if chain.bus_voltage_v <= panel_voltage_v:
        raise UserError(
            f"converter.bus_voltage_v is {chain.bus_voltage_v:g} V; a boost converter needs a bus above the panel's "
            f"voltage at maximum power, {panel_voltage_v:g} V; raise it, or put fewer panels in series"
        )
    bus_w = panel_power_w * chain.tracker_efficiency * _most(chain.boost)
    if load.power_w >= bus_w:
        raise UserError(
            f"load.power_w is {load.power_w:g} W, but the bus has at most about {bus_w:.1f} W: the battery would "
            "never be charged; lower the load, or give more irradiance or panels"
        )


def _most(converter: AnyConverter) -> float:
    """Return an efficiency that a converter does not exceed."""
    return converter.efficiency if isinstance(converter, Converter) else 1.0
