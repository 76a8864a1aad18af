"""Function runs: a function study and one of its functions in; the runs of every search on it, and their curves out."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

from pipeline.experiments.functions.statistics import Curve, Runs
from pipeline.experiments.functions.statistics import run as searched
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.search.function_records import FunctionStudy


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Run every search on the function, in every placement."""
    study = FunctionStudy.model_validate(settings["functions"])
    found = list(searched(study, settings["function"], int(settings["seed"]), told=partial(print, flush=True)))
    output.write("runs", _joined([_runs(one) for one, _ in found]))
    output.write("curves", _joined([_curve(curve) for _, curve in found]))


def _runs(one: Runs) -> dict[str, Any]:
    count = len(one.value)
    return _where(one, count) | {
        "replicate": np.arange(count),
        "value": one.value,
        "value_at_budget": one.value_at_budget,
        "generations": np.where(np.isfinite(one.generations), one.generations, np.nan),
        "evaluations": np.where(np.isfinite(one.evaluations), one.evaluations, np.nan),
        "spent": one.spent,
    }


def _curve(one: Curve) -> dict[str, Any]:
    columns = ("generation", "evaluations", "low", "median", "high", "mean")
    return _where(one, len(one.generation)) | {name: getattr(one, name) for name in columns}


def _where(one: Runs | Curve, count: int) -> dict[str, Any]:
    return {name: np.full(count, getattr(one, name), dtype=object) for name in ("function", "placement", "search")}


def _joined(parts: list[dict[str, Any]]) -> dict[str, Any]:
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
