"""The numbers that a search for stage currents finds: names, units, meanings; light to import.

`{weights}`, `{search}`, `{calibration}` and `{reading}` are names of the study's weights, searches, calibrations and of
the ways to read the temperature rise; `{kept}` is one of those that are kept to, `{use}` the search that is used, and
`{other}` one of the others.
"""

from __future__ import annotations

from pipeline.quantity import Vocabulary

_PRINTED = {
    "printed_time_s": ("s", "charging time with the printed currents"),
    "printed_{reading}_k": ("K", "their temperature rise, {reading}"),
    "printed_rise_after_stage_{stage}_k": ("K", "their rise over the ambient after stage {stage}"),
    "printed_peak_v": ("V", "their highest voltage"),
    "printed_mean_current_a": ("A", "their mean over time"),
    "printed_largest_increase_a": ("A", "largest step up between stages"),
    "printed_stages": ("1", "how many there are"),
    "fastest_s": ("s", "charging time with every stage at the largest current"),
    "slowest_s": ("s", "charging time with every stage at the least current"),
    "hottest_k": ("K", "temperature rise with every stage at the largest current"),
    "convex_share": ("1", "share of random chords below which the rise bends"),
    "evaluations": ("1", "charges at which the searches are compared"),
    "early_evaluations": ("1", "a tenth of them"),
}
_BEST = "of the best currents where the rise weighed is the {reading} one, {weights}"
_WEIGHTED = {
    "{weights}_printed_value": ("1", "objective of the printed currents, {weights}"),
    "{weights}_printed_fitness": ("1", "their fitness, {weights}"),
    "{weights}_best_value": ("1", "least objective there is, {weights}"),
    "{weights}_best_fitness": ("1", "its fitness, {weights}"),
    "{weights}_agreeing_share": ("1", "share of the local solver's starts that end there"),
    "{weights}_value": ("1", "objective that the search found, {weights}"),
    "{weights}_time_s": ("s", "charging time it found, {weights}"),
    "{weights}_{reading}_k": ("K", "temperature rise it found, {reading}, {weights}"),
    "{weights}_largest_increase_a": ("A", "largest step up between stages"),
    "{weights}_best_{reading}_s": ("s", f"time {_BEST}"),
    "{weights}_best_{reading}_k": ("K", f"that rise {_BEST}"),
}
_SAME = "with no more than the printed currents' {reading} rise"
_KEPT = {
    "same_{reading}_s": ("s", f"least charging time {_SAME}"),
    "same_{reading}_share": ("1", f"by how much it is less, {_SAME}"),
    "same_time_{kept}_k": ("K", "least {kept} rise in the printed currents' time"),
}
_BASELINES = {
    "constant_same_time_a": ("A", "constant current that takes the printed currents' time"),
    "constant_same_time_peak_k": ("K", "its highest rise"),
    "constant_same_time_final_k": ("K", "its final rise"),
    "constant_same_{kept}_a": ("A", "constant current with the printed currents' {kept} rise"),
    "constant_same_{kept}_s": ("s", "its charging time"),
}
_SEARCHES = {
    "{search}_value_mean": ("1", "objective that {search} ends with, mean"),
    "{search}_value_deviation": ("1", "its standard deviation"),
    "{search}_excess_mean": ("1", "by how much {search} ends above the least objective"),
    "{search}_excess_worst": ("1", "the same of the worst replicate"),
    "{search}_hit_share": ("1", "share that ends within a thousandth of it"),
    "{search}_time_mean_s": ("s", "charging time that {search} finds, mean"),
    "{search}_time_deviation_s": ("s", "its standard deviation"),
    "{search}_rise_mean_k": ("K", "rise that {search} finds, mean"),
    "{search}_evaluations": ("1", "charges computed"),
    "{search}_replicates": ("1", "independent runs"),
    "{search}_early_excess_mean": ("1", "excess of {search} at a tenth of the charges, mean"),
    "{search}_early_time_mean_s": ("s", "time of {search} at a tenth of the charges, mean"),
    "{search}_early_rise_mean_k": ("K", "rise of {search} at a tenth of the charges, mean"),
}
_EARLY = "{use} against {other}, at a tenth of the charges"
_DIFFERENCES = {
    "time_{use}_over_{other}": ("1", "ratio of mean times, {use} against {other}"),
    "rise_{use}_less_{other}_k": ("K", "difference of mean rises, {use} against {other}"),
    "early_time_{use}_over_{other}": ("1", f"ratio of mean times, {_EARLY}"),
    "early_rise_{use}_less_{other}_k": ("K", f"difference of mean rises, {_EARLY}"),
    "value_{use}_over_{other}": (
        "1",
        "chance that {use} ends with a larger objective than {other} (Vargha and Delaney's A)",
    ),
    "value_{use}_over_{other}_low": ("1", "lower end of its 95 % interval"),
    "value_{use}_over_{other}_high": ("1", "upper end of its 95 % interval"),
}
SEARCHED = Vocabulary(_PRINTED | _WEIGHTED | _KEPT | _BASELINES | _SEARCHES | _DIFFERENCES)
"""What the step `staging` finds."""

_OF_FRONT = "NSGA-II's front of time and {kept} rise"
_NO_MORE = "with no more than the printed {kept} rise, {calibration}"
FRONT = Vocabulary(
    {
        "{kept}_front_points": ("1", f"charges of {_OF_FRONT}"),
        "{kept}_dominating_points": ("1", f"those faster and cooler than printed, {_OF_FRONT}"),
        "{kept}_farthest_above_scan_k": ("K", f"farthest that {_OF_FRONT} lies above the scan"),
        "{kept}_time_less_at_printed_rise_share": ("1", f"time saved at the printed rise, {_OF_FRONT}"),
        "{calibration}_printed_{kept}_k": ("K", "printed {kept} rise, {calibration}"),
        "{calibration}_rise_after_stage_3_k": ("K", "printed rise after the third stage, {calibration}"),
        "{calibration}_same_{kept}_s": ("s", f"least charging time {_NO_MORE}"),
        "{calibration}_same_{kept}_share": ("1", f"by how much it is less, {_NO_MORE}"),
        "{end}_same_{kept}_share": (
            "1",
            "{end} share of the printed time saved at the same {kept} rise, of all calibrations",
        ),
    }
)
"""What the step `front` finds."""
