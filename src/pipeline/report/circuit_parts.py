"""A pen for circuit diagrams: schemdraw's symbols between two points, in the colour of the part they belong to."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Point = tuple[float, float]
INK, DIM, SIGNAL = "#222222", "#a0a0a0", "#6e3b10"


class Circuit:
    """Draws symbols into axes; `done` puts them there.

    Arguments
    ---------
    axes : where to draw; schemdraw itself is only imported here, since it brings pyplot along.
    lit, dim : parts drawn in colour, and in grey.
    colour : of the parts in colour.
    """

    def __init__(self, axes: Axes, lit: Collection[str] = (), dim: Collection[str] = (), colour: str = INK) -> None:
        import schemdraw

        self._axes = axes
        self._lit, self._dim, self._colour = lit, dim, colour
        self._drawing: Any = schemdraw.Drawing(canvas=axes, show=False)
        self._drawing.config(fontsize=9, lw=1.4, color=INK)

    def colour_of(self, part: str) -> str:
        """Return the colour of a part."""
        if part in self._lit:
            return self._colour
        return DIM if part in self._dim else INK

    def part(self, symbol: str, part: str, start: Point, end: Point) -> None:
        """Draw a symbol of schemdraw from one point to another."""
        from schemdraw import elements

        lit = part in self._lit
        element = getattr(elements, symbol)().at(start).to(end).color(self.colour_of(part))
        self._drawing += element.linewidth(2.2 if lit else 1.3).zorder(3 if lit else 2)

    def placed(self, symbol: str, part: str, place: Point, anchor: str, flip: bool = False) -> None:
        """Draw a symbol of schemdraw with one of its terminals at a place; `flip` turns it upside down."""
        from schemdraw import elements

        element = getattr(elements, symbol)().at(place).anchor(anchor).color(self.colour_of(part)).right()
        self._drawing += (element.flip() if flip else element).linewidth(1.3).zorder(2)

    def switch(self, part: str, start: Point, end: Point, closed: bool, name: str) -> None:
        """Draw a switch, open or closed, with its name or what it does beside it."""
        if closed:
            centre = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
            self.part("Line", part, start, end)
            along = (0.5, 0.0) if start[1] == end[1] else (0.0, 0.5)
            for sign in (-1, 1):
                place = (centre[0] + sign * along[0], centre[1] + sign * along[1])
                self._axes.plot(
                    *place, "o", color="white", markeredgecolor=self.colour_of(part), markersize=5, zorder=6
                )
        else:
            self.part("Switch", part, start, end)
        level = start[1] == end[1]
        place = ((start[0] + end[0]) / 2, start[1] - 0.55) if level else (start[0] + 0.75, (start[1] + end[1]) / 2)
        self.text(place, name, "center" if level else "left", self.colour_of(part))

    def text(self, place: Point, words: str, side: str = "center", colour: str = INK) -> None:
        """Write words at a place."""
        self._axes.text(*place, words, ha=side, va="center", fontsize=9, color=colour, linespacing=1.35, zorder=7)

    def box(
        self, centre: Point, width: float, height: float, words: str, colour: str = INK, round_by: float = 0.1
    ) -> None:
        """Draw a box with words in it."""
        from matplotlib.patches import FancyBboxPatch

        corner = (centre[0] - width / 2, centre[1] - height / 2)
        shape = FancyBboxPatch(
            corner, width, height, boxstyle=f"round,pad=0,rounding_size={round_by}", facecolor="#f4f6f9",
            edgecolor=colour, linewidth=1.2, zorder=3,
        )  # fmt: skip
        self._axes.add_patch(shape)
        self.text(centre, words)

    def arrow(
        self,
        start: Point,
        end: Point,
        words: str = "",
        beside: bool = False,
        part: str = "",
        ends_at: Point | None = None,
    ) -> None:
        """Draw an arrow, round one corner where `ends_at` is given."""
        from matplotlib.patches import FancyArrowPatch

        colour, line = (SIGNAL, (0, (5, 2))) if part == "signal" else (INK, "-")
        if ends_at is not None:
            self._axes.plot(*zip(start, end, strict=True), color=colour, linestyle=line, linewidth=1.3, zorder=2)
        tip = FancyArrowPatch(
            end if ends_at is not None else start, ends_at or end, arrowstyle="-|>", mutation_scale=11, color=colour,
            linewidth=1.3, linestyle=line, shrinkA=0, shrinkB=0, zorder=2,
        )  # fmt: skip
        self._axes.add_patch(tip)
        middle = ((start[0] + end[0]) / 2, (start[1] + end[1]) / 2)
        if words:
            self.text(
                (middle[0] + 0.2, middle[1]) if beside else (middle[0], middle[1] + 0.4),
                words,
                "left" if beside else "center",
            )

    def done(self, horizontal: Point, vertical: Point) -> None:
        """Draw what was collected, and show the given part of the plane."""
        if self._drawing.elements:
            self._drawing.draw(show=False, canvas=self._axes)
        self._axes.set_xlim(*horizontal)
        self._axes.set_ylim(*vertical)
        self._axes.set_aspect("equal")
        self._axes.set_axis_off()
