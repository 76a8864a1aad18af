"""Checks the names in statements when a study is composed, before anything runs."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping

from pipeline.errors import UserError, best_matches
from pipeline.published.names import NAMED, kind, source, summary_quantities, tables_of
from pipeline.published.operands import Value
from pipeline.published.records import Statement, read_tables, read_values


def check(
    statements: Mapping[str, Statement],
    inputs: Collection[str],
    soc_marks: Iterable[float],
    calibrated_to: Collection[str] = (),
    found: Mapping[str, Collection[str]] | None = None,
) -> None:
    """Refuse a statement that names something the study cannot make.

    Arguments
    ---------
    statements : identifier -> statement.
    inputs : every input the study could make, also those that this run leaves out.
    soc_marks : SOC marks of the charge settings; a summary has quantities for each.
    calibrated_to : identifiers that sources of parameters name.
    found : kind of input -> names of the numbers in its table `quantities`; a kind left out is not checked.

    Raises
    ------
    UserError : an unknown input, mode, comparison, table, quantity or identifier, with the best matches.
    """
    quantities = {"charge": summary_quantities(soc_marks), **(found or {})}
    for name, stated in statements.items():
        for value in read_values(stated):
            _check_table(name, f"{value.artefact}.{value.table}", inputs)
            _check_names(name, value, quantities)
        for pair in read_tables(stated):
            _check_table(name, pair.published, inputs)
            _check_table(name, pair.computed, inputs)
    for identifier in calibrated_to:
        if identifier not in statements:
            raise UserError(
                f"a source is calibrated to {identifier!r}, which no published statement is called; "
                + best_matches(identifier, statements)
            )


def _check_table(statement: str, path: str, inputs: Collection[str]) -> None:
    artefact, _, table = path.rpartition(".")
    if artefact not in inputs:
        raise UserError(f"published.{statement}: {_unknown_input(artefact, inputs)}")
    if table not in tables_of(artefact) and source(kind(artefact), table) is None:
        raise UserError(
            f"published.{statement}: {artefact} has no table {table!r}; " + best_matches(table, tables_of(artefact))
        )


def _unknown_input(artefact: str, inputs: Collection[str]) -> str:
    parts = artefact.split("/")
    charges = [name.split("/") for name in inputs if kind(name) == "charge"]
    if parts[0] == "charge" and len(parts) == 3:
        for place, word in ((1, "comparison"), (2, "mode")):
            known = {charge[place] for charge in charges}
            if parts[place] not in known:
                return f"unknown {word} {parts[place]!r} in {artefact}; {best_matches(parts[place], known)}"
    return f"unknown input {artefact!r}; {best_matches(artefact, inputs)}"


def _check_names(statement: str, value: Value, quantities: Mapping[str, Collection[str]]) -> None:
    declared = source(kind(value.artefact), value.table)
    if declared is None:
        return
    if value.table in NAMED:
        known, names = set(quantities.get(kind(value.artefact), [value.quantity])), [value.quantity]
    else:
        known = {column.name for column in declared.table.columns}
        names = [value.quantity, *value.where]
    for name in names:
        if name not in known:
            raise UserError(
                f"published.{statement}: {value.artefact}.{value.table} has nothing called {name!r}; "
                + best_matches(name, known)
            )
