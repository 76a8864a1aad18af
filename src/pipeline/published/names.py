"""Names a statement may use: the tables of each kind of input and the quantities of a charge's summary."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from pipeline import (
    schemas,
    schemas_functions,
    schemas_network,
    schemas_staging,
    schemas_supply,
    schemas_switched,
    schemas_trade_off,
)
from pipeline.tables import Table


class Source(NamedTuple):
    """Where a table lies in its input's folder, how it is declared, and its column of time if it has one."""

    file: str
    table: Table
    time: str | None = None


SOURCES: dict[tuple[str, str], Source] = (
    {
        ("panel", "points"): Source("points.parquet", schemas.PANEL_POINTS),
        ("panel", "parameters"): Source("parameters.parquet", schemas.PANEL_PARAMETERS),
        ("supply", "supply"): Source("supply.parquet", schemas.SUPPLY, "time_s"),
        ("charge", "summary"): Source("summary.parquet", schemas.CHARGE_SUMMARY),
        ("charge", "trace"): Source("trace.bdf.parquet", schemas.CHARGE_TRACE, "Test Time / s"),
        ("charge", "phases"): Source("phases.parquet", schemas.CHARGE_PHASES),
        ("charge", "energy"): Source("energy.parquet", schemas.CHARGE_ENERGY),
        ("trade_off", "trade_off"): Source("trade_off.parquet", schemas_trade_off.TRADE_OFF),
        ("trade_off", "quantities"): Source("quantities.parquet", schemas.QUANTITIES),
        ("ensemble", "ensemble"): Source("ensemble.parquet", schemas.ENSEMBLE),
        ("chaos", "orbit"): Source("orbit.parquet", schemas.ORBIT),
        ("chaos", "bifurcation"): Source("bifurcation.parquet", schemas.ORBIT),
        ("chaos", "disorder"): Source("disorder.parquet", schemas.DISORDER),
        ("chaos", "quantities"): Source("quantities.parquet", schemas.QUANTITIES),
        ("objective", "loss"): Source("loss.parquet", schemas.OBJECTIVE_LOSS),
        ("objective", "map"): Source("map.parquet", schemas.FREQUENCY_MAP),
        ("objective", "contour"): Source("contour.parquet", schemas.FREQUENCY_CONTOUR),
        ("objective", "quantities"): Source("quantities.parquet", schemas.QUANTITIES),
        ("tuning", "factorial"): Source("factorial.parquet", schemas.TUNING_FACTORIAL),
        ("tuning", "agreement"): Source("agreement.parquet", schemas.TUNING_AGREEMENT),
        ("tuning", "quantities"): Source("quantities.parquet", schemas.QUANTITIES),
        ("search", "statistics"): Source("statistics.parquet", schemas.SEARCH_STATISTICS),
        ("search", "comparison"): Source("comparison.parquet", schemas.SEARCH_COMPARISON),
        ("search", "quantities"): Source("quantities.parquet", schemas.QUANTITIES),
        ("staging", "cases"): Source("cases.parquet", schemas_staging.STAGING_CASES),
        ("staging", "currents"): Source("currents.parquet", schemas_staging.STAGING_CURRENTS),
        ("staging", "quantities"): Source("quantities.parquet", schemas.QUANTITIES),
        ("front", "front"): Source("front.parquet", schemas_staging.FRONT),
        ("front", "calibrations"): Source("calibrations.parquet", schemas_staging.CALIBRATIONS),
        ("front", "quantities"): Source("quantities.parquet", schemas.QUANTITIES),
        ("functions", "statistics"): Source("statistics.parquet", schemas_functions.FUNCTION_STATISTICS),
        ("functions", "tests"): Source("tests.parquet", schemas_functions.FUNCTION_TESTS),
        ("functions", "ranks"): Source("ranks.parquet", schemas_functions.FUNCTION_RANKS),
        ("functions", "quantities"): Source("quantities.parquet", schemas.QUANTITIES),
    }
    | {
        ("tuning", f"{name}_{part}"): Source(f"{name}.{part}.parquet", table)
        for name in ("published", "rerun")
        for part, table in (
            ("runs", schemas.TUNING_RUNS),
            ("levels", schemas.TUNING_LEVELS),
            ("sums", schemas.TUNING_SUMS),
            ("anova", schemas.TUNING_ANOVA),
        )
    }
    | {key: Source(*found) for key, found in schemas_network.ARTEFACTS.items()}
    | {key: Source(*found) for key, found in (schemas_switched.ARTEFACTS | schemas_supply.ARTEFACTS).items()}
)
"""(first word of the input's name, table) -> where it is; one line more serves another kind of artefact.

A search's own tables are not listed, because its configuration names them; see `source`.
"""

_OF_A_SEARCH = {"history": schemas.SEARCH_HISTORY, "best": schemas.SEARCH_BEST}

_SUMMARY = (
    "end_time_s end_soc charge_in_ah charge_out_ah energy_in_wh energy_out_wh charge_efficiency energy_efficiency "
    "peak_temperature_c peak_temperature_rise_k end_temperature_c peak_temperature_rate_k_s mean_current_a "
    "time_at_voltage_limit_s time_at_supply_limit_s energy_balance_residual steps edges control_changes"
)


NAMED = frozenset({"summary", "quantities"})
"""Tables that hold a named number in each row; a statement reads them by that name."""


def kind(artefact: str) -> str:
    """Return the kind of an input: the first word of its name."""
    return artefact.split("/")[0]


def tables_of(artefact: str) -> set[str]:
    """Return the tables an input has; a reference has one, of its own name."""
    if kind(artefact) == "reference":
        return {artefact.split("/")[-1]}
    return {table for of, table in SOURCES if of == kind(artefact)}


def source(of: str, table: str) -> Source | None:
    """Return where a table of a kind of input is; none where such an input has no such table."""
    name, _, part = table.rpartition("_")
    if of == "search" and name and part in _OF_A_SEARCH:
        return Source(f"{name}.{part}.parquet", _OF_A_SEARCH[part])
    return SOURCES.get((of, table))


def summary_quantities(soc_marks: Iterable[float]) -> set[str]:
    """Return the names of the numbers in a charge's summary, for the SOC marks of its settings."""
    marks = {name for mark in soc_marks for name in (f"time_to_soc_{mark:g}_s", f"temperature_rise_at_soc_{mark:g}_k")}
    return marks | set(_SUMMARY.split())


def found_quantities(
    bins: Iterable[int], modes: Iterable[str], factors: Iterable[str], searches: Iterable[str]
) -> dict[str, set[str]]:
    """Return the names of the numbers that the steps of a search find.

    Arguments
    ---------
    bins : numbers of bins in which the logistic map's visits are counted.
    modes : charging modes that pulse.
    factors : of the parameter design.
    searches : names of the searches that are run, the first being the one whose result is used.

    Returns
    -------
    Kind of input -> names in its table `quantities`.
    """
    names = list(searches)
    sets = ("published", "rerun")
    tuned = {f"{of}_{name}" for of in sets for name in _expand(_TUNING, factor=factors)}
    return {
        "chaos": _expand(_CHAOS, bins=bins),
        "objective": _expand(_OBJECTIVE, mode=modes, place=("optimum", "classic", "impedance_minimum")),
        "tuning": tuned
        | _expand("factorial_best_{factor} factorial_best_mw2_s factorial_rank_of_{of}", factor=factors, of=sets),
        "search": _expand(_SEARCH, search=names, other=names[1:], first=names[:1], end=("", "_low", "_high")),
    }


_CHAOS = (
    "most_disordered_r_{bins}_bins most_entropy_{bins}_bins_nats entropy_at_4_{bins}_bins_nats "
    "exact_entropy_at_4_{bins}_bins_nats uniform_entropy_{bins}_bins_nats most_unstable_r lyapunov_at_4_nats "
    "mean_at_4 variance_at_4 distance_to_uniform distance_to_arcsine"
)
_OBJECTIVE = (
    "optimal_frequency_hz band_low_hz band_high_hz switching_energy_j impedance_minimum_hz resonance_hz "
    "discharge_resistor_w mean_current_w ise_at_{place} pair_ripple_at_{place}_w switching_at_{place}_w "
    "ripple_and_switching_at_{place}_w switching_energy_{mode}_j optimal_frequency_{mode}_hz"
)
_TUNING = (
    "chosen_{factor} p_{factor} p explained_share predicted_mw2_s chosen_mw2_s chosen_rank best_run best_mw2_s "
    "mean_mw2_s runs combinations unbalanced"
)
_SEARCH = (
    "frequency_hz ise_mw2_s difference_from_sweep_hz {search}_frequency_hz "
    "{search}_frequency_mean_hz {search}_frequency_deviation_hz {search}_ise_mw2_s {search}_ise_mean_mw2_s "
    "{search}_iterations {search}_evaluations {search}_replicates {search}_iterations_to_within_1_hz "
    "{search}_arrived_share {search}_final_distance_hz "
    "iterations_{first}_over_{other}{end} distance_{first}_over_{other}{end}"
)


def _expand(text: str, **fields: Iterable[object]) -> set[str]:
    """Return the words of a text with every combination of the values of the fields each one names."""
    known = {name: [str(value) for value in values] for name, values in fields.items()}
    found = set(text.split())
    for name, values in known.items():
        marked = {word for word in found if f"{{{name}}}" in word}
        found -= marked
        found |= {word.replace(f"{{{name}}}", value) for word in marked for value in values}
    return found
