"""Every table that passes between steps, declared once: columns, units, meaning."""

from __future__ import annotations

from pipeline.tables import Column, Table

_IRRADIANCE = Column("irradiance_w_m2", "W/m2", "plane-of-array irradiance")
_CELL_TEMPERATURE = Column("cell_temperature_c", "degC", "temperature of the panel's cells")

PANEL_PARAMETERS = Table(
    "panel_parameters",
    "Single-diode parameters at 1000 W/m2 and 25 degC, fitted to the data sheet",
    (
        Column("photocurrent_a", "A", "light-generated current I_L"),
        Column("saturation_current_a", "A", "diode saturation current I_0"),
        Column("series_resistance_ohm", "ohm", "series resistance R_s"),
        Column("shunt_resistance_ohm", "ohm", "shunt resistance R_sh"),
        Column("modified_ideality_v", "V", "modified ideality factor a = n N_s k T / q"),
        Column("adjust_percent", "%", "adjustment of the temperature coefficients, as in the CEC model"),
        Column("fit_residual", "1", "largest relative deviation of the six fitted equations"),
    ),
)
PANEL_CURVES = Table(
    "panel_curves",
    "Current-voltage curves, from short circuit to open circuit",
    (
        _IRRADIANCE,
        _CELL_TEMPERATURE,
        Column("voltage_v", "V", "panel voltage"),
        Column("current_a", "A", "panel current"),
        Column("power_w", "W", "panel power"),
    ),
)
PANEL_POINTS = Table(
    "panel_points",
    "The characteristic points of each curve",
    (
        _IRRADIANCE,
        _CELL_TEMPERATURE,
        Column("short_circuit_current_a", "A", "I_sc"),
        Column("open_circuit_voltage_v", "V", "V_oc"),
        Column("max_power_current_a", "A", "I_mp"),
        Column("max_power_voltage_v", "V", "V_mp"),
        Column("max_power_w", "W", "P_mp = V_mp I_mp"),
    ),
)
SUPPLY = Table(
    "supply",
    "Powers from the panel to the battery's terminals, constant from each row's time to the next",
    (
        Column("time_s", "s", "start of the interval"),
        _IRRADIANCE,
        _CELL_TEMPERATURE,
        Column("panel_power_w", "W", "maximum power of the panel"),
        Column("bus_power_w", "W", "power the boost converter brings to the bus"),
        Column("load_power_w", "W", "power the master system takes from the bus"),
        Column("battery_power_w", "W", "power the buck converter can bring to the battery's terminals"),
        Column("buck_efficiency", "1", "buck output power over input power"),
        Column("boost_efficiency", "1", "boost output power over input power"),
    ),
)

# Columns with a slash carry the names of the Battery Data Format; the others are the project's own.
CHARGE_TRACE = Table(
    "charge_trace",
    "A whole charge, a row per sampling interval: means over the interval that ends at the row's time",
    (
        Column("Test Time / s", "s", "time since the start of the charge, at the end of the interval"),
        Column("Voltage / V", "V", "terminal voltage, mean over the interval"),
        Column("Current / A", "A", "current into the battery, mean over the interval; positive when charging"),
        Column("Step Index / 1", "1", "number of the phase, from 1", "integer"),
        Column("Ambient Temperature / degC", "degC", "ambient temperature"),
        Column("Charging Capacity / Ah", "Ah", "charge put in so far, discharge pulses not subtracted"),
        Column("Discharging Capacity / Ah", "Ah", "charge taken out so far by discharge pulses"),
        Column("Charging Energy / Wh", "Wh", "energy put in so far, discharge pulses not subtracted"),
        Column("Discharging Energy / Wh", "Wh", "energy taken out so far by discharge pulses"),
        Column("Surface Temperature T1 / degC", "degC", "battery temperature at the row's time"),
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
ENSEMBLE = Table(
    "ensemble",
    "What charges came to over the range of the estimated parameters, a row per number",
    (
        Column("sample", "1", "number of the sample of the parameters, from 0", "integer"),
        Column("comparison", "", "name of the comparison", "text"),
        Column("mode", "", "name of the charging mode", "text"),
        Column("quantity", "", "name of the quantity, as in the charge's summary", "text"),
        Column("value", "see the summary", "its value; empty where the charge did not get there", optional=True),
    ),
)
VERDICTS = Table(
    "verdicts",
    "Every published statement that was examined, with its computed verdict",
    (
        Column("statement", "", "identifier of the statement", "text"),
        Column("where", "", "where it stands in the paper", "text"),
        Column("says", "", "what it says", "text"),
        Column("reading", "", "how the words became a predicate, and why this tolerance", "text"),
        Column("basis", "", "paper_data, model or none", "text"),
        Column("verdict", "", "holds, fails, not checkable, calibrated or contradicted", "text"),
        Column("published_value", "see unit", "the printed number, where there is one", optional=True),
        Column("computed_value", "see unit", "the number that answers it, where there is one", optional=True),
        Column("unit", "", "unit of both", "text"),
        Column("tolerance", "see unit", "how far the two may be apart", optional=True),
        Column(
            "margin",
            "see unit",
            "distance to the point where the verdict flips; negative where it failed",
            optional=True,
        ),
        Column(
            "robust_share",
            "1",
            "share of the range of the estimated parameters over which a claim holds",
            optional=True,
        ),
        Column("explanation", "", "the numbers behind the verdict in a sentence", "text"),
    ),
)
