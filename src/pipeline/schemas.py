"""Every table that passes between steps, declared once: columns, units, meaning."""

from __future__ import annotations

from pipeline.tables import Column, Table

_IRRADIANCE = Column("irradiance_w_m2", "W/m2", "plane-of-array irradiance")
_CELL_TEMPERATURE = Column("cell_temperature_c", "degC", "temperature of the panel's cells")
_SWARM = ("c1", "c2", "w")

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
QUANTITIES = Table(
    "quantities",
    "Named numbers that a step found, a row per number",
    (
        Column("quantity", "", "name of the number", "text"),
        Column("value", "see unit", "its value; empty where there is none", optional=True),
        Column("unit", "", "unit of the value", "text"),
        Column("description", "", "what the number is", "text"),
    ),
)
_PARAMETER_R = Column("r", "1", "parameter of the logistic map x -> r x (1 - x)")
ORBIT = Table(
    "orbit",
    "Successive values of the logistic map",
    (
        _PARAMETER_R,
        Column("step", "1", "number of the step, from 0", "integer"),
        Column("value", "1", "value of the map"),
    ),
)
DISORDER = Table(
    "disorder",
    "How disordered the logistic map is, a row per parameter and number of bins",
    (
        _PARAMETER_R,
        Column("bins", "1", "equal bins over [0, 1] in which visits are counted", "integer"),
        Column("entropy_nats", "nat", "Shannon entropy of the visits to the bins"),
        Column("lyapunov_nats", "nat/step", "Lyapunov exponent; does not depend on the bins"),
    ),
)
_FREQUENCY = Column("frequency_hz", "Hz", "frequency of the pulses")
_CAPACITANCE = Column("capacitance_f", "F", "capacitance of the battery's fastest RC pair, its resistance kept")
_SWITCHING_ENERGY = Column("switching_energy_j", "J", "energy the switches take in a period")
OBJECTIVE_LOSS = Table(
    "objective_loss",
    "Loss of the configured pulses against their frequency",
    (
        _FREQUENCY,
        Column("pair_ripple_w", "W", "loss of the ripple in the RC pairs"),
        Column("series_ripple_w", "W", "loss of the ripple in the series resistance; the same at every frequency"),
        Column("switching_w", "W", "loss of the switches"),
        Column("total_w", "W", "sum of the three"),
        Column("error_mw", "mW", "e of equation (5): the loss no frequency could avoid, less the loss there is"),
        Column("ise_mw2_s", "mW2 s", "integral of e^2 over the window, which a search minimises"),
        Column("share_over_minimum", "1", "that integral over its minimum, less 1"),
    ),
)
FREQUENCY_MAP = Table(
    "frequency_map",
    "Frequency of least loss over switching energy and capacitance of the fastest RC pair",
    (
        _SWITCHING_ENERGY,
        _CAPACITANCE,
        Column("optimal_frequency_hz", "Hz", "frequency of least loss; empty outside 1 mHz to 1 MHz", optional=True),
    ),
)
FREQUENCY_CONTOUR = Table(
    "frequency_contour",
    "Where on the map the published frequency, 90 Hz, would be the best",
    (_CAPACITANCE, _SWITCHING_ENERGY),
)
_KNOBS = (
    Column("c1", "1", "learning constant C1; empty where the design does not vary it", optional=True),
    Column("c2", "1", "learning constant C2; empty where the design does not vary it", optional=True),
    Column("w", "1", "inertia weight W; empty where the design does not vary it", optional=True),
)
TUNING_RUNS = Table(
    "tuning_runs",
    "Results of a parameter design, a row per run of its array and replicate",
    (
        Column("run", "1", "number of the run in the array, from 1", "integer"),
        Column("replicate", "1", "number of the search, from 0", "integer"),
        *_KNOBS,
        Column("result", "mW2 s", "what the search counts for, smaller is better"),
    ),
)
TUNING_LEVELS = Table(
    "tuning_levels",
    "What each level of each factor came to, over the mean results of the runs",
    (
        Column("factor", "", "name of the factor", "text"),
        Column("level", "1", "number of the level, from 1", "integer"),
        Column("setting", "1", "what the factor is set to"),
        Column("sum", "mW2 s", "sum of the results of the runs at this level"),
        Column("mean", "mW2 s", "their mean"),
        Column("signal_to_noise_db", "dB", "mean smaller-the-better signal-to-noise ratio of the runs at this level"),
        Column("chosen", "", "whether the level has the least sum", "truth"),
    ),
)
TUNING_SUMS = Table(
    "tuning_sums",
    "Sums of the results by level, a column per factor, as the paper's Table 3 prints them",
    (
        Column("level", "1", "number of the level, from 1", "integer"),
        *(Column(name, "mW2 s", f"sum over the runs with {name} at this level", optional=True) for name in _SWARM),
    ),
)
TUNING_ANOVA = Table(
    "tuning_anova",
    "Analysis of variance of a parameter design",
    (
        Column("source", "", "factor, all factors, error or total", "text"),
        Column("sum_of_squares", "(mW2 s)2", "sum of squares"),
        Column("degrees_of_freedom", "1", "degrees of freedom", "integer"),
        Column("mean_square", "(mW2 s)2", "sum of squares over degrees of freedom", optional=True),
        Column("f", "1", "mean square over that of the error; empty for error and total", optional=True),
        Column("p", "1", "chance of an F this large if the factor did nothing", optional=True),
    ),
)
TUNING_FACTORIAL = Table(
    "tuning_factorial",
    "Results of every combination of levels, a row per combination",
    (
        *_KNOBS,
        Column("mean", "mW2 s", "mean over the searches"),
        Column("standard_deviation", "mW2 s", "standard deviation over the searches", optional=True),
        Column("rank", "1", "rank of the mean, 1 is best", "integer"),
        Column("in_array", "", "whether the array holds this combination", "truth"),
    ),
)
TUNING_AGREEMENT = Table(
    "tuning_agreement",
    "How often the array chooses what the full factorial would, a row per number of searches behind a result",
    (
        Column("searches_per_run", "1", "searches that a result is the mean of", "integer"),
        Column("experiments", "1", "how many times the experiment was repeated", "integer"),
        Column("found_share", "1", "share of the experiments in which the array chooses the best combination"),
        Column("factorial_found_share", "1", "the same where all combinations are run"),
        *(
            Column(f"{name}_share", "1", f"share that chooses the best level of {name}", optional=True)
            for name in _SWARM
        ),
        Column("mean_rank", "1", "mean rank of the combination chosen; 1 is best"),
        Column("mean_rank_of_best_run", "1", "mean rank of the array's own best run"),
        Column("mean_regret", "mW2 s", "by how much the choice exceeds the best combination, on average"),
    ),
)
SEARCH_HISTORY = Table(
    "search_history",
    "The course of a search: the best so far, a row per replicate, iteration and variable",
    (
        Column("replicate", "1", "number of the replicate, from 0", "integer"),
        Column("iteration", "1", "number of the iteration; 0 is the start", "integer"),
        Column("evaluations", "1", "evaluations of the objective so far", "integer"),
        Column("variable", "", "name of the variable", "text"),
        Column("position", "see variable", "its best value so far, in the unit that ends its name"),
        Column("value", "mW2 s", "the objective there"),
    ),
)
SEARCH_BEST = Table(
    "search_best",
    "Where a search ended, a row per replicate and variable",
    (
        Column("replicate", "1", "number of the replicate, from 0", "integer"),
        Column("iteration", "1", "number of the last iteration", "integer"),
        Column("evaluations", "1", "evaluations of the objective in all", "integer"),
        Column("variable", "", "name of the variable", "text"),
        Column("position", "see variable", "its best value, in the unit that ends its name"),
        Column("value", "mW2 s", "the objective there"),
    ),
)
SEARCH_STATISTICS = Table(
    "search_statistics",
    "How each search did over its replicates, a row per search and measure",
    (
        Column("search", "", "name of the search", "text"),
        Column("measure", "", "iterations_to_within_1_hz or final_distance_hz", "text"),
        Column("mean", "see measure", "mean over the replicates that arrived", optional=True),
        Column("mean_low", "see measure", "lower end of its 95 % interval", optional=True),
        Column("mean_high", "see measure", "upper end of its 95 % interval", optional=True),
        Column("arrived_share", "1", "share of the replicates that arrived"),
    ),
)
SEARCH_COMPARISON = Table(
    "search_comparison",
    "Searches against each other, a row per pair and measure: the chance that the first's is larger, that is worse",
    (
        Column("measure", "", "iterations_to_within_1_hz or final_distance_hz", "text"),
        Column("first", "", "name of a search", "text"),
        Column("second", "", "name of the other", "text"),
        Column(
            "larger", "1", "Vargha and Delaney's A: chance that the first's is larger, ties half; 0.5: no difference"
        ),
        Column("larger_low", "1", "lower end of its 95 % interval"),
        Column("larger_high", "1", "upper end of its 95 % interval"),
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
