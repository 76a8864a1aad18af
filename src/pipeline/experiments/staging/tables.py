"""Tables of the search for the currents of a staged charge."""

from __future__ import annotations

from pipeline.kernel.tables import CHAOTIC, ELSEWHERE, Column, Table, TableFile, numbers

_RISES = (
    Column("final_k", "K", "temperature rise at the end"),
    Column("positive_k", "K", "sum of the rises of those stages that end warmer than they began"),
    Column("peak_k", "K", "highest temperature rise"),
)
_TIME = Column("time_s", "s", "charging time")
_STAGE = Column("stage", "1", "number of the stage, from 1", "integer")
_REPLICATE = Column("replicate", "1", "number of the replicate, from 0", "integer")
STAGING_RUNS = Table(
    "staging_runs",
    "Where the replicates of a search for stage currents stood at the compared number of charges, and at a tenth of it",
    (
        _REPLICATE,
        Column("evaluations", "1", "charges computed", "integer"),
        Column("value", "1", "the objective"),
        _TIME,
        *_RISES,
        Column("early_evaluations", "1", "charges computed, at a tenth", "integer"),
        Column("early_value", "1", "the objective then"),
        Column("early_time_s", "s", "charging time then"),
        *(Column(f"early_{column.name}", "K", f"{column.description}, then") for column in _RISES),
    ),
)
STAGING_RUN_CURRENTS = Table(
    "staging_run_currents",
    "The currents each replicate of a search found",
    (_REPLICATE, _STAGE, Column("current_a", "A", "current of the stage")),
)
STAGING_COURSE = Table(
    "staging_course",
    "The course of a search for stage currents, over its replicates",
    (
        Column("evaluations", "1", "charges computed so far", "integer"),
        Column("low", "1", "lower quartile of the best objective so far"),
        Column("median", "1", "its median"),
        Column("high", "1", "its upper quartile"),
    ),
)
STAGING_CASES = Table(
    "staging_cases",
    "Staged charges that matter: printed, found by the search, best of all",
    (
        Column("case", "", "name of the charge", "text"),
        Column("weights", "", "name of the weights it is the best for, where it is", "text", optional=True),
        Column(
            "rise", "", "final, positive or peak: the rise that is weighed or kept, where one is", "text", optional=True
        ),
        Column("found_by", "", "the search, or the local solver", "text"),
        _TIME,
        *_RISES,
        Column("peak_v", "V", "highest voltage of the battery"),
    ),
)
STAGING_CURRENTS = Table(
    "staging_currents",
    "The stages of those charges",
    (
        Column("case", "", "name of the charge", "text"),
        _STAGE,
        Column("soc_from", "1", "state of charge at its start"),
        Column("soc_to", "1", "state of charge at its end"),
        Column("current_a", "A", "its current"),
        Column("length_s", "s", "its time"),
        Column("rise_k", "K", "temperature rise over the ambient at its end"),
    ),
)
FRONT = Table(
    "front",
    "Charges of which none is both faster and cooler than another, a row per charge",
    (
        Column("method", "", "nsga2, or scan: the local solver over the weights", "text"),
        Column("rise", "", "final or peak", "text"),
        _TIME,
        Column("rise_k", "K", "that rise"),
    ),
)
CALIBRATIONS = Table(
    "calibrations",
    "How much faster the best currents are than the printed ones, a row per calibration and rise kept",
    (
        Column("calibration", "", "name of the calibration", "text"),
        Column("rise", "", "the rise that is kept: final or peak", "text"),
        Column("printed_s", "s", "charging time with the printed currents"),
        Column("rise_k", "K", "their rise"),
        Column("best_s", "s", "least charging time with no more than that rise"),
        Column("saved_share", "1", "by how much that is less"),
        Column("agreeing_share", "1", "share of the starts from which the local solver ended there"),
    ),
)
CALIBRATION_STAGES = Table(
    "calibration_stages",
    "Stages under each calibration",
    (
        Column("calibration", "", "name of the calibration", "text"),
        _STAGE,
        Column("printed_a", "A", "printed current"),
        Column("printed_rise_k", "K", "rise at the end of the stage with the printed currents"),
        Column("same_peak_a", "A", "current of the fastest charge with their highest rise"),
        Column("same_final_a", "A", "current of the fastest charge with their final rise"),
    ),
)

# A search goes its own way from the first rounding error on; it ends where it does everywhere, or nearly.
_HISTORY = {"replicate": ELSEWHERE, "*evaluations": ELSEWHERE, "stage": ELSEWHERE, "*": CHAOTIC}
_GENETIC = {"genetic_evaluations": ELSEWHERE, "genetic_replicates": ELSEWHERE, "*genetic*": CHAOTIC}
_BY_NSGA2 = ("*_dominating_points", "*_above_scan_k", "*_at_printed_rise_share")

SEARCH = {
    "runs": TableFile("runs.parquet", STAGING_RUNS, elsewhere=_HISTORY),
    "run_currents": TableFile("run_currents.parquet", STAGING_RUN_CURRENTS, elsewhere=_HISTORY),
    "course": TableFile("course.parquet", STAGING_COURSE, elsewhere=_HISTORY),
}
"""What the step `staging_search` writes."""
GATHERED = {
    "cases": TableFile("cases.parquet", STAGING_CASES),
    "currents": TableFile("currents.parquet", STAGING_CURRENTS),
    **numbers(_GENETIC),
}
"""What the step `staging` writes."""
TRADED = {
    "front": TableFile("front.parquet", FRONT, elsewhere={"time_s": CHAOTIC, "rise_k": CHAOTIC}),
    "calibrations": TableFile("calibrations.parquet", CALIBRATIONS),
    "calibration_stages": TableFile("calibration_stages.parquet", CALIBRATION_STAGES),
    **numbers(dict.fromkeys(_BY_NSGA2, CHAOTIC)),
}
"""What the step `front` writes."""
