"""The names of the numbers that a study of searches on test functions finds, and what they mean; light to import."""

from __future__ import annotations

from pipeline.search.function_records import FunctionStudy

OF_A_ROW = {
    "mean": "mean of the best values, {search} on {function}, {placement}",
    "deviation": "standard deviation of the best values, {search} on {function}, {placement}",
    "mean_at_budget": "mean of the best values at the shortest search's budget, {search} on {function}, {placement}",
    "success_share": "share of the runs at or below the threshold, {search} on {function}, {placement}",
    "generations": "mean generations to the threshold of those runs, {search} on {function}, {placement}",
    "generations_deviation": "their standard deviation, {search} on {function}, {placement}",
}
OF_A_SEARCH = {
    "zeros": "functions on which every run of {search} ends at exactly 0, {placement}",
    "perfect": "functions on which the mean of {search} is below 1e-16, which a table prints as 0, {placement}",
    "always_reached": "functions on which every run of {search} reaches the threshold, {placement}",
    "mean_success_share": "share of all runs of {search} that reach the threshold, {placement}",
    "rank_at_budget": "mean rank of {search} at the shortest search's budget, {placement}; 1 is best",
}
OF_A_VARIANT = {
    "mean_rank": "mean rank of {search} among the variants, {placement}; 1 is best",
    "speedup": "plain search's generations to the threshold over those of {search}, geometric mean over the functions "
    "that both always solve, {placement}",
    "value_better": "functions on which {search} ends significantly lower than plain search, {placement}",
    "value_worse": "functions on which {search} ends significantly higher than plain search, {placement}",
    "generations_fewer": "functions on which {search} reaches the threshold significantly sooner, {placement}",
    "generations_more": "functions on which {search} reaches the threshold significantly later, {placement}",
}
OF_A_PLACEMENT = {
    "friedman_p": "chance of ranks of the variants as far apart as these if they did not differ, {placement}",
    "friedman_at_budget_p": "the same for all searches at the shortest search's budget, {placement}",
}
OF_THE_GAIN = {
    "kp_median": "median size of the random gain Kp of a flight of plain search",
    "kp_negative_share": "share of the flights whose gain is negative: they lead away from the best nest",
}
OF_A_LOOP = {
    "loop_error": "error that stays in the control loop of {search} after a step, at mean inertia and median gain; "
    "none where the loop does not come to rest",
    "loop_stable": "1 where s^2 + (1 - w + Kp) s + Ki = 0 has stable roots, both coefficients positive: {search}",
    "loop_rings": "1 where they are a complex pair besides: {search}",
    "loop_factor": "by which the loop of {search}, run in steps with its leak, shrinks in a generation; above 1: grows",
}
COUNTS = {
    "functions": "test functions",
    "dimensions": "dimensions of each",
    "variant_replicates": "runs of each variant on each function",
    "variant_evaluations": "evaluations of a variant's run",
    "baseline_replicates": "runs of each baseline on each function",
    "budget": "evaluations of the shortest search's run",
}


def names(study: FunctionStudy) -> set[str]:
    """Return the names of all numbers that a study finds."""
    searches, variants = list(study.searches(1.0)), [name for name in study.variants.searches if name != study.plain]
    found = {
        f"{search}_{function}_{placement}_{measure}"
        for search in searches for function in study.functions for placement in study.placements
        for measure in OF_A_ROW
    }  # fmt: skip
    for placement in study.placements:
        found |= {f"{search}_{placement}_{measure}" for search in searches for measure in OF_A_SEARCH}
        found |= {f"{search}_{placement}_{measure}" for search in variants for measure in OF_A_VARIANT}
        found |= {f"{study.plain}_{placement}_mean_rank"} | {f"{placement}_{measure}" for measure in OF_A_PLACEMENT}
    if study.plain in study.loops():
        found |= {f"{search}_{part}" for search in study.loops() for part in OF_A_LOOP} | set(OF_THE_GAIN)
    return found | set(COUNTS)
