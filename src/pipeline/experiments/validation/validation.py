"""Validation: a check of the engine and what it takes in; its rows and curves out."""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.experiments.validation.records import Curve, Found
from pipeline.kernel.artefacts import Inputs, Output


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Run the check; a bound that is broken is written down, not raised."""
    found: Found = importlib.import_module(f"{__package__}.{settings['check']}").check(settings["settings"])
    output.rows("rows", found.rows)
    output.write("curves", _curves(found.curves))


def _curves(curves: list[Curve]) -> dict[str, Any]:
    texts = ("group", "series", "across", "up")
    found: dict[str, Any] = {name: [getattr(one, name) for one in curves for _ in one.x] for name in texts}
    for name in ("x", "y"):
        found[name] = np.concatenate([getattr(one, name) for one in curves]) if curves else np.zeros(0)
    return found
