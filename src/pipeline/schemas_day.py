"""The tables of days in the sun; further to `schemas`."""

from __future__ import annotations

from pipeline.schemas import QUANTITIES
from pipeline.tables import Column, Table

WEATHER = Table(
    "weather",
    "The weather of a day, constant from each row's time to the next",
    (
        Column("time_s", "s", "start of the interval, since first light"),
        Column("clock_s", "s", "the same in local time, since midnight of the first day"),
        Column("interval_s", "s", "length of the interval"),
        Column("irradiance_w_m2", "W/m2", "irradiance on the panel"),
        Column("ambient_c", "degC", "temperature of the air"),
        Column("cell_temperature_c", "degC", "temperature of the panel's cells"),
    ),
)
WEATHER_GAPS = Table(
    "weather_gaps",
    "Gaps in the file of a measured weather, and what stands in for them; no row where there are none",
    (
        Column("clock_s", "s", "start of the gap in local time, since midnight"),
        Column("length_s", "s", "length of the gap"),
        Column("filled", "", "interpolated between the rows beside it, or dark", "text"),
    ),
)
DAYLIGHT = Table(
    "daylight",
    "What the battery could have over a day if it took everything, constant from each row's time to the next",
    (
        *WEATHER.columns,
        Column("reference_w", "W", "what the panel would give at its efficiency of standard conditions"),
        Column("panel_w", "W", "the panel's maximum power"),
        Column("panel_voltage_v", "V", "the panel's voltage at maximum power"),
        Column("tracked_w", "W", "what the tracker could draw of it"),
        Column("bus_w", "W", "what the boost converter could bring to the bus"),
        Column("load_w", "W", "what the load asks for"),
        Column("served_w", "W", "what the bus gives it"),
        Column("battery_w", "W", "what the buck converter could bring to the battery's terminals"),
    ),
)
_STATE = "off, mode_1, mode_2 or ended"
DAY_TRACE = Table(
    "day_trace",
    "A day, a row per sampling interval, and one where the switches change: means over the interval that ends there",
    (
        Column("time_s", "s", "end of the interval, since first light"),
        Column("clock_s", "s", "the same in local time, since midnight of the first day"),
        Column("interval_s", "s", "length of the interval"),
        Column("state", "", f"state of the switches: {_STATE}", "text"),
        Column("irradiance_w_m2", "W/m2", "irradiance on the panel"),
        Column("cell_temperature_c", "degC", "temperature of the panel's cells"),
        Column("ambient_c", "degC", "temperature of the air"),
        Column("reference_w", "W", "what the panel would give at its efficiency of standard conditions"),
        Column("panel_w", "W", "the panel's maximum power"),
        Column("tracked_w", "W", "what the tracker could draw of it"),
        Column("drawn_w", "W", "what is drawn"),
        Column("curtailed_w", "W", "what the tracker could draw and nothing has a use for"),
        Column("bus_w", "W", "power onto the bus"),
        Column("load_w", "W", "what the load asks for"),
        Column("served_w", "W", "what the bus gives it"),
        Column("buck_w", "W", "power out of the bus into the buck converter"),
        Column("available_w", "W", "what the buck converter could bring to the battery's terminals"),
        Column("charge_w", "W", "power into the battery while it is charged"),
        Column("discharge_w", "W", "power out of the battery into the discharge resistor"),
        Column("current_a", "A", "current into the battery"),
        Column("voltage_v", "V", "terminal voltage"),
        Column("soc", "1", "state of charge at the end of the interval"),
        Column("temperature_c", "degC", "battery temperature at the end of the interval"),
        Column("supply_limited_share", "1", "share of the interval with the supply at its limit"),
        Column("voltage_limited_share", "1", "share of the interval with the voltage held at its limit"),
    ),
)
DAY_SWITCHING = Table(
    "day_switching",
    "Every change of the switches: when, why, and how they stand from then on",
    (
        Column("time_s", "s", "time of the change, since first light"),
        Column("clock_s", "s", "the same in local time, since midnight of the first day"),
        Column("before", "", f"state before: {_STATE}", "text"),
        Column("after", "", f"state from then on: {_STATE}", "text"),
        Column("reason", "", "what changed it", "text"),
        Column("s2_share", "1", "share of the time for which switch 2 is closed"),
        Column("s3_share", "1", "share of the time for which switch 3 is closed"),
        Column("s4_share", "1", "share of the time for which switch 4 is closed"),
        Column("pulses_hz", "Hz", "how often switches 3 and 4 work; 0 without pulses"),
    ),
)
DAY_STAGES = Table(
    "day_stages",
    "Where the sun's energy goes on its way to the battery: parts of the first row, which they add up to",
    (
        Column("stage", "", "where", "text"),
        Column("role", "", "input, loss, use, unused or stored", "text"),
        Column("energy_j", "J", "energy of the day"),
        Column("description", "", "what it is", "text"),
    ),
)

ARTEFACTS: dict[tuple[str, str], tuple[str, Table]] = {
    ("weather", "weather"): ("weather.parquet", WEATHER),
    ("weather", "weather_gaps"): ("gaps.parquet", WEATHER_GAPS),
    ("weather", "quantities"): ("quantities.parquet", QUANTITIES),
    ("daylight", "daylight"): ("daylight.parquet", DAYLIGHT),
    ("day", "day_trace"): ("trace.parquet", DAY_TRACE),
    ("day", "day_switching"): ("switching.parquet", DAY_SWITCHING),
    ("day", "day_stages"): ("stages.parquet", DAY_STAGES),
    ("day", "quantities"): ("quantities.parquet", QUANTITIES),
}
"""(kind of input, table) -> file, declaration."""

FILES = {name: found for (_, name), found in ARTEFACTS.items() if name != "quantities"}
"""Name under which figures read a table -> file, declaration."""
