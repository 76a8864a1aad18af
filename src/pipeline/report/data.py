"""What figures read: artefacts by the name of their input, read when first asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline import schemas, tables

Columns = dict[str, NDArray[Any]]

FILES: dict[str, tuple[str, tables.Table]] = {
    "curves": ("curves.parquet", schemas.PANEL_CURVES),
    "points": ("points.parquet", schemas.PANEL_POINTS),
    "parameters": ("parameters.parquet", schemas.PANEL_PARAMETERS),
    "supply": ("supply.parquet", schemas.SUPPLY),
    "trace": ("trace.bdf.parquet", schemas.CHARGE_TRACE),
    "waveform": ("waveform.parquet", schemas.CHARGE_WAVEFORM),
    "summary": ("summary.parquet", schemas.CHARGE_SUMMARY),
    "phases": ("phases.parquet", schemas.CHARGE_PHASES),
    "energy": ("energy.parquet", schemas.CHARGE_ENERGY),
}
"""Table name -> file inside its input's folder, and its declaration."""


@dataclass(frozen=True)
class ModeLabel:
    """How a charging mode is called, and its knobs: numbers in ampere, volt, hertz, found values put in."""

    title: str
    knobs: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ReportData:
    """The artefacts of one run.

    Arguments
    ---------
    inputs : input name -> folder: `panel`, `supply`, `charge/<comparison>/<mode>`.
    modes : mode name -> label, in the order of the run; the order decides colours and line styles.
    comparisons : comparison name -> title, in the order of the run.
    """

    inputs: Mapping[str, Path]
    modes: Mapping[str, ModeLabel]
    comparisons: Mapping[str, str]

    @cached_property
    def _read(self) -> dict[tuple[str, str], Columns]:
        return {}

    def table(self, source: str, name: str) -> Columns:
        """Return a table of an input as column name -> array.

        Arguments
        ---------
        source : input name.
        name : one of `FILES`.

        Raises
        ------
        KeyError : no such input or table.
        TableError : the file is not what was declared.
        """
        if (source, name) not in self._read:
            file, declaration = FILES[name]
            self._read[source, name] = tables.read(declaration, self.inputs[source] / file)
        return self._read[source, name]

    def shown(self, comparison: str | None) -> list[str]:
        """Return the comparisons a figure shows: the one asked for, or all that have a charge."""
        names = [comparison] if comparison else list(self.comparisons)
        return [name for name in names if self.charged(name)]

    def charged(self, comparison: str) -> list[str]:
        """Return the modes charged in a comparison, in the order of the run."""
        return [mode for mode in self.modes if f"charge/{comparison}/{mode}" in self.inputs]

    def charge(self, comparison: str, mode: str, name: str) -> Columns:
        """Return a table of one charge."""
        return self.table(f"charge/{comparison}/{mode}", name)

    def quantities(self, comparison: str, mode: str) -> dict[str, float]:
        """Return the numbers of a charge's summary by name, without those it did not get to."""
        summary = self.charge(comparison, mode, "summary")
        pairs = zip(summary["quantity"], summary["value"], strict=True)
        return {str(name): float(value) for name, value in pairs if value is not None and np.isfinite(value)}
