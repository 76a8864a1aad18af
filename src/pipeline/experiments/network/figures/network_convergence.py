"""How the genetic algorithm converges: best string and mean of the population over the generations (Figure 6)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pipeline.record import Record
from pipeline.report import style
from pipeline.report.records import FigureCard

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("network",)


class Options(Record):
    """The convergence, beside what the paper's plot says at the end of its generations."""

    published_best: float | None = Field(default=None, gt=0, description="best error in the paper")
    published_mean: float | None = Field(default=None, gt=0, description="mean error in the paper")


Array = NDArray[np.float64]


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the best replicate's course, all replicates as a band, and the end of the generations that are used.

    Arguments
    ---------
    figure : the card.
    data : the course of the genetic algorithm.
    """
    options = figure.chosen()
    assert isinstance(options, Options)
    table, found = data.table("network", "course"), data.numbers("network")
    replicates = len(np.unique(table["replicate"]))
    generation = table["generation"].reshape(replicates, -1)[0].astype(float)
    best, mean = (table[name].reshape(replicates, -1).astype(float) for name in ("best_mse", "mean_mse"))
    used = int(found["generations"])
    chosen = int(np.argmin(best[:, used]))
    drawing = style.figure(4.2)
    axes = drawing.subplots()
    _band(axes, generation, best, f"best of {replicates} runs, middle 90 %")
    axes.plot(generation, np.median(best, axis=0), color=style.GREY, linewidth=1.2, label="their median")
    axes.plot(generation, mean[chosen], color=style.MARKS[1].colour, linewidth=0.6, alpha=0.8, label="best run: mean")
    axes.step(
        generation, best[chosen], where="post", color=style.MARKS[0].colour, linewidth=1.8, label="best run: best"
    )
    axes.axvline(used, color="#222222", linewidth=0.8, linestyle=":")
    for value, words in ((options.published_best, "best"), (options.published_mean, "mean")):
        if value is not None:
            axes.plot(used, value, **style.PUBLISHED_POINT)
            axes.annotate(
                f"published {words}: {value:.2g}", (used, value), xytext=(9, -2 if words == "best" else 46),
                textcoords="offset points", color=style.PUBLISHED, fontsize=9, bbox=style.BEHIND_WORDS, zorder=6,
            )  # fmt: skip
    title = f"Generation {used}: best {best[chosen, used]:.4g}, mean {mean[chosen, used]:.4g}"
    axes.set(xlabel="Generation", ylabel="Mean square error [(C-rate)²]", yscale="log", title=title)
    axes.set_xlim(0.0, generation[-1])
    axes.set_ymargin(0.1)
    style.above(drawing, *axes.get_legend_handles_labels())
    return drawing


def _band(axes: Axes, generation: Array, values: Array, label: str) -> None:
    low, high = np.quantile(values, [0.05, 0.95], axis=0)
    axes.fill_between(generation, low, high, color=style.GREY, alpha=0.22, linewidth=0, label=label)
