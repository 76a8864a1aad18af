"""Inputs and outputs of steps as the runner makes them, from the tables that the steps declare."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pipeline.kernel import registry
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.kernel.tables import TableFile

STEP_OF_KIND = {"second_charge": "charge", "figure": "figures"}


def declared(name: str) -> Mapping[str, TableFile]:
    """Return the tables of the step that makes an input of some name."""
    kind = name.split("/")[0]
    return registry.steps()[STEP_OF_KIND.get(kind, kind)].tables


def inputs(folders: Mapping[str, Path]) -> Inputs:
    """Return artefacts as a step reads them: input name -> folder."""
    return Inputs(folders, {name: declared(name) for name in folders})


def output(step: str, folder: Path) -> Output:
    """Return a folder as a step fills it; made where it is not there."""
    folder.mkdir(parents=True, exist_ok=True)
    return Output(folder, registry.steps()[step].tables)
