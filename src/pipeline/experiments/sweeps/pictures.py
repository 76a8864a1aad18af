"""The pictures of a sweep: lines over one swept key, heat maps over two, parallel coordinates beyond."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.sweeps.reading import Outcome
from pipeline.report import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Columns = Mapping[str, Sequence[Any]]
_MOST_TICKS = 12


def draw(keys: Mapping[str, str], outcomes: Sequence[Outcome], columns: Columns) -> Figure:
    """Draw the outcomes of one comparison over the swept keys.

    Arguments
    ---------
    keys : swept keys -> what they are called, with the unit.
    outcomes : what is looked at first, mode by mode.
    columns : column of the table -> values.
    """
    if len(keys) == 1:
        return _lines(keys, outcomes, columns)
    return _maps(keys, outcomes, columns) if len(keys) == 2 else _parallel(keys, outcomes, columns)


def _lines(keys: Mapping[str, str], outcomes: Sequence[Outcome], columns: Columns) -> Figure:
    """Draw a field for each quantity, a line for each mode."""
    (key,) = keys
    titles = list(dict.fromkeys((one.title, one.unit) for one in outcomes))
    marks = style.marks(list(dict.fromkeys(one.charge for one in outcomes)))
    drawing = style.figure(3.2)
    fields = np.atleast_1d(drawing.subplots(1, len(titles)))
    places, labels = _places(columns[key])
    order = np.argsort(places, kind="stable")
    for axes, (title, unit) in zip(fields, titles, strict=True):
        for one in (one for one in outcomes if one.title == title):
            mark = marks[one.charge]
            values = _numbers(one, columns)[order]
            marker = mark.marker if len(places) <= 60 else ""
            line = "" if labels else mark.line
            shown = {"color": mark.colour, "linestyle": line, "marker": mark.marker if labels else marker}
            axes.plot(places[order], values, label=one.charge, **shown)
        axes.set(xlabel=keys[key], ylabel=_axis(title, unit))
        _ticks(axes, labels)
    lines, names = fields[0].get_legend_handles_labels()
    drawing.legend(lines, names, loc="outside upper center", ncols=min(4, len(names)))
    return drawing


def _maps(keys: Mapping[str, str], outcomes: Sequence[Outcome], columns: Columns) -> Figure:
    """Draw a heat map for each quantity and mode, one scale of colours for each quantity."""
    across, up = keys
    titles = list(dict.fromkeys((one.title, one.unit) for one in outcomes))
    charges = list(dict.fromkeys(one.charge for one in outcomes))
    drawing = style.figure(0.6 + 2.3 * len(titles))
    fields = drawing.subplots(len(titles), len(charges), squeeze=False, sharex=True, sharey=True)
    (x, x_labels), (y, y_labels) = (_ranks(columns[key]) for key in (across, up))
    for row, (title, unit) in zip(fields, titles, strict=True):
        found = {one.charge: _numbers(one, columns) for one in outcomes if one.title == title}
        every = np.concatenate(list(found.values()))
        finite = every[np.isfinite(every)]
        low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
        for axes, charge in zip(row, charges, strict=True):
            grid = np.full((len(y_labels), len(x_labels)), np.nan)
            grid[y, x] = found[charge]
            axes.imshow(grid, origin="lower", aspect="auto", vmin=low, vmax=high, interpolation="nearest")
            axes.set(facecolor="white")
            axes.grid(visible=False)
        drawing.colorbar(row[0].images[0], ax=list(row), label=_axis(title, unit))
    for axes, charge in zip(fields[0], charges, strict=True):
        axes.set_title(charge)
    for axes in fields[-1]:
        axes.set_xlabel(keys[across])
        _some(axes.xaxis, x_labels)
        _slant(axes, x_labels)
    for axes in fields[:, 0]:
        axes.set_ylabel(keys[up])
        _some(axes.yaxis, y_labels)
    return drawing


def _parallel(keys: Mapping[str, str], outcomes: Sequence[Outcome], columns: Columns) -> Figure:
    """Draw parallel coordinates for each mode: an axis for each key and quantity, a line for each run."""
    from matplotlib.collections import LineCollection

    charges = list(dict.fromkeys(one.charge for one in outcomes))
    drawing = style.figure(0.4 + 2.6 * len(charges))
    for axes, charge in zip(drawing.subplots(len(charges), 1, squeeze=False)[:, 0], charges, strict=True):
        own = [one for one in outcomes if one.charge == charge]
        scales = [_scale(keys[key], *_places(columns[key])) for key in keys]
        scales += [_scale(_axis(one.title, one.unit), _numbers(one, columns), []) for one in own]
        heights = np.array([scale[1] for scale in scales])
        whole = np.isfinite(heights).all(axis=0)
        lines = np.stack([np.broadcast_to(np.arange(len(scales))[:, None], heights.shape), heights], axis=-1)
        shown = LineCollection(list(lines.transpose(1, 0, 2)[whole]), linewidths=0.6, alpha=0.6, rasterized=True)
        shown.set_array(heights[len(keys)][whole])
        axes.add_collection(shown)
        axes.set(xlim=(-0.2, len(scales) - 0.8), ylim=(-0.15, 1.15), title=charge, yticks=[])
        axes.set_xticks(range(len(scales)), [scale[0] for scale in scales], fontsize="small")
        for place, (_, _, low, high) in enumerate(scales):
            axes.axvline(place, color=style.GREY, linewidth=0.8)
            axes.text(place, -0.04, low, ha="center", va="top", fontsize="small")
            axes.text(place, 1.04, high, ha="center", va="bottom", fontsize="small")
    return drawing


def _scale(name: str, values: NDArray[np.float64], labels: Sequence[str]) -> tuple[str, NDArray[np.float64], str, str]:
    """Return the title of an axis, the heights of values on it from 0 to 1, and what stands at its ends."""
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    heights = (values - low) / (high - low) if high > low else np.where(np.isfinite(values), 0.5, np.nan)
    ends = (labels[0], labels[-1]) if labels else (f"{low:.4g}", f"{high:.4g}")
    title = name.replace(".", ".\n").replace(" ", "\n") if len(name) > 14 else name
    return title, heights, *ends


def _numbers(one: Outcome, columns: Columns) -> NDArray[np.float64]:
    return one.factor * np.array([np.nan if value is None else value for value in columns[one.column]], dtype=float)


def _places(values: Sequence[Any]) -> tuple[NDArray[np.float64], list[str]]:
    """Return where values stand on an axis: numbers as they are, words in their order, which are returned too."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return np.array(values, dtype=float), []
    ranks, labels = _ranks(values)
    return ranks.astype(float), labels


def _ranks(values: Sequence[Any]) -> tuple[NDArray[np.int64], list[str]]:
    """Return the rank of each value, and the values in their order: numbers rise, words as they come."""
    known = list(dict.fromkeys(values))
    if all(isinstance(value, int | float) for value in known):
        known.sort()
    rank = {value: place for place, value in enumerate(known)}
    return np.array([rank[value] for value in values]), [_text(value) for value in known]


def _text(value: Any) -> str:
    text = f"{value:g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 24 else f"{text[:11]}…{text[-11:]}"


def _ticks(axes: Axes, labels: Sequence[str]) -> None:
    if labels:
        _some(axes.xaxis, labels)
        _slant(axes, labels)


def _slant(axes: Axes, labels: Sequence[str]) -> None:
    """Turn names at an axis that would run into each other."""
    if max(map(len, labels), default=0) > 6:
        axes.tick_params(axis="x", rotation=30)


def _some(axis: Any, labels: Sequence[str]) -> None:
    """Name some places of an axis, not too many."""
    step = -(-len(labels) // _MOST_TICKS)
    axis.set_ticks(range(0, len(labels), step), labels[::step])


def _axis(name: str, unit: str) -> str:
    return style.label(name[:1].upper() + name[1:], unit)
