"""The charging rate over temperature and its gradient: the data, the network's answer, and where it errs (Figure 2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.network.records import USED, gradient_unit
from pipeline.report import style
from pipeline.report.records import FigureCard, NoOptions

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pipeline.report.tables import ReportData


READS = ("network",)
Options = NoOptions
Array = NDArray[np.float64]
_CENTRE: dict[str, Any] = {
    "marker": "o", "color": "white", "markeredgecolor": "#222222", "markersize": 7, "linestyle": "",
    "clip_on": False, "zorder": 5,
}  # fmt: skip
_VIEW = {"elev": 28.0, "azim": -55.0}


def draw(figure: FigureCard, data: ReportData) -> Figure:
    """Draw the data as a surface, the network's answer with its centres, and the difference.

    Arguments
    ---------
    figure : the card.
    data : the network's response at the points of the data, and its centres.
    """
    table, networks = data.table("network", "response"), data.table("network", "networks")
    own = networks["network"] == USED
    drawing = style.figure(4.4)
    shown = _gridded(table)
    if shown is None:
        axes = drawing.subplots()
        style.nothing(axes, "the data lie on no grid, and a surface needs one")
        return drawing
    temperature, gradient, rates = shown
    unit = gradient_unit(float(networks["gradient_seconds"][0]))
    grid = drawing.add_gridspec(1, 3, width_ratios=(1.25, 1.0, 1.0))
    solid: Any = drawing.add_subplot(grid[0], projection="3d")
    x, y = np.meshgrid(temperature, gradient, indexing="ij")
    solid.plot_surface(
        x, y, rates["rate_c"], cmap="cividis", rstride=1, cstride=1, linewidth=0.2, edgecolor="#ffffff55"
    )
    solid.view_init(**_VIEW)
    solid.set(xlabel="T [°C]", zlabel="rate [C]", title="Data")
    solid.set_ylabel(f"dT/dt [{unit}]", labelpad=9)
    solid.tick_params(labelsize=7.5, pad=0)
    solid.zaxis.labelpad = -3
    solid.set_box_aspect(None, zoom=0.8)
    flat = [drawing.add_subplot(grid[place]) for place in (1, 2)]
    miss = rates["network_c"] - rates["rate_c"]
    most = max(float(np.max(np.abs(miss))), 1e-12)
    fields: tuple[tuple[Array, str, dict[str, Any]], ...] = (
        (rates["network_c"], "Network: rate [C]", {"cmap": "cividis", "vmin": 0.0}),
        (miss, "Network less data [C]", {"cmap": "RdBu_r", "vmin": -most, "vmax": most}),
    )
    for axes, (values, title, options) in zip(flat, fields, strict=True):
        mesh = axes.pcolormesh(temperature, gradient, values.T, shading="nearest", rasterized=True, **options)
        drawing.colorbar(mesh, ax=axes, location="bottom", pad=0.03)
        axes.plot(networks["temperature_c"][own], networks["gradient"][own], **_CENTRE)
        axes.set(xlabel="Temperature [°C]", ylabel=f"dT/dt [{unit}]", title=title)
        axes.grid(False)
    return drawing


def _gridded(table: dict[str, NDArray[Any]]) -> tuple[Array, Array, dict[str, Array]] | None:
    """Return the axes and the columns over them, shape (temperatures, gradients); none where points are missing."""
    temperature, gradient = np.unique(table["temperature_c"]), np.unique(table["gradient"])
    shape = (len(temperature), len(gradient))
    if shape[0] * shape[1] != len(table["rate_c"]) or min(shape) < 2:
        return None
    order = np.lexsort((table["gradient"], table["temperature_c"]))
    return temperature, gradient, {name: table[name][order].reshape(shape) for name in ("rate_c", "network_c")}
