"""A figure's card, and the module that draws it; light to import."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, cast

from pydantic import Field, model_validator

from pipeline.errors import best_matches
from pipeline.kernel import registry
from pipeline.record import Record

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


class NoOptions(Record):
    """A figure with nothing to choose."""


class Drawing(Protocol):
    """What every module in the folder `figures` of an experiment offers.

    `READS` names what it reads: kinds of artefacts (the first words of their names) and labels, the parts of the
    configuration that experiments declare for readers.
    """

    READS: tuple[str, ...]
    Options: type[Record]

    def draw(self, figure: FigureCard, data: ReportData) -> Figure:
        """Draw the card's figure from the artefacts."""
        ...


class FigureCard(Record):
    """One figure of a report; its identifier, the key it stands under, is also its file name."""

    draw: str = Field(description="module in the folder `figures` of an experiment that draws it")
    paper: str = Field(default="", description="its number in the paper; empty for a figure of our own")
    title: str = Field(min_length=1, description="title, for people")
    caption: str = Field(min_length=1, description="what it shows; also its text for those who cannot see it")
    comparison: str | None = Field(default=None, description="the only comparison it shows; all of them without")
    options: dict[str, Any] = Field(default_factory=dict, description="what the drawing module lets one choose")

    module: str = Field(
        default="",
        pattern=r"^pipeline\.experiments\.\w+\.figures\.\w+$",
        description="dotted name of that module; found by its name",
    )

    @model_validator(mode="before")
    @classmethod
    def _found(cls, values: Any) -> Any:
        known = registry.figures()
        if not isinstance(values, dict) or not isinstance(values.get("draw"), str):
            return values
        if "module" in values:
            if values["module"] != known.get(values["draw"]):
                raise ValueError("module is found by the name of the drawing; leave it out")
            return values
        if values["draw"] not in known:
            raise ValueError(f"draw is {values['draw']!r}, which draws nothing; {best_matches(values['draw'], known)}")
        return values | {"module": known[values["draw"]]}

    @model_validator(mode="after")
    def _drawable(self) -> FigureCard:
        self.chosen()
        return self

    def drawing(self) -> Drawing:
        """Return the module that draws it."""
        return cast("Drawing", import_module(self.module))

    def chosen(self) -> Any:
        """Return the options as the record that the drawing module declares."""
        return self.drawing().Options(**self.options)

    def reads(self) -> tuple[str, ...]:
        """Return what the drawing module reads."""
        return self.drawing().READS

    def owner(self) -> str:
        """Return the experiment that the drawing module belongs to."""
        return self.module.split(".")[2]
