"""Names of the numbers that a search for stage currents finds; light to import."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pipeline.objective.staging_records import READINGS

PRINTED = (
    "printed_time_s printed_final_k printed_positive_k printed_peak_k printed_peak_v printed_mean_current_a "
    "printed_largest_increase_a printed_stages fastest_s slowest_s hottest_k convex_share "
    "early_evaluations evaluations"
)
BASELINES = (
    "constant_same_time_a constant_same_time_peak_k constant_same_time_final_k constant_same_peak_a "
    "constant_same_peak_s constant_same_final_a constant_same_final_s same_time_peak_k same_time_final_k"
)
OF_WEIGHTS = (
    "printed_value printed_fitness best_value best_fitness agreeing_share value time_s final_k positive_k peak_k "
    "largest_increase_a"
)
OF_SEARCH = (
    "value_mean value_deviation excess_mean excess_worst time_mean_s time_deviation_s rise_mean_k evaluations "
    "replicates hit_share early_time_mean_s early_rise_mean_k early_excess_mean"
)
OF_CALIBRATION = (
    "printed_peak_k printed_final_k rise_after_stage_3_k same_peak_s same_peak_share same_final_s same_final_share"
)


def search_quantities(stages: int, weights: Sequence[str], searches: Sequence[str], use: str) -> set[str]:
    """Return the names in the table `quantities` of the search.

    Arguments
    ---------
    stages : number of stages.
    weights, searches : their names.
    use : the search whose currents are charged with, which is held against every other.
    """
    others = [name for name in searches if name != use]
    found = {*PRINTED.split(), *BASELINES.split()}
    found |= {f"printed_rise_after_stage_{n}_k" for n in range(1, stages + 1)}
    found |= {f"{name}_{part}" for name in weights for part in OF_WEIGHTS.split()}
    found |= {f"{name}_best_{reading}_{part}" for name in weights for reading in READINGS for part in ("s", "k")}
    found |= {f"{name}_{part}" for name in searches for part in OF_SEARCH.split()}
    found |= {f"same_{reading}_{part}" for reading in READINGS for part in ("s", "share")}
    for other in others:
        found |= {f"{early}time_{use}_over_{other}" for early in ("", "early_")}
        found |= {f"{early}rise_{use}_less_{other}_k" for early in ("", "early_")}
        found |= {f"value_{use}_over_{other}{end}" for end in ("", "_low", "_high")}
    return found


def front_quantities(calibrations: Iterable[str]) -> set[str]:
    """Return the names in the table `quantities` of the front."""
    found = {f"{name}_{part}" for name in calibrations for part in OF_CALIBRATION.split()}
    found |= {f"{end}_same_{reading}_share" for end in ("least", "most") for reading in ("peak", "final")}
    of_front = ("front_points", "dominating_points", "farthest_above_scan_k", "time_less_at_printed_rise_share")
    return found | {f"{reading}_{name}" for reading in ("peak", "final") for name in of_front}
