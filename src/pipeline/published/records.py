"""A published statement and the closed set of predicates that can answer one."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from pipeline.published.operands import Operand, Reading, Value, values
from pipeline.published.words import Basis
from pipeline.record import Record


class Told(Record):
    """How the sentence of a predicate calls what it compares, where the names of quantities do not read well."""

    of: str = Field(default="", description="what is compared; the names below then tell its values apart")
    called: tuple[str, ...] = Field(default=(), description="names of what is compared, in order, without bare numbers")

    @model_validator(mode="after")
    def _a_name_each(self) -> Told:
        given = len(compared(self))
        if self.called and len(self.called) != given:
            raise ValueError(f"called has {len(self.called)} names for {given} values")
        return self


def compared(told: Told) -> list[Operand]:
    """Return what a predicate compares, in order, without bare numbers."""
    parts = (getattr(told, name) for name in ("value", "to", "than", "among") if hasattr(told, name))
    listed = [one for part in parts for one in (part if isinstance(part, tuple) else (part,))]
    return [one for one in listed if not isinstance(one, float)]


class CloseTo(Told):
    """Limits on the distance between a value and the number it should have."""

    value: Operand
    to: Operand
    tolerance: float | None = Field(default=None, gt=0, description="largest distance [unit of the statement]")
    relative_tolerance: float | None = Field(default=None, gt=0, description="largest distance over the number [1]")

    @model_validator(mode="after")
    def _one_tolerance(self) -> CloseTo:
        if (self.tolerance is None) == (self.relative_tolerance is None):
            raise ValueError("give exactly one of tolerance and relative_tolerance")
        return self


class Ordered(Told):
    """Two operands of which one must exceed the other by a required margin."""

    value: Operand
    than: Operand
    by: float = Field(default=0.0, ge=0, description="required margin [unit of the statement]")


class Extreme(Told):
    """A value and those it must outdo."""

    value: Operand
    among: tuple[Operand, ...] = Field(min_length=1, description="the others")
    by: float = Field(default=0.0, ge=0, description="required margin [unit of the statement]")


class Range(Told):
    """A value and the closed range it must lie in."""

    value: Operand
    low: float
    high: float

    @model_validator(mode="after")
    def _ordered(self) -> Range:
        if self.low >= self.high:
            raise ValueError(f"low {self.low:g} must be below high {self.high:g}")
        return self


class TablePair(Record):
    """Two tables (`artefact.table`) that must agree in every cell of the columns named."""

    published: str = Field(pattern=r"^[\w/-]+\.\w+$")
    computed: str = Field(pattern=r"^[\w/-]+\.\w+$")
    by: tuple[str, ...] = Field(min_length=1, description="columns that identify a row in both")
    columns: dict[str, str] = Field(min_length=1, description="column of the published table -> of the computed one")
    tolerance: float = Field(gt=0, description="largest distance of a cell [unit of the statement]")


class Close(Record):
    """`close: {value, to, tolerance}`."""

    close: CloseTo


class Less(Record):
    """`less: {value, than, by}`."""

    less: Ordered


class Greater(Record):
    """`greater: {value, than, by}`."""

    greater: Ordered


class Smallest(Record):
    """`smallest: {value, among, by}`."""

    smallest: Extreme


class Largest(Record):
    """`largest: {value, among, by}`."""

    largest: Extreme


class Within(Record):
    """`within: {value, low, high}`."""

    within: Range


class TableEquals(Record):
    """`table_equals: {published, computed, by, columns, tolerance}`."""

    table_equals: TablePair


class AllOf(Record):
    """`all: [...]`: every part must hold; its margin is the smallest of theirs, in shares of what each allows."""

    all: tuple[Check, ...] = Field(min_length=1)


_PREDICATES = ("close", "less", "greater", "smallest", "largest", "within", "table_equals", "all")


def _kind(check: Any) -> str | None:
    keys = check if isinstance(check, dict) else getattr(type(check), "model_fields", {})
    return next((name for name in _PREDICATES if name in keys), None)


Check = Annotated[
    Annotated[Close, Tag("close")]
    | Annotated[Less, Tag("less")]
    | Annotated[Greater, Tag("greater")]
    | Annotated[Smallest, Tag("smallest")]
    | Annotated[Largest, Tag("largest")]
    | Annotated[Within, Tag("within")]
    | Annotated[TableEquals, Tag("table_equals")]
    | Annotated[AllOf, Tag("all")],
    Discriminator(
        _kind, custom_error_type="predicate", custom_error_message="must be one of " + ", ".join(_PREDICATES)
    ),
]
"""A predicate: a mapping with one key, its name."""

AllOf.model_rebuild()


class Size(Record):
    """How large the paper's experiment was, and the numbers that say how large this run's is."""

    ours: tuple[Reading, ...] = Field(min_length=1, description="numbers of this run")
    paper: tuple[float, ...] = Field(min_length=1, description="the paper's, in the same order")

    @model_validator(mode="after")
    def _alike(self) -> Size:
        if len(self.ours) != len(self.paper):
            raise ValueError(f"{len(self.ours)} numbers of ours beside {len(self.paper)} of the paper")
        return self


class Statement(Record):
    """One number, table, figure or claim of a paper, and how it is put to the test."""

    title: str = Field(default="", description="what it is called on a page; its identifier in words without one")
    where: str = Field(min_length=1, description="where it stands in the paper")
    says: str = Field(min_length=1, description="what it says, in the paper's words where they are words")
    form: Literal["number", "table", "figure", "claim"] = Field(
        default="claim", description="what is published: a printed number, a table, a figure, or words"
    )
    basis: Basis = Field(
        description="paper_data: arithmetic of the paper alone; mathematics: follows from what it defines; model: "
        "our simulation; search: our searches and trainings; none: too little is given"
    )
    reading: str = Field(default="", description="how the words became a predicate, and why this tolerance")
    conditions: str = Field(default="", description="what of the paper's conditions we could not keep")
    check: Check | None = Field(default=None, description="the predicate; none where the basis is none")
    missing: str = Field(default="", description="what is missing; for basis none")
    assessed_by: str = Field(default="", description="what would assess a claim that no study here looks at")
    ours: tuple[Operand, ...] = Field(default=(), description="for basis none: what this run comes to, as ours")
    asks: Size | None = Field(default=None, description="how large a run must be to answer it")
    fitted_with: str = Field(default="", description="another statement, whose parameters were fitted to this one too")
    unit: str = Field(default="1", description="unit of the values compared")

    @model_validator(mode="after")
    def _checkable_or_not(self) -> Statement:
        if self.basis == "none" and (self.check is not None or not self.missing):
            raise ValueError("basis none takes no check and says what is missing")
        if self.basis != "none" and (self.ours or self.assessed_by):
            raise ValueError(f"basis {self.basis} takes neither ours nor assessed_by, which are for basis none")
        if self.basis != "none" and (self.check is None or self.missing):
            raise ValueError(f"basis {self.basis} takes a check, and nothing missing")
        return self


def needs(statement: Statement) -> set[str]:
    """Return the names of the inputs a statement's predicate reads; the plan makes an edge from each."""
    return {value.artefact for value in read_values(statement)} | {
        table.rpartition(".")[0] for pair in read_tables(statement) for table in (pair.published, pair.computed)
    }


def read_values(statement: Statement) -> list[Value]:
    """Return every artefact value a statement reads: its predicate, what it shows as ours, and its size."""
    found = values(statement.check) if statement.check is not None else []
    size = [] if statement.asks is None else list(statement.asks.ours)
    return [*found, *(value for one in statement.ours for value in values(one)), *size]


def read_tables(statement: Statement) -> list[TablePair]:
    """Return every pair of tables a statement's predicate compares."""
    return [part.table_equals for part in _parts(statement.check) if isinstance(part, TableEquals)]


def _parts(check: Check | None) -> list[Check]:
    if isinstance(check, AllOf):
        return [part for inner in check.all for part in _parts(inner)]
    return [] if check is None else [check]
