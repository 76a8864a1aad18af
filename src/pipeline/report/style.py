"""One look for every figure, the mark of each mode, and files with the same bytes every time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D


STYLE_FILE = Path(__file__).with_name("charge.mplstyle")
WIDTH_IN = 9.0
GREY = "#6f6f6f"
INK = "#333333"
SHADE = "#c9ced3"
"""Of a stretch that is told apart from the rest: outside a validity, within a tolerance."""
PUBLISHED = "#aa00ff"
"""Of what a paper gives, and of nothing else."""
BEHIND_WORDS = {"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 1.0}


class Mark(NamedTuple):
    """Colour, line style and marker of a mode: each alone tells it from the others."""

    colour: str
    line: Any
    marker: str


class Part(NamedTuple):
    """Colour and hatch of a part of a whole: each alone tells it from the others."""

    colour: str
    hatch: str


# At least 3:1 on white, and apart for every kind of colour blindness: a test computes both.
MARKS = (
    Mark("#004488", "-", "o"),
    Mark("#c17f00", (0, (6, 1.6)), "s"),
    Mark("#cc3366", (0, (6, 1.6, 1.4, 1.6)), "^"),
    Mark("#222222", (0, (1.4, 1.4)), "D"),
    Mark("#0a6640", (0, (9, 2.5)), "v"),
    Mark("#4a97d6", (0, (6, 1.4, 1.4, 1.4, 1.4, 1.4)), "P"),
    Mark("#6e3b10", (0, (3, 1.5)), "X"),
)
PARTS = (
    Part("#004488", ""),
    Part("#9cc0e6", "//"),
    Part("#c17f00", "++"),
    Part("#f0d68a", "\\\\"),
    Part("#cc3366", "x"),
    Part("#f2b8c6", "--"),
    Part("#0a6640", "||"),
    Part("#979797", "/-"),
    Part("#d3c4e3", "\\|"),
)
REST = Part("#e4e4e4", "")
"""What is left over when the parts worth a name are taken out."""


def marks(modes: Sequence[str]) -> dict[str, Mark]:
    """Return the mark of each mode by its place in the run's list; after seven modes they start again."""
    return {mode: MARKS[place % len(MARKS)] for place, mode in enumerate(modes)}


def parts(names: Sequence[str]) -> dict[str, Part]:
    """Return the colour and hatch of each part of a whole by its place; after nine parts they start again."""
    return {name: PARTS[place % len(PARTS)] for place, name in enumerate(names)}


def filled(part: Part) -> dict[str, Any]:
    """Return how a bar or an area of a part is drawn: the hatch in what stands out from its colour."""
    return {
        "facecolor": part.colour,
        "hatch": part.hatch,
        "hatchcolor": "#ffffff" if is_dark(part.colour) else "#555555",
        "edgecolor": "white",
        "linewidth": 0.6,
    }


def is_dark(colour: str) -> bool:
    """Tell whether white is easier to read on a colour than black, by the luminance of WCAG 2."""
    shares = [int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5)]
    linear = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return sum(weight * share for weight, share in zip((0.2126, 0.7152, 0.0722), linear, strict=True)) < 0.18


def label(name: str, unit: str) -> str:
    """Return the words of an axis; what is counted or a ratio has no unit."""
    return name if unit in ("", "1") else f"{name} [{unit}]"


def signed(number: str) -> str:
    """Return a formatted number, or a text with numbers in it, with true minus signs."""
    return _MINUS.sub("\N{MINUS SIGN}", number)


# A hyphen before a number is a minus, and so is one that stands between spaces or behind an exponent's e.
_MINUS = re.compile(r"(?<![\w.)\]])-(?=\.?\d)|(?<= )-(?= )|(?<=\de)-(?=\d)")


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
    above(drawing, handles(titles, found, markers), size=10.0)


def above(
    drawing: Figure, keys: Sequence[Any], labels: Sequence[str] | None = None, size: float = 9.0, **look: Any
) -> None:
    """Put a legend above all axes, in as many columns as the width of the figure has room for.

    Arguments
    ---------
    keys : what is told; each bears its words, or `labels` has them.
    size : of the letters [points].
    look : further arguments of matplotlib's legend.
    """
    import numpy as np

    words = list(labels) if labels is not None else [str(key.get_label()) for key in keys]
    if not words:
        return
    handle = look.setdefault("handlelength", 3.2)
    # A letter is 0.6 of its size wide on the average; gaps are matplotlib's own, in sizes of the letters.
    room = 72.0 * float(drawing.get_figwidth()) / size - 2.0
    columns = next(
        (
            count
            for count in range(min(len(words), _MOST_COLUMNS), 1, -1)
            if sum(0.6 * max(map(len, part)) + handle + 2.8 for part in np.array_split(words, count)) < room
        ),
        1,
    )
    # As many entries in every column, but for the last.
    columns = -(-len(words) // -(-len(words) // columns))
    drawing.legend(keys, words, loc="outside upper center", ncols=columns, fontsize=size, **look)


_MOST_COLUMNS = 6


def nothing(axes: Axes, why: str, across: str = "", up: str = "") -> None:
    """Say in an empty field why nothing is drawn in it, perhaps with the names of its axes."""
    axes.set(xlabel=across or axes.get_xlabel(), ylabel=up or axes.get_ylabel())
    axes.text(0.5, 0.5, why, transform=axes.transAxes, ha="center", va="center", color=GREY)


def written_on(axes: Axes, place: float, words: str, part: Part, across: float) -> None:
    """Write the value of a part into its bar, on a ground of the bar's colour where a hatch would cross the words.

    Arguments
    ---------
    place, across : middle of the bar along the horizontal axis, and along the vertical one.
    """
    ink = "#ffffff" if is_dark(part.colour) else "#000000"
    ground = {"facecolor": part.colour, "edgecolor": "none", "pad": 0.8} if part.hatch else None
    axes.text(place, across, words, ha="center", va="center", fontsize=8, color=ink, bbox=ground)


def at_ends(axes: Axes, ends: Iterable[tuple[float, str, str]], apart: float = 0.08, size: float = 9.0) -> None:
    """Write the name of each curve beside its right end, none upon another; the limits of the axes must be set.

    Arguments
    ---------
    ends : value at the end, words, colour.
    apart : least distance of two names, as a share of the height of the axes.
    """
    scale = axes.transData + axes.transAxes.inverted()
    right = axes.get_xlim()[1]
    found = [(float(scale.transform((right, value))[1]), words, colour) for value, words, colour in ends]
    found.sort(key=lambda end: end[0])
    heights = spread([min(max(height, 0.0), 1.0) for height, *_ in found], apart)
    for height, (_, words, colour) in zip(heights, found, strict=True):
        axes.annotate(
            words, (1.0, height), xycoords="axes fraction", xytext=(5, 0), textcoords="offset points", va="center",
            color=colour, fontsize=size, annotation_clip=False,
        )  # fmt: skip


def spread(wanted: Sequence[float], apart: float) -> list[float]:
    """Return ascending places at least `apart` from each other, moved as a group from where they are wanted."""
    groups: list[list[float]] = []
    for place in wanted:
        groups.append([place])
        while len(groups) > 1 and _centre(groups[-1], apart)[0] - _centre(groups[-2], apart)[1] < apart:
            groups[-2:] = [groups[-2] + groups[-1]]
    return [_centre(group, apart)[0] + number * apart for group in groups for number in range(len(group))]


def _centre(group: Sequence[float], apart: float) -> tuple[float, float]:
    middle, half = sum(group) / len(group), apart * (len(group) - 1) / 2.0
    return middle - half, middle + half


def published(axes: Axes, value: float, words: str, upright: bool = False, at: float = 0.01) -> Line2D:
    """Draw a value that a paper gives as a line across the axes, with its words.

    Arguments
    ---------
    value : where it lies on the vertical axis, or on the horizontal one with `upright`.
    words : written along the line; empty for none.
    at : where the words begin, as a share of the other axis.
    """
    line = axes.axvline(value, **_PUBLISHED_LINE) if upright else axes.axhline(value, **_PUBLISHED_LINE)
    if words and upright:
        far = axes.transAxes.inverted().transform(axes.transData.transform((value, axes.get_ylim()[0])))[0] > 0.75
        axes.annotate(
            words, (value, at), xycoords=("data", "axes fraction"), xytext=(-4 if far else 4, 0),
            textcoords="offset points", color=PUBLISHED, fontsize=9, ha="right" if far else "left", va="center",
            bbox=BEHIND_WORDS,
        )  # fmt: skip
    elif words:
        axes.annotate(
            words, (at, value), xycoords=("axes fraction", "data"), xytext=(0, 3), textcoords="offset points",
            color=PUBLISHED, fontsize=9, va="bottom",
        )  # fmt: skip
    return line


def key_of_published(words: str) -> Line2D:
    """Return what a legend shows of lines at published values."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=words, **_PUBLISHED_LINE)


_PUBLISHED_LINE: dict[str, Any] = {"color": PUBLISHED, "linewidth": 1.2, "linestyle": (0, (4, 1.5)), "zorder": 2.5}
PUBLISHED_POINT: dict[str, Any] = {
    "color": PUBLISHED, "marker": "*", "markersize": 11, "linestyle": "", "markeredgecolor": "white",
    "markeredgewidth": 0.7, "zorder": 6,
}  # fmt: skip
"""How a point that a paper gives is plotted."""


def shaded(axes: Axes, moments: Any, where: Any, words: str = "", at: float = 0.12) -> Artist:
    """Shade a stretch over the whole height of the axes.

    Arguments
    ---------
    moments, where : places on the horizontal axis, and whether each belongs to it.
    words : written into its middle, where it is not empty; `at` is their height as a share of that of the axes.
    """
    band = axes.fill_between(
        moments, 0.0, 1.0, where=where, transform=axes.get_xaxis_transform(), facecolor=SHADE, alpha=0.55,
        linewidth=0.0, zorder=0,
    )  # fmt: skip
    if words and any(where):
        inside = [float(moment) for moment, is_inside in zip(moments, where, strict=True) if is_inside]
        axes.annotate(
            words, ((inside[0] + inside[-1]) / 2.0, at), xycoords=("data", "axes fraction"), ha="center", va="center",
            fontsize=8.5, color=INK,
        )  # fmt: skip
    return band


def stepped(ends: Any, means: Any, low: Any, high: Any) -> tuple[Any, Any]:
    """Return a curve of means over intervals whose jumps stand upright.

    A mean stands in the middle of its interval. Where the quantity jumps within one, between intervals in which it does
    not, the jump stands where the mean says that it was.

    Arguments
    ---------
    ends : when each interval ends; the first begins at 0.
    means, low, high : mean, least and largest value in each interval.
    """
    import numpy as np

    if len(means) < 3:
        return (np.asarray(ends) + np.concatenate([[0.0], ends[:-1]])) / 2.0, np.asarray(means)
    starts, least = np.concatenate([[0.0], ends[:-1]]), _JUMP * max(float(np.ptp(means)), 1e-12)
    split = np.asarray(high) - np.asarray(low) > least
    split[1:-1] &= ~split[:-2] & ~split[2:]
    split[[0, -1]] = False
    before, after = np.roll(means, 1), np.roll(means, -1)
    split &= np.abs(before - after) > least
    share = np.clip((means - after)[split] / (before - after)[split], 0.0, 1.0)
    edges = starts[split] + share * (ends - starts)[split]
    whole = np.flatnonzero(~split)
    beside = whole[:-1][(np.diff(whole) == 1) & (np.abs(np.diff(means[whole])) > least)]
    times = np.concatenate([[0.0], (starts + ends)[whole] / 2.0, edges, edges, ends[beside], ends[beside], ends[-1:]])
    values = np.concatenate(
        [means[:1], means[whole], before[split], after[split], means[beside], means[beside + 1], means[-1:]]
    )
    order = np.argsort(times, kind="stable")
    return times[order], values[order]


_JUMP = 0.02
"""What changes by more than this share of its range from one interval to the next, or within one, has jumped."""


def typeset(drawing: Figure) -> None:
    """Give every text of a figure true minus signs; matplotlib's own numbers at ticks have them."""
    from matplotlib.legend import Legend
    from matplotlib.text import Text

    owners = [drawing, *drawing.axes, *(child for axes in drawing.axes for child in axes.child_axes)]
    children = [child for owner in owners for child in owner.get_children()]
    texts = [child for child in children if isinstance(child, Text)]
    texts += [text for legend in children if isinstance(legend, Legend) for text in legend.get_texts()]
    texts += [axis.label for axes in drawing.axes for axis in (axes.xaxis, axes.yaxis)]
    for text in texts:
        if "-" in text.get_text() and "$" not in text.get_text():
            text.set_text(signed(text.get_text()))


def save(drawing: Figure, folder: Path, name: str) -> list[Path]:
    """Write a figure as SVG and PNG without date, version or any other trace of when and where.

    The canvases are asked directly: `savefig` draws each figure a second time before it writes.

    Arguments
    ---------
    drawing : the figure.
    folder, name : where, and the file name without ending.

    Returns
    -------
    The paths written.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    paths = [folder / f"{name}.svg", folder / f"{name}.png"]
    typeset(drawing)
    _settle(drawing)
    vector: Any = FigureCanvasSVG(drawing)
    with paths[0].open("w", encoding="utf-8", newline="\n") as file:
        vector.print_svg(file, metadata={"Date": None, "Creator": None, "Title": name})
    drawing.set_dpi(matplotlib.rcParams["savefig.dpi"])
    pixels: Any = FigureCanvasAgg(drawing)
    pixels.print_png(paths[1], metadata={"Software": None})
    return paths


def _settle(drawing: Figure) -> None:
    """Lay a figure out once, for both files, and round where its axes are.

    The layout's solver orders its equations by addresses in memory, so that its last digits differ from run to run; SVG
    names a clipped region after all of its digits.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.transforms import Bbox

    FigureCanvasAgg(drawing)
    engine = drawing.get_layout_engine()
    if engine is not None:
        engine.execute(drawing)
    drawing.set_layout_engine("none")
    for axes in drawing.axes:
        if axes.get_axes_locator() is None:
            axes.set_position(Bbox.from_bounds(*(round(edge, 6) for edge in axes.get_position(original=True).bounds)))
