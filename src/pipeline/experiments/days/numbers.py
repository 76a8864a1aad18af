"""The numbers that the steps of days find, and which days there are to show."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from pipeline.quantity import Vocabulary

if TYPE_CHECKING:
    from pipeline.report.tables import ReportData


STAGES = {
    "sun": ("input", "what the panel would give at its efficiency of standard conditions"),
    "panel": ("loss", "cells warmer, light dimmer than standard"),
    "tracker": ("loss", "beside the maximum power"),
    "curtailed": ("unused", "for which the bus has no use"),
    "boost": ("loss", "heat of the boost converter"),
    "load": ("use", "what the load gets"),
    "buck": ("loss", "heat of the buck converter"),
    "resistor": ("loss", "what discharge pulses give up in the resistor"),
    "battery": ("loss", "heat of the battery, and its gas"),
    "stored": ("stored", "chemical energy H(SOC) gained"),
}
"""Stage from sun to battery -> its role, and what its energy is."""

DAY_NUMBERS = Vocabulary(
    {
        "end_soc": ("1", "state of charge at last light"),
        "ended_s": ("s", "when the mode's sheet ended the charge, since first light"),
        "ended_clock_s": ("s", "the same since midnight"),
        "charging_s": ("s", "time in charging parts of the waveforms"),
        "current_limited_s": ("s", "of it at the full current that is asked for"),
        "voltage_limited_s": ("s", "of it with the voltage held at its limit"),
        "supply_limited_s": ("s", "of it with the supply at its limit"),
        "charge_in_ah": ("Ah", "charge put in, discharge pulses not subtracted"),
        "charge_out_ah": ("Ah", "charge taken out by discharge pulses"),
        "peak_temperature_c": ("degC", "highest battery temperature"),
        "end_temperature_c": ("degC", "battery temperature at last light"),
        "switchings": ("1", "changes of state over the day"),
        **{f"{stage}_wh": ("Wh", words) for stage, (_, words) in STAGES.items()},
        "unserved_wh": ("Wh", "what the load asks for and does not get"),
        "most_above_available_w": (
            "W",
            "most by which a mean into the battery lies above what the bus could bring: rounding, and cut periods",
        ),
        "energy_balance_residual": ("1", "residual of the battery's first law, over the sun's energy"),
        "steps": ("1", "steps the engine took"),
    }
)

WEATHER_NUMBERS = Vocabulary(
    {
        "irradiation_kwh_m2": ("kWh/m2", "energy of the light on the panel"),
        "highest_irradiance_w_m2": ("W/m2", "highest irradiance on the panel"),
        "length_s": ("s", "from first to last light, or as long as the weather lasts"),
        "mean_ambient_c": ("degC", "mean of the air"),
        "highest_cell_temperature_c": ("degC", "highest of the cells"),
        "gaps": ("1", "stretches of the file for which no row holds"),
        "gap_s": ("s", "their length together"),
        "dark_gaps": ("1", "those too long to be interpolated, taken as dark"),
        "dark_gap_s": ("s", "their length together"),
    }
)


def weathers(data: ReportData) -> Mapping[str, str]:
    """Return the name of each day's weather -> its title, in the order of the configuration."""
    found: Mapping[str, str] = data.settings.get("day", {}).get("weathers", {})
    return {name: title for name, title in found.items() if charged(data, name)}


def charged(data: ReportData, weather: str) -> list[str]:
    """Return the modes that were charged in a weather, in the order of the run."""
    return [mode for mode in data.modes if f"day/{weather}/{mode}" in data.inputs]
