"""What figures and pages read: artefacts by the name of their input, under the titles of modes and comparisons."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pipeline.kernel.artefacts import Columns, Inputs

__all__ = ["Columns", "ModeLabel", "ReportData", "report_data"]


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
    inputs : the artefacts, by the name of the input.
    modes : mode name -> label, in the order of the run; the order decides colours and line styles.
    comparisons : comparison name -> title, in the order of the run.
    settings : parts of the configuration that the experiments declare as labels; found values put in.
    """

    inputs: Inputs
    modes: Mapping[str, ModeLabel]
    comparisons: Mapping[str, str]
    settings: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def table(self, source: str, name: str) -> Columns:
        """Return a table of an input as column name -> array; errors as for `Inputs.table`."""
        return self.inputs.table(source, name)

    def holds(self, source: str, name: str) -> bool:
        """Tell whether an input of this run has a table."""
        return self.inputs.holds(source, name)

    @property
    def cells(self) -> tuple[str, ...]:
        """Return the titles of the batteries, where the reader asks for them."""
        return tuple(self.settings.get("cells", {}).get("titles", ()))

    def second(self) -> ReportData:
        """Return the charges of the second battery as if they were the first's, and nothing else."""
        names = {f"charge/{name.partition('/')[2]}": name for name in self.inputs.of_kind("second_charge")}
        cells = {"cells": {"titles": self.cells[1:]}}
        return ReportData(self.inputs.renamed(names), self.modes, self.comparisons, cells)

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

    def numbers(self, source: str) -> dict[str, float]:
        """Return the named numbers that a step found, without those that have no value."""
        return self.inputs.numbers(source)

    def quantities(self, comparison: str, mode: str) -> dict[str, float]:
        """Return the numbers of a charge's summary by name, without those it did not get to."""
        return self.inputs.numbers(f"charge/{comparison}/{mode}", "summary")


def report_data(settings: Mapping[str, Any], inputs: Inputs) -> ReportData:
    """Return the artefacts of a run under the titles of its modes and comparisons, in the order of the run."""
    labels = settings["settings"]
    knobs = labels.get("modes", {})
    modes = {one["name"]: ModeLabel(one["title"], knobs.get(one["name"], {})) for one in settings["modes"]}
    comparisons = {one["name"]: one["title"] for one in settings["comparisons"]}
    return ReportData(inputs, modes, comparisons, labels)
