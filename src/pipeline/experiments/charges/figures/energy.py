"""Where the heat of each charge came from, mode by mode."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("charge",)
Options = NoOptions


_JOULE_PER_WH = 3600.0
_SMALLEST_NAMED_SHARE = 0.005
_SMALLEST_WRITTEN_SHARE = 0.07
_OTHERS = "all others"
_BELOW = 0.38
"""How far below the middle of a bar its sum is marked."""


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the losses of each mode as stacked bars, by path, with their sum; beside them what differs from the first.

    Arguments
    ---------
    figure : the card.
    data : the charges' energy tables.

    Returns
    -------
    The figure, a row for each comparison.
    """
    comparisons = data.shown(figure.comparison)
    losses = {(c, m): _losses(data, c, m) for c in comparisons for m in data.charged(c)}
    bars = max([len(data.charged(c)) for c in comparisons], default=1)
    drawing = style.figure(1.4 + max(1, len(comparisons)) * (0.55 + 0.42 * bars))
    fields = drawing.subplots(
        max(1, len(comparisons)), 2, sharex="col", sharey="row", squeeze=False, width_ratios=(2, 1)
    )
    if not losses:
        style.nothing(fields[0, 0], "no charge in this run")
        style.nothing(fields[0, 1], "no charge in this run")
    named = _named(list(losses.values()))
    parts = style.parts(named) | {_OTHERS: style.REST}
    split = {key: _parted(found, named) for key, found in losses.items()}
    widest = max((sum(map(abs, found.values())) for found in split.values()), default=0.0)
    for (whole, less), comparison in zip(fields, comparisons, strict=False):
        whole.set_title(data.comparisons[comparison])
        modes = data.charged(comparison)
        first = split[comparison, modes[0]]
        for place, mode in enumerate(modes):
            found = split[comparison, mode]
            _bar(whole, place, found, parts, widest)
            _total(whole, place, found)
            _difference(less, place, {path: value - first[path] for path, value in found.items()}, parts)
        less.text(0.0, 0, " reference", va="center", fontsize=9, color=style.GREY)
        whole.set_yticks(range(len(modes)), [data.modes[mode].title for mode in modes])
        whole.set_ylim(len(modes) - 0.5, -0.5)
        for axes in (whole, less):
            axes.grid(False, axis="y")
            axes.axvline(0.0, color=style.GREY, linewidth=0.9)
        whole.margins(x=0.13)
        less.margins(x=0.25)
    fields[-1, 0].set_xlabel("Energy turned into heat over the charge [Wh]")
    fields[-1, 1].set_xlabel(f"Difference from\n{_first_title(data, comparisons)} [Wh]")
    _legend(drawing, fields[:, 0], parts)
    return drawing


def _first_title(data: ReportData, comparisons: list[str]) -> str:
    titles = dict.fromkeys(data.modes[data.charged(name)[0]].title for name in comparisons)
    return next(iter(titles)) if len(titles) == 1 else "the first"


def _legend(drawing: Figure, fields: Iterable[Axes], parts: Mapping[str, style.Part]) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    drawn = {str(bar.get_label()) for axes in fields for bar in axes.containers}
    handles: list[Any] = [Patch(**style.filled(part), label=path) for path, part in parts.items() if path in drawn]
    if any(line.get_marker() == "^" for axes in fields for line in axes.lines):
        handles.append(Line2D([], [], **_NET, label="sum"))
    if handles:
        style.above(drawing, handles, handlelength=2.0)


_NET: dict[str, Any] = {"marker": "^", "color": "#000000", "markeredgecolor": "white", "linestyle": "", "markersize": 7}


def _losses(data: ReportData, comparison: str, mode: str) -> dict[str, float]:
    energy = data.charge(comparison, mode, "energy")
    rows = energy["role"] == "loss"
    return {
        _words(str(path)): float(joule) / _JOULE_PER_WH
        for path, joule in zip(energy["path"][rows], energy["energy_j"][rows], strict=True)
    }


def _words(path: str) -> str:
    """Return what a path is called: a pair bears a name of the configuration."""
    return (
        f"RC pair \N{LEFT DOUBLE QUOTATION MARK}{path[5:]}\N{RIGHT DOUBLE QUOTATION MARK}"
        if path[:5] == "pair "
        else path
    )


def _named(all_losses: list[dict[str, float]]) -> list[str]:
    """Return the paths worth a colour of their own, in the order of the tables."""
    paths = list(dict.fromkeys(path for losses in all_losses for path in losses))
    largest = max((sum(map(abs, losses.values())) for losses in all_losses), default=0.0)
    return [p for p in paths if max(abs(losses.get(p, 0.0)) for losses in all_losses) > _SMALLEST_NAMED_SHARE * largest]


def _parted(losses: Mapping[str, float], named: list[str]) -> dict[str, float]:
    """Return the losses by named path, what is left over in one."""
    parts = {path: losses.get(path, 0.0) for path in named}
    return parts | {_OTHERS: sum(value for path, value in losses.items() if path not in parts)}


def _bar(
    axes: Axes, place: int, found: Mapping[str, float], parts: Mapping[str, style.Part], widest: float = 0.0
) -> None:
    """Stack the parts of a bar, what is gained back to the left of zero; with its widest, write what has room."""
    ends = {True: 0.0, False: 0.0}
    for path, value in found.items():
        start = ends[value >= 0]
        ends[value >= 0] += value
        if value:
            axes.barh(place, value, left=start, height=0.62, label=path, **style.filled(parts[path]))
        if widest and abs(value) > _SMALLEST_WRITTEN_SHARE * widest:
            style.written_on(axes, start + value / 2, f"{value:.2f}", parts[path], place)


def _total(axes: Axes, place: int, found: Mapping[str, float]) -> None:
    """Write the sum beside a bar; where a part is gained back, mark where on the axis the sum lies."""
    end, total = sum(max(0.0, value) for value in found.values()), sum(found.values())
    if end - total > 1e-9 * end:
        axes.plot(total, place + _BELOW, **_NET)
    axes.text(end, place, f"  {total:.2f} Wh", va="center")


def _difference(axes: Axes, place: int, found: Mapping[str, float], parts: Mapping[str, style.Part]) -> None:
    if not any(found.values()):
        return
    _bar(axes, place, found, parts)
    end, total = sum(max(0.0, value) for value in found.values()), sum(found.values())
    axes.plot(total, place + _BELOW, **_NET)
    axes.text(end, place, f"  {total:+.3f}", va="center", fontsize=9)
