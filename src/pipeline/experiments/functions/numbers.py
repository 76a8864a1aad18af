"""The numbers that the steps of functions find: names, units, meanings."""

from __future__ import annotations

from collections.abc import Iterable

from pipeline.quantity import Vocabulary
from pipeline.search.function_records import FunctionStudy

_HERE = "{search} on {function}, {placement}"

_OF_A_ROW = {
    "{search}_{function}_{placement}_mean": f"mean of the best values, {_HERE}",
    "{search}_{function}_{placement}_deviation": f"standard deviation of the best values, {_HERE}",
    "{search}_{function}_{placement}_mean_at_budget": "mean of the best values at the shortest search's budget, "
    f"{_HERE}",
    "{search}_{function}_{placement}_success_share": f"share of the runs at or below the threshold, {_HERE}",
    "{search}_{function}_{placement}_generations": f"mean generations to the threshold of those runs, {_HERE}",
    "{search}_{function}_{placement}_generations_deviation": f"their standard deviation, {_HERE}",
}

_OF_A_SEARCH = {
    "{search}_{placement}_zeros": "functions on which every run of {search} ends at exactly 0, {placement}",
    "{search}_{placement}_perfect": "functions on which the mean of {search} is below 1e-16, which a table prints as "
    "0, {placement}",
    "{search}_{placement}_always_reached": "functions on which every run of {search} reaches the threshold, "
    "{placement}",
    "{search}_{placement}_mean_success_share": "share of all runs of {search} that reach the threshold, {placement}",
    "{search}_{placement}_rank_at_budget": "mean rank of {search} at the shortest search's budget, {placement}; 1 is "
    "best",
    "{variant}_{placement}_mean_rank": "mean rank of {variant} among the variants, {placement}; 1 is best",
}

_OF_ANOTHER = {
    "{other}_{placement}_speedup": "plain search's generations to the threshold over those of {other}, geometric mean "
    "over the functions that both always solve, {placement}",
    "{other}_{placement}_value_better": "functions on which {other} ends significantly lower than plain search, "
    "{placement}",
    "{other}_{placement}_value_worse": "functions on which {other} ends significantly higher than plain search, "
    "{placement}",
    "{other}_{placement}_generations_fewer": "functions on which {other} reaches the threshold significantly sooner, "
    "{placement}",
    "{other}_{placement}_generations_more": "functions on which {other} reaches the threshold significantly later, "
    "{placement}",
}

_OF_A_PLACEMENT = {
    "{placement}_friedman_p": "chance of ranks of the variants as far apart as these if they did not differ, "
    "{placement}",
    "{placement}_friedman_at_budget_p": "the same for all searches at the shortest search's budget, {placement}",
}

_OF_A_LOOP = {
    "{gain}_median": "median size of the random gain Kp of a flight of plain search",
    "{gain}_negative_share": "share of the flights whose gain is negative: they lead away from the best nest",
    "{loop}_loop_error": "error that stays in the control loop of {loop} after a step, at mean inertia and median "
    "gain; none where the loop does not come to rest",
    "{loop}_loop_stable": "1 where s^2 + (1 - w + Kp) s + Ki = 0 has stable roots, both coefficients positive: {loop}",
    "{loop}_loop_rings": "1 where they are a complex pair besides: {loop}",
    "{loop}_loop_factor": "by which the loop of {loop}, run in steps with its leak, shrinks in a generation; above 1: "
    "grows",
}

_COUNTS = {
    "functions": "test functions",
    "dimensions": "dimensions of each",
    "variant_replicates": "runs of each variant on each function",
    "variant_generations": "generations of a variant's run",
    "variant_evaluations": "evaluations of a variant's run",
    "baseline_replicates": "runs of each baseline on each function",
    "budget": "evaluations of the shortest search's run",
}

_ALL = _COUNTS | _OF_A_ROW | _OF_A_SEARCH | _OF_ANOTHER | _OF_A_PLACEMENT | _OF_A_LOOP

VOCABULARY = Vocabulary({pattern: ("1", text) for pattern, text in _ALL.items()})
"""All of them; the fields are those of `fields`."""


def fields(study: FunctionStudy) -> dict[str, Iterable[object]]:
    """Return what the fields in the names stand for in a study.

    Returns
    -------
    `search`: any; `variant`: those from the same starts; `other`: variants but the plain one; `loop`: cuckoo searches,
    where the plain one is one of them, and `gain`, whose name is `kp`; `function`, `placement`.
    """
    loops = study.loops() if study.plain in study.loops() else []
    return {
        "search": list(study.searches(1.0)),
        "variant": list(study.variants.searches),
        "other": [name for name in study.variants.searches if name != study.plain],
        "loop": loops,
        "gain": ["kp"] if loops else [],
        "function": study.functions,
        "placement": study.placements,
    }
