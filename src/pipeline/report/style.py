"""One look for every figure, the mark of each mode, and files with the same bytes every time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D


STYLE_FILE = Path(__file__).with_name("charge.mplstyle")
WIDTH_IN = 9.0
GREY = "#777777"


class Mark(NamedTuple):
    """Colour, line style and marker of a mode: each alone tells it from the others."""

    colour: str
    line: Any
    marker: str


# Paul Tol's high-contrast triple, its yellow darkened, which keeps its order of lightness in grey print.
MARKS = (
    Mark("#004488", "-", "o"),
    Mark("#c48a00", (0, (6, 1.6)), "s"),
    Mark("#bb3355", (0, (6, 1.6, 1.4, 1.6)), "^"),
    Mark("#222222", (0, (1.4, 1.4)), "D"),
    Mark("#228833", (0, (9, 2.5)), "v"),
    Mark("#55aadd", (0, (6, 1.4, 1.4, 1.4, 1.4, 1.4)), "P"),
    Mark("#885599", (0, (3, 1.5)), "X"),
)
PARTS = ("#004488", "#6699cc", "#c48a00", "#eecc66", "#bb3355", "#ee99aa", "#228833", "#999999", "#ccbbdd")
"""Colours of the parts of a whole, dark and light in turn."""


def marks(modes: Sequence[str]) -> dict[str, Mark]:
    """Return the mark of each mode by its place in the run's list; after seven modes they start again."""
    return {mode: MARKS[place % len(MARKS)] for place, mode in enumerate(modes)}


@contextmanager
def active() -> Iterator[None]:
    """Draw and save with the style file on matplotlib's own defaults, whatever the user's settings are."""
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(matplotlib.rc_params_from_file(STYLE_FILE, use_default_template=False))
        yield


def figure(height_in: float) -> Figure:
    """Return an empty figure of the page's width."""
    from matplotlib.figure import Figure

    return Figure(figsize=(WIDTH_IN, height_in), layout="constrained")


def handles(titles: dict[str, str], found: dict[str, Mark], markers: bool = True) -> list[Line2D]:
    """Return what a legend shows of each mark."""
    from matplotlib.lines import Line2D

    return [
        Line2D(
            [], [], color=mark.colour, linestyle=mark.line, marker=mark.marker if markers else "", label=titles[mode]
        )
        for mode, mark in found.items()
    ]


def legend(drawing: Figure, titles: dict[str, str], found: dict[str, Mark], markers: bool = False) -> None:
    """Put one legend of the modes above all axes."""
    drawing.legend(handles=handles(titles, found, markers), loc="outside upper center", ncols=min(len(found), 4) or 1)


def nothing(axes: Axes, why: str, across: str = "", up: str = "") -> None:
    """Say in an empty field why nothing is drawn in it, perhaps with the names of its axes."""
    axes.set(xlabel=across or axes.get_xlabel(), ylabel=up or axes.get_ylabel())
    axes.text(0.5, 0.5, why, transform=axes.transAxes, ha="center", va="center", color=GREY)


def save(drawing: Figure, folder: Path, name: str) -> list[Path]:
    """Write a figure as SVG and PNG without date, version or any other trace of when and where.

    Arguments
    ---------
    drawing : the figure.
    folder, name : where, and the file name without ending.

    Returns
    -------
    The paths written.
    """
    paths = [folder / f"{name}.svg", folder / f"{name}.png"]
    _settle(drawing)
    drawing.savefig(paths[0], format="svg", metadata={"Date": None, "Creator": None, "Title": name})
    drawing.savefig(paths[1], format="png", metadata={"Software": None})
    return paths


def _settle(drawing: Figure) -> None:
    """Lay a figure out once, for both files, and round where its axes are.

    The layout's solver orders its equations by addresses in memory, so that its last digits differ from run to run; SVG
    names a clipped region after all of its digits.
    """
    from matplotlib.transforms import Bbox

    drawing.draw_without_rendering()
    drawing.set_layout_engine("none")
    for axes in drawing.axes:
        if axes.get_axes_locator() is None:
            axes.set_position(Bbox.from_bounds(*(round(edge, 6) for edge in axes.get_position(original=True).bounds)))
