"""Front: the stages and the calibrations of the battery in; the front of time and rise, and what calibration does."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline import quantity, schemas, tables
from pipeline import schemas_staging as declared
from pipeline.cell.records import Battery
from pipeline.objective.staging import Charges, charge
from pipeline.objective.staging_cases import starts_of
from pipeline.objective.staging_front import KEPT, Gain, Points, evolved, gains, quantities, scanned
from pipeline.objective.staging_optimum import Problem
from pipeline.objective.staging_records import FrontSettings, Reading, StagingProblem
from pipeline.objective.staging_runs import problem_of


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Find the front twice for each rise, and the best currents under each calibration."""
    asked = StagingProblem.model_validate(settings["problem"])
    problem = problem_of(asked.battery, asked.plan, asked.current_a, asked.rise)
    how, seed = FrontSettings.model_validate(settings["front"]), int(settings["seed"])
    starts, printed = starts_of(problem, int(settings["starts"]), seed), np.array(asked.plan.currents_a)
    fronts = {reading: _fronts(problem._replace(reading=reading), how, starts, seed) for reading in KEPT}
    batteries = {item["name"]: Battery.model_validate(item["battery"]) for item in settings["calibrations"]}
    calibrated: dict[str, tuple[Charges, list[Gain]]] = {}
    for name, battery in batteries.items():
        other = problem_of(battery, asked.plan, asked.current_a, asked.rise)
        calibrated[name] = charge(other.grid, printed[None, :]), gains(other, printed, starts)
    numbers = quantities(fronts, charge(problem.grid, printed[None, :]), calibrated)
    tables.write(declared.FRONT, _front(fronts), output / "front.parquet")
    tables.write(declared.CALIBRATIONS, _calibrations(calibrated), output / "calibrations.parquet")
    tables.write(declared.CALIBRATION_STAGES, _stages(calibrated, printed), output / "calibration_stages.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(numbers), output / "quantities.parquet")


def _fronts(problem: Problem, how: FrontSettings, starts: Any, seed: int) -> tuple[Points, Points]:
    return evolved(problem, how, seed), scanned(problem, how, starts[:2])


def _front(fronts: Mapping[Reading, tuple[Points, Points]]) -> dict[str, list[Any]]:
    rows = [
        (method, reading, float(time), float(rise))
        for reading, pair in fronts.items()
        for method, points in zip(("nsga2", "scan"), pair, strict=True)
        for time, rise in zip(points.time_s, points.rise_k, strict=True)
    ]
    return _columns(("method", "rise", "time_s", "rise_k"), rows)


def _calibrations(calibrated: Mapping[str, tuple[Charges, list[Gain]]]) -> dict[str, list[Any]]:
    rows = [
        (name, gain.reading, gain.printed_s, gain.rise_k, gain.optimum.value, gain.saved_share, gain.optimum.agreeing)
        for name, (_, gained) in calibrated.items()
        for gain in gained
    ]
    return _columns(("calibration", "rise", "printed_s", "rise_k", "best_s", "saved_share", "agreeing_share"), rows)


def _stages(calibrated: Mapping[str, tuple[Charges, list[Gain]]], printed: Any) -> dict[str, list[Any]]:
    rows = []
    for name, (shown, gained) in calibrated.items():
        best = [gain.optimum.currents_a for gain in gained]
        for stage, current in enumerate(printed):
            found = (float(currents[stage]) for currents in best)
            rows.append((name, stage + 1, float(current), float(shown.end_k[0, stage]), *found))
    return _columns(("calibration", "stage", "printed_a", "printed_rise_k", "same_peak_a", "same_final_a"), rows)


def _columns(names: tuple[str, ...], rows: list[tuple[Any, ...]]) -> dict[str, list[Any]]:
    return {name: [row[place] for row in rows] for place, name in enumerate(names)}
