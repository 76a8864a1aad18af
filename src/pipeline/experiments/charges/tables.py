"""The tables of charges."""

from __future__ import annotations

from pipeline.kernel.tables import CHAOTIC, Column, Table, TableFile

# Columns with a slash carry the names of the Battery Data Format; the others are the project's own.
CHARGE_TRACE = Table(
    "charge_trace",
    "A whole charge, a row per sampling interval: means over the interval that ends at the row's time",
    (
        Column("Test Time / s", "s", "time since the start of the charge, at the end of the interval"),
        Column("Voltage / V", "V", "terminal voltage, mean over the interval"),
        Column("Current / A", "A", "current into the battery, mean over the interval; positive when charging"),
        Column("Step Count / 1", "1", "number of the phase, from 1", "integer"),
        Column("Ambient Temperature / degC", "degC", "ambient temperature"),
        Column("Charging Capacity / Ah", "Ah", "charge put in so far, discharge pulses not subtracted"),
        Column("Discharging Capacity / Ah", "Ah", "charge taken out so far by discharge pulses"),
        Column("Charging Energy / Wh", "Wh", "energy put in so far, discharge pulses not subtracted"),
        Column("Discharging Energy / Wh", "Wh", "energy taken out so far by discharge pulses"),
        Column("Surface Temperature / degC", "degC", "battery temperature at the row's time"),
        Column("soc", "1", "state of charge at the row's time"),
        Column("voltage_min_v", "V", "lowest terminal voltage in the interval"),
        Column("voltage_max_v", "V", "highest terminal voltage in the interval"),
        Column("current_min_a", "A", "lowest current in the interval"),
        Column("current_max_a", "A", "highest current in the interval"),
        Column("side_current_a", "A", "current of the side reaction, mean over the interval"),
        Column("supply_limited_share", "1", "share of the interval in which the supply limited the current"),
        Column("voltage_limited_share", "1", "share of the interval in which the voltage limit held the current"),
    ),
)
CHARGE_WAVEFORM = Table(
    "charge_waveform",
    "Windows of a charge at full resolution; both sides of every edge have a row",
    (
        Column("window", "1", "number of the window, from 0", "integer"),
        Column("time_s", "s", "time since the start of the charge"),
        Column("current_a", "A", "current into the battery; positive when charging"),
        Column("voltage_v", "V", "terminal voltage"),
        Column("soc", "1", "state of charge"),
        Column("temperature_c", "degC", "battery temperature"),
    ),
)
CHARGE_SUMMARY = Table(
    "charge_summary",
    "What came of a charge, a row per quantity",
    (
        Column("quantity", "", "name of the quantity", "text"),
        Column("value", "see unit", "its value; empty where the charge did not get there, or for text", optional=True),
        Column("text", "", "its value where it is text", "text", optional=True),
        Column("unit", "", "unit of the value", "text"),
        Column("description", "", "what the quantity is", "text"),
    ),
)
CHARGE_PHASES = Table(
    "charge_phases",
    "The phases a charge went through, in order",
    (
        Column("phase", "", "name of the phase", "text"),
        Column("start_s", "s", "time at which it began"),
        Column("end_s", "s", "time at which it ended"),
        Column("end_reason", "", "which limit ended it", "text"),
        Column("start_soc", "1", "state of charge at its start"),
        Column("end_soc", "1", "state of charge at its end"),
        Column("end_temperature_c", "degC", "battery temperature at its end"),
    ),
)
CHARGE_ENERGY = Table(
    "charge_energy",
    "Where the energy of a charge went, a row per path; the first law closes over the rows",
    (
        Column("path", "", "name of the path", "text"),
        Column("role", "", "input, stored, loss, heat or residual", "text"),
        Column("energy_j", "J", "energy over the whole charge"),
        Column("description", "", "what the path is", "text"),
    ),
)
SECOND = "second_charge"
"""Kind of the charges of the second battery."""

CHARGE = {
    "trace": TableFile("trace.bdf.parquet", CHARGE_TRACE, time="Test Time / s"),
    "waveform": TableFile("waveform.parquet", CHARGE_WAVEFORM, time="time_s"),
    # A rounding error, and a count that follows from where steps of a bounded error end.
    "summary": TableFile(
        "summary.parquet", CHARGE_SUMMARY, elsewhere={"energy_balance_residual": CHAOTIC, "steps": 0.05}
    ),
    "phases": TableFile("phases.parquet", CHARGE_PHASES),
    "energy": TableFile("energy.parquet", CHARGE_ENERGY),
}
"""What the step `charge` writes."""
