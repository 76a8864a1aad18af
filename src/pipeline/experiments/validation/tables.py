"""The tables of the checks of the engine."""

from __future__ import annotations

from pipeline.kernel.tables import Column, Table, TableFile

VALIDATION_ROWS = Table(
    "validation_rows",
    "What a check of the engine finds, a row per quantity",
    (
        Column("quantity", "", "what was computed", "text"),
        Column("value", "see unit", "its value; empty where it could not be computed here", optional=True),
        Column("unit", "", "its unit", "text"),
        Column("relation", "", "at most, at least, or empty where there is no bound", "text", optional=True),
        Column("bound", "see unit", "what it is held to", optional=True),
        Column("finding", "", "holds, broken, not installed, or told where there is no bound", "text"),
        Column("note", "", "what must be known to read it", "text"),
    ),
)
VALIDATION_CURVES = Table(
    "validation_curves",
    "Errors and differences of a check of the engine, a row per point",
    (
        Column("group", "", "field that the line is drawn in", "text"),
        Column("series", "", "name of the line", "text"),
        Column("across", "", "what x is, with its unit", "text"),
        Column("up", "", "what y is, with its unit", "text"),
        Column("x", "see across", "in the unit that `across` names"),
        Column("y", "see up", "in the unit that `up` names"),
    ),
)

VALIDATION = {
    "rows": TableFile("rows.parquet", VALIDATION_ROWS),
    "curves": TableFile("curves.parquet", VALIDATION_CURVES),
}
"""What a check writes."""
