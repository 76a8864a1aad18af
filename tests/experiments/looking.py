"""What a reader would hold against a drawn figure, found on its artists: what is hidden, cut, or written over."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import FancyBboxPatch
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from pipeline.report import style

HYPHEN = re.compile(r"(?<![\w.)\]])-(?=\.?\d)|(?<= )-(?= )|\de-\d")
_SOME = 0.05
"""Of many symbols so many may lie beneath others."""
_NEAR_PX = 1.2
"""Centres of lines or symbols closer than this lie upon each other [px]."""


def faults(drawing: Figure) -> list[str]:
    """Return what is wrong with a figure that has been laid out, each fault in a line.

    Found are words outside the figure or over other words, over a legend or a curve; "[1]" for a unit; a hyphen for a
    minus; empty fields; a curve wholly beneath another and a symbol beneath one at least as large.
    """
    found = faults_of_words(drawing)
    for number, axes in enumerate(drawing.axes):
        if axes.get_visible():
            found += [f"field {number}: {one}" for one in (*_hidden_curves(axes), *_hidden_symbols(axes))]
    return found


def shows_published(drawing: Figure) -> bool:
    """Tell whether anything in a figure is drawn in the colour of published values."""
    colours = [to_hex(line.get_color()) for axes in drawing.axes for line in axes.lines]
    colours += [to_hex(text.get_color()) for axes in drawing.axes for text in axes.texts]
    colours += [to_hex(one) for axes in drawing.axes for group in axes.collections for one in group.get_facecolor()]
    return style.PUBLISHED in colours


def faults_of_words(drawing: Figure) -> list[str]:
    """Return the faults that made-up numbers show as well as real ones: those of words, and empty fields."""
    renderer = FigureCanvasAgg(drawing).get_renderer()
    style.typeset(drawing)
    drawing.draw_without_rendering()
    found = [*_of_words(drawing, renderer), *_of_boxes(drawing)]
    for number, axes in enumerate(drawing.axes):
        if axes.get_visible():
            found += [f"field {number}: {one}" for one in _empty(axes)]
    return found


def _of_words(drawing: Figure, renderer: Any) -> Iterator[str]:
    unseen = _unseen(drawing)
    shown = [
        (text, Text.get_window_extent(text, renderer))
        for text in drawing.findobj(Text)
        if isinstance(text, Text) and text.get_text().strip() and text.get_visible() and id(text) not in unseen
    ]
    shown = [(text, box) for text, box in shown if box.width > 0.0 and box.height > 0.0]
    for text, box in shown:
        words = text.get_text()
        if "[1]" in words:
            yield f"{words!r} has [1] for a unit"
        if HYPHEN.search(words) and "$" not in words:
            yield f"{words!r} has a hyphen for a minus"
        if not _inside(drawing.bbox, box):
            yield f"{words!r} is cut by the edge of the figure"
    for (one, first), (other, second) in itertools.combinations(shown, 2):
        if _overlap(first, second) > 4.0:
            yield f"{one.get_text()!r} lies over {other.get_text()!r}"
    for axes in drawing.axes:
        yield from _over_curves(drawing, axes, [one for one in shown if one[0].axes is axes], renderer)


def _over_curves(drawing: Figure, axes: Axes, shown: list[tuple[Text, Bbox]], renderer: Any) -> Iterator[str]:
    legends = [one for one in axes.get_children() if isinstance(one, Legend)]
    boxes = [(_where(legend), legend.get_window_extent(renderer).padded(-2.0)) for legend in legends]
    boxes += [(repr(text.get_text()), box.padded(-1.0)) for text, box in shown if text in axes.texts]
    for name, box in boxes:
        for line in _curves(axes):
            if _share(_along(line), box) > 0.0:
                yield f"{name} lies over the curve {_called(line)}"
        for symbol, points, _ in _symbols(axes):
            count = round(_share(points, box) * len(points))
            if count:
                yield f"{name} lies over {count} symbols of {_called(symbol)}"


def _where(legend: Legend) -> str:
    return f"the legend {[text.get_text() for text in legend.get_texts()]}"


def _of_boxes(drawing: Figure) -> Iterator[str]:
    """Find words that run over the edge of the box they stand in."""
    for axes in drawing.axes:
        boxes = [patch for patch in axes.patches if isinstance(patch, FancyBboxPatch)]
        for text in axes.texts:
            box = Text.get_window_extent(text)
            for patch in boxes:
                outer = patch.get_window_extent()
                middle = ((box.x0 + box.x1) / 2.0, (box.y0 + box.y1) / 2.0)
                if outer.contains(*middle) and not _inside(outer, box, 0.0):
                    yield f"{text.get_text()!r} runs over the edge of its box"


def _empty(axes: Axes) -> Iterator[str]:
    if not axes.axison:
        return
    if not (axes.lines or axes.patches or axes.collections or axes.images or axes.texts):
        yield "is empty"


def _hidden_curves(axes: Axes) -> Iterator[str]:
    curves = [line for line in _curves(axes) if line.get_linestyle() not in ("None", "")]
    paths = [_along(line) for line in curves]
    for (lower, under), (upper, over) in itertools.permutations(zip(curves, paths, strict=True), 2):
        if not _is_above(axes, upper, lower) or not len(under) or not len(over):
            continue
        is_wider = lower.get_linewidth() >= upper.get_linewidth() + 0.39
        if not is_wider and _covered(under, over) > 0.97:
            yield f"the curve {_called(lower)} lies beneath {_called(upper)}"


def _hidden_symbols(axes: Axes) -> Iterator[str]:
    symbols = list(_symbols(axes))
    for (one, first, small), (other, second, large) in itertools.permutations(symbols, 2):
        if not _is_above(axes, other, one) or small > large + 0.5 or _is_hollow(other):
            continue
        apart = np.hypot(*(first[:, None, :] - second[None, :, :]).transpose(2, 0, 1))
        count = int(np.count_nonzero(apart.min(axis=1, initial=np.inf) < _NEAR_PX))
        if count > _SOME * len(first):
            yield f"{count} of {len(first)} symbols of {_called(one)} lie beneath those of {_called(other)}"


def _symbols(axes: Axes) -> Iterator[tuple[Any, np.ndarray, float]]:
    for line in axes.lines:
        if line.get_marker() in ("None", "", ",", None) or not line.get_visible():
            continue
        points = _data(line)
        every = line.get_markevery()
        if isinstance(every, tuple):
            every = slice(every[0], None, every[1])
        if isinstance(every, slice):
            points = points[every]
        points = _within(axes, points)
        if len(points):
            yield line, points, float(line.get_markersize())
    for collection in axes.collections:
        if isinstance(collection, PathCollection) and collection.get_visible():
            points = collection.get_offset_transform().transform(np.asarray(collection.get_offsets()))
            points = _within(axes, points[np.isfinite(points).all(axis=1)])
            if len(points):
                yield collection, points, float(np.sqrt(np.max(collection.get_sizes())))


def _is_hollow(symbol: Any) -> bool:
    return isinstance(symbol, Line2D) and str(symbol.get_markerfacecolor()) == "none"


def _within(axes: Axes, points: np.ndarray) -> np.ndarray:
    box = axes.bbox.padded(1.0)
    return points[
        (points[:, 0] >= box.x0) & (points[:, 0] <= box.x1) & (points[:, 1] >= box.y0) & (points[:, 1] <= box.y1)
    ]


def _curves(axes: Axes) -> list[Line2D]:
    """Return the lines that show data: neither those across the axes nor mere rows of symbols."""
    return [
        line
        for line in axes.lines
        if line.get_visible()
        and line.get_linestyle() not in ("None", "")
        and line.get_transform() == axes.transData
        and len(np.atleast_1d(line.get_xdata())) > 2
        and line.get_label() != "_reference"
    ]


def _data(line: Line2D) -> np.ndarray:
    points = np.column_stack([np.atleast_1d(line.get_xdata()), np.atleast_1d(line.get_ydata())]).astype(float)
    with np.errstate(all="ignore"):
        points = line.get_transform().transform(points)
    return points[np.isfinite(points).all(axis=1)]


def _along(line: Line2D, step_px: float = 1.0) -> np.ndarray:
    """Return places along a curve, as drawn, a pixel apart."""
    with np.errstate(all="ignore"):
        path = line.get_path().transformed(line.get_transform())
    points = np.asarray(path.vertices)
    points = points[np.isfinite(points).all(axis=1)]
    if line.axes is None or len(points) < 2:
        return points
    points = _thinned(points)
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    places = np.linspace(0.0, length[-1], int(min(4000, max(2.0, length[-1] / step_px))))
    found = np.column_stack([np.interp(places, length, points[:, axis]) for axis in (0, 1)])
    return _within(line.axes, found)


def _thinned(points: np.ndarray) -> np.ndarray:
    return points[:: max(1, len(points) // 20000)]


def _covered(under: np.ndarray, over: np.ndarray) -> float:
    from scipy.spatial import cKDTree

    return float(np.mean(cKDTree(over).query(under)[0] < _NEAR_PX))


def _share(points: np.ndarray, box: Bbox) -> float:
    if not len(points) or box.width <= 0.0 or box.height <= 0.0:
        return 0.0
    x, y = points.T
    return float(np.mean((x > box.x0) & (x < box.x1) & (y > box.y0) & (y < box.y1)))


def _is_above(axes: Axes, one: Any, other: Any) -> bool:
    order = axes.get_children()
    return bool((one.get_zorder(), order.index(one)) > (other.get_zorder(), order.index(other)))


def _unseen(drawing: Figure) -> set[int]:
    """Return the identities of texts that are never drawn: ticks outside the limits, what belongs to no axis."""
    found: set[int] = set()
    for axes in drawing.axes:
        for axis in (axes.xaxis, axes.yaxis, *([axes.zaxis] if hasattr(axes, "zaxis") else [])):
            every = [tick for ticks in (axis.majorTicks, axis.minorTicks) for tick in ticks]
            shown = [] if not (axes.axison and axes.get_visible()) else axis._update_ticks()
            found |= {id(label) for tick in every if tick not in shown for label in (tick.label1, tick.label2)}
            if not axes.axison:
                found |= {id(axis.label), id(axis.offsetText)}
        if not axes.get_visible():
            found |= {id(text) for text in axes.findobj(Text)}
    return found


def _inside(outer: Bbox, inner: Bbox, slack: float = 1.0) -> bool:
    return bool(
        inner.x0 >= outer.x0 - slack
        and inner.x1 <= outer.x1 + slack
        and inner.y0 >= outer.y0 - slack
        and inner.y1 <= outer.y1 + slack
    )


def _overlap(one: Bbox, other: Bbox) -> float:
    """Return the area two boxes share [px²], but for a pixel at each edge."""
    width = min(one.x1, other.x1) - max(one.x0, other.x0) - 2.0
    height = min(one.y1, other.y1) - max(one.y0, other.y0) - 2.0
    return float(max(0.0, width) * max(0.0, height))


def _called(artist: Any) -> str:
    return repr(str(artist.get_label()))
