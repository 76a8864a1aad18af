"""What a statement may name: inputs, tables and numbers, as the experiments declare them; checked when planned."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from pipeline.errors import UserError, best_matches
from pipeline.kernel import registry
from pipeline.kernel.experiment import Step, kind_of
from pipeline.kernel.tables import TableFile, find
from pipeline.published.operands import Value, values
from pipeline.published.records import read_tables, read_values
from pipeline.published.reference import PRINTED, is_named, reference_tables


def check_statements(study: Any) -> None:
    """Refuse a statement that names something the study cannot make, and a source calibrated to no statement.

    Arguments
    ---------
    study : the root record of the configuration.

    Raises
    ------
    UserError : an unknown input, mode, comparison, table, quantity or identifier, with the best matches.
    """
    known = _Known(study)
    for name, stated in study.published.items():
        for value in read_values(stated):
            known.check_value(name, value)
        for pair in read_tables(stated):
            known.check_table(name, pair.published)
            known.check_table(name, pair.computed)
        if stated.fitted_with and stated.fitted_with not in study.published:
            raise UserError(
                f"published.{name}.fitted_with: no statement {stated.fitted_with!r}; "
                + best_matches(stated.fitted_with, study.published)
            )
    for name, choice in study.answer.items():
        for value in (one for operand in choice.among.values() for one in values(operand)):
            known.check_value(name, value, "answer")
    words = _told(study)
    for name in study.called:
        if name not in words:
            raise UserError(f"called.{name}: no statement reads {name!r}; {best_matches(name, words)}")
    own = f"{study.study.name}."
    fitted = {source.to for source in study.sources.values() if source.to is not None}
    for identifier in sorted(name.removeprefix(own) for name in fitted if name.startswith(own)):
        if identifier not in study.published:
            raise UserError(
                f"a source is calibrated to {identifier!r}, which no published statement is called; "
                + best_matches(identifier, study.published)
            )


def _told(study: Any) -> set[str]:
    """Return the names that sentences of verdicts say: of quantities, columns, rows, and parts of artefacts' names."""
    found = [value for stated in study.published.values() for value in read_values(stated)]
    rows = {str(part) for value in found for pair in value.where.items() for part in pair}
    artefacts = {part for value in found for part in value.artefact.split("/")}
    return {value.quantity for value in found} | rows | artefacts


class _Known:
    """What a study could make, also with modes that this run leaves out."""

    def __init__(self, study: Any) -> None:
        experiments = registry.experiments().values()
        references = {f"{PRINTED}/{path.stem}" for path in reference_tables()}
        self.inputs = {name for one in experiments for name in one.inputs(study)} | references
        self._fields = {step: fields for one in experiments for step, fields in one.fields(study).items()}
        self._numbers = cache(self._named)

    def check_table(self, statement: str, path: str, part: str = "published") -> None:
        """Refuse a table that nothing makes."""
        artefact, _, table = path.rpartition(".")
        if artefact not in self.inputs:
            raise UserError(f"{part}.{statement}: {self._unknown_input(artefact)}")
        if kind_of(artefact) == PRINTED:
            known: Iterable[str] = {artefact.split("/")[-1]}
            if table in known:
                return
        elif _declared(artefact, table) is not None:
            return
        else:
            known = _step(artefact).tables
        raise UserError(f"{part}.{statement}: {artefact} has no table {table!r}; {best_matches(table, known)}")

    def check_value(self, statement: str, value: Value, part: str = "published") -> None:
        """Refuse a column or a number that nothing makes."""
        self.check_table(statement, f"{value.artefact}.{value.table}", part)
        declared = _declared(value.artefact, value.table)
        if declared is None:
            return
        if is_named(declared.table):
            known, names = self._numbers(kind_of(value.artefact)), [value.quantity]
        else:
            known, names = {column.name for column in declared.table.columns}, [value.quantity, *value.where]
        for name in names:
            if known is not None and name not in known:
                raise UserError(
                    f"{part}.{statement}: {value.artefact}.{value.table} has nothing called {name!r}; "
                    + best_matches(name, known)
                )

    def _named(self, of: str) -> set[str] | None:
        """Return the names of the numbers of a kind of input; none where this run does not say what they are."""
        step = _step(of)
        fields: Mapping[str, Iterable[object]] | None = self._fields.get(step.name)
        return None if step.quantities is None or fields is None else step.quantities.names(fields)

    def _unknown_input(self, artefact: str) -> str:
        """Say which part of a name is unknown, where those before it are known."""
        parts = artefact.split("/")
        alike = [name.split("/") for name in self.inputs]
        for place, part in enumerate(parts):
            known = {one[place] for one in alike if len(one) == len(parts)}
            if place and known and part not in known:
                return f"unknown {part!r} in {artefact}; {best_matches(part, known)}"
            alike = [one for one in alike if one[place : place + 1] == [part]]
        return f"unknown input {artefact!r}; {best_matches(artefact, self.inputs)}"


def _step(artefact: str) -> Step:
    return registry.steps()[kind_of(artefact)]


def _declared(artefact: str, table: str) -> TableFile | None:
    return None if kind_of(artefact) == PRINTED else find(_step(artefact).tables, table)
