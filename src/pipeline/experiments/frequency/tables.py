"""The tables of chaos, the objective, the parameter design and the search."""

from __future__ import annotations

from pipeline.experiments.frequency.tuning_tables import KNOBS
from pipeline.kernel.tables import CHAOTIC, NUMBERS, Column, Table, TableFile

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
        *(Column(name, "mW2 s", f"sum over the runs with {name} at this level", optional=True) for name in KNOBS),
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
            for name in KNOBS
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

CHAOS = {
    "orbit": TableFile("orbit.parquet", ORBIT, elsewhere={"value": CHAOTIC}),
    "bifurcation": TableFile("bifurcation.parquet", ORBIT, elsewhere={"value": CHAOTIC}),
    "disorder": TableFile("disorder.parquet", DISORDER),
    **NUMBERS,
}
"""What the step `chaos` writes."""

OBJECTIVE = {
    "loss": TableFile("loss.parquet", OBJECTIVE_LOSS),
    "map": TableFile("map.parquet", FREQUENCY_MAP),
    "contour": TableFile("contour.parquet", FREQUENCY_CONTOUR),
    **NUMBERS,
}
"""What the step `objective` writes."""

_OF_A_SET = {"runs": TUNING_RUNS, "levels": TUNING_LEVELS, "sums": TUNING_SUMS, "anova": TUNING_ANOVA}

SETS = {
    name: {f"{name}_{part}": TableFile(f"{name}.{part}.parquet", table) for part, table in _OF_A_SET.items()}
    for name in ("rerun", "published")
}
"""Results of the parameter design, ours and the paper's where it prints them -> the tables of each."""

TUNING = {
    **SETS["rerun"],
    **SETS["published"],
    "factorial": TableFile("factorial.parquet", TUNING_FACTORIAL),
    "agreement": TableFile("agreement.parquet", TUNING_AGREEMENT),
    **NUMBERS,
}
"""What the step `tuning` writes."""

SEARCH = {
    "{search}_history": TableFile(
        "{search}.history.parquet", SEARCH_HISTORY, elsewhere={"position": CHAOTIC, "value": CHAOTIC}
    ),
    "{search}_best": TableFile("{search}.best.parquet", SEARCH_BEST),
    "statistics": TableFile("statistics.parquet", SEARCH_STATISTICS),
    "comparison": TableFile("comparison.parquet", SEARCH_COMPARISON),
    **NUMBERS,
}
"""What the step `search` writes."""
