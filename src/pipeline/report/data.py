"""What figures read: artefacts by the name of their input, read when first asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline import (
    schemas,
    schemas_day,
    schemas_functions,
    schemas_network,
    schemas_staging,
    schemas_supply,
    schemas_switched,
    schemas_trade_off,
    schemas_validation,
    tables,
)

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
    "orbit": ("orbit.parquet", schemas.ORBIT),
    "bifurcation": ("bifurcation.parquet", schemas.ORBIT),
    "disorder": ("disorder.parquet", schemas.DISORDER),
    "quantities": ("quantities.parquet", schemas.QUANTITIES),
    "loss": ("loss.parquet", schemas.OBJECTIVE_LOSS),
    "map": ("map.parquet", schemas.FREQUENCY_MAP),
    "contour": ("contour.parquet", schemas.FREQUENCY_CONTOUR),
    "factorial": ("factorial.parquet", schemas.TUNING_FACTORIAL),
    "agreement": ("agreement.parquet", schemas.TUNING_AGREEMENT),
    "trade_off": ("trade_off.parquet", schemas_trade_off.TRADE_OFF),
    "statistics": ("statistics.parquet", schemas.SEARCH_STATISTICS),
    "comparison": ("comparison.parquet", schemas.SEARCH_COMPARISON),
    **schemas_switched.FILES,
    **schemas_day.FILES,
    **schemas_validation.FILES,
    **schemas_supply.FILES,
    **{table: found for (_, table), found in schemas_network.ARTEFACTS.items()},
    "staging_runs": ("runs.parquet", schemas_staging.STAGING_RUNS),
    "staging_course": ("course.parquet", schemas_staging.STAGING_COURSE),
    "staging_cases": ("cases.parquet", schemas_staging.STAGING_CASES),
    "staging_currents": ("currents.parquet", schemas_staging.STAGING_CURRENTS),
    "front": ("front.parquet", schemas_staging.FRONT),
    "calibrations": ("calibrations.parquet", schemas_staging.CALIBRATIONS),
    "calibration_stages": ("calibration_stages.parquet", schemas_staging.CALIBRATION_STAGES),
    "function_curves": ("curves.parquet", schemas_functions.FUNCTION_CURVES),
    "function_statistics": ("statistics.parquet", schemas_functions.FUNCTION_STATISTICS),
    "function_tests": ("tests.parquet", schemas_functions.FUNCTION_TESTS),
    "function_ranks": ("ranks.parquet", schemas_functions.FUNCTION_RANKS),
}
"""Table name -> file inside its input's folder, and its declaration."""

OF_EACH: dict[str, tables.Table] = {
    "runs": schemas.TUNING_RUNS,
    "levels": schemas.TUNING_LEVELS,
    "sums": schemas.TUNING_SUMS,
    "anova": schemas.TUNING_ANOVA,
    "history": schemas.SEARCH_HISTORY,
    "best": schemas.SEARCH_BEST,
}
"""Tables of which an input has several, called `<name>_<table>`: `rerun_levels`, `swarm_history`."""


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
    inputs : input name -> folder: `panel`, `supply`, `chaos`, `objective`, `tuning`, `search`,
        `charge/<comparison>/<mode>`, `second_charge/<comparison>/<mode>`.
    modes : mode name -> label, in the order of the run; the order decides colours and line styles.
    comparisons : comparison name -> title, in the order of the run.
    settings : `system` and `algorithm`, as configured, where the figure reads them; found values put in.
    cells : titles of the batteries, where there are two.
    """

    inputs: Mapping[str, Path]
    modes: Mapping[str, ModeLabel]
    comparisons: Mapping[str, str]
    settings: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    cells: Sequence[str] = ()

    @cached_property
    def _read(self) -> dict[tuple[str, str], Columns]:
        return {}

    def table(self, source: str, name: str) -> Columns:
        """Return a table of an input as column name -> array.

        Arguments
        ---------
        source : input name.
        name : one of `FILES`, or a name of the configuration before one of `OF_EACH`, e.g. `swarm_history`.

        Raises
        ------
        KeyError : no such input or table.
        TableError : the file is not what was declared.
        """
        if (source, name) not in self._read:
            file, declaration = _file(name)
            self._read[source, name] = tables.read(declaration, self.inputs[source] / file)
        return self._read[source, name]

    def second(self) -> ReportData:
        """Return the charges of the second battery as if they were the first's, and nothing else."""
        prefix = "second_charge/"
        found = {
            f"charge/{name.removeprefix(prefix)}": folder
            for name, folder in self.inputs.items()
            if name.startswith(prefix)
        }
        return ReportData(found, self.modes, self.comparisons, {}, self.cells[1:])

    def holds(self, source: str, name: str) -> bool:
        """Tell whether an input of this run has a table."""
        return source in self.inputs and (self.inputs[source] / _file(name)[0]).is_file()

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
        return _named(self.table(source, "quantities"))

    def quantities(self, comparison: str, mode: str) -> dict[str, float]:
        """Return the numbers of a charge's summary by name, without those it did not get to."""
        return _named(self.charge(comparison, mode, "summary"))


def _named(columns: Columns) -> dict[str, float]:
    pairs = zip(columns["quantity"], columns["value"], strict=True)
    return {str(name): float(value) for name, value in pairs if value is not None and np.isfinite(value)}


def _file(name: str) -> tuple[str, tables.Table]:
    if name in FILES:
        return FILES[name]
    of, _, part = name.rpartition("_")
    if not of or part not in OF_EACH:
        raise KeyError(name)
    return f"{of}.{part}.parquet", OF_EACH[part]
