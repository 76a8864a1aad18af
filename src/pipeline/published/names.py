"""Names a statement may use: the tables of each kind of input and the quantities of a charge's summary."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from pipeline import schemas
from pipeline.tables import Table


class Source(NamedTuple):
    """Where a table lies in its input's folder, how it is declared, and its column of time if it has one."""

    file: str
    table: Table
    time: str | None = None


SOURCES: dict[tuple[str, str], Source] = {
    ("panel", "points"): Source("points.parquet", schemas.PANEL_POINTS),
    ("panel", "parameters"): Source("parameters.parquet", schemas.PANEL_PARAMETERS),
    ("supply", "supply"): Source("supply.parquet", schemas.SUPPLY, "time_s"),
    ("charge", "summary"): Source("summary.parquet", schemas.CHARGE_SUMMARY),
    ("charge", "trace"): Source("trace.bdf.parquet", schemas.CHARGE_TRACE, "Test Time / s"),
    ("charge", "phases"): Source("phases.parquet", schemas.CHARGE_PHASES),
    ("charge", "energy"): Source("energy.parquet", schemas.CHARGE_ENERGY),
    ("ensemble", "ensemble"): Source("ensemble.parquet", schemas.ENSEMBLE),
}
"""(first word of the input's name, table) -> where it is; one line more serves another kind of artefact."""

_SUMMARY = (
    "end_time_s end_soc charge_in_ah charge_out_ah energy_in_wh energy_out_wh charge_efficiency energy_efficiency "
    "peak_temperature_c peak_temperature_rise_k end_temperature_c mean_current_a time_at_voltage_limit_s "
    "time_at_supply_limit_s energy_balance_residual steps edges control_changes"
)


def kind(artefact: str) -> str:
    """Return the kind of an input: the first word of its name."""
    return artefact.split("/")[0]


def tables_of(artefact: str) -> set[str]:
    """Return the tables an input has; a reference has one, of its own name."""
    if kind(artefact) == "reference":
        return {artefact.split("/")[-1]}
    return {table for of, table in SOURCES if of == kind(artefact)}


def summary_quantities(soc_marks: Iterable[float]) -> set[str]:
    """Return the names of the numbers in a charge's summary, for the SOC marks of its settings."""
    marks = {name for mark in soc_marks for name in (f"time_to_soc_{mark:g}_s", f"temperature_rise_at_soc_{mark:g}_k")}
    return marks | set(_SUMMARY.split())
