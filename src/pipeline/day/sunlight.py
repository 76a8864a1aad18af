"""From a day's weather to the power at the battery's terminals."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.bus.flows import Available, available
from pipeline.bus.load import Drawn, held
from pipeline.converter.records import PowerChain
from pipeline.panel.maximum_power import maximum_power
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2, REFERENCE_TEMPERATURE_C, Panel
from pipeline.panel.single_diode import SingleDiode
from pipeline.tracker.loop import Source, capture
from pipeline.tracker.records import AnyTracker
from pipeline.weather.clear_sky import Sky

Array = NDArray[np.float64]


class Sunlight(NamedTuple):
    """A day with everything that does not depend on the battery, constant over each interval, shape (n,) each.

    `reference_w` is what the panels would give at their efficiency of standard conditions, `panel_voltage_v` their
    voltage at maximum power.
    """

    time_s: Array
    interval_s: Array
    irradiance_w_m2: Array
    ambient_c: Array
    cell_temperature_c: Array
    reference_w: Array
    panel_voltage_v: Array
    could: Available


Tracking = Callable[[Array, Array, Array, Array], Array]
"""Times, the end among them, irradiance, cell temperature, maximum power -> power drawn, a row less than times."""


def sunlight(
    sky: Sky, load: Drawn, panel: Panel, diode: SingleDiode, tracking: Tracking, chain: PowerChain
) -> Sunlight:
    """Follow a day's light to the battery's terminals.

    Arguments
    ---------
    sky : the weather, which ends.
    load : what the load draws from the clock of the weather's first row on.
    panel, diode : the panels' data sheet, and the parameters of one of them.
    tracking : how much of the maximum power is drawn.
    chain : the converters.
    """
    changes = load.clock_s - load.clock_s[0]
    time_s = np.unique(np.concatenate([sky.time_s, changes]))
    time_s = time_s[time_s < sky.end_s]
    edges = np.append(time_s, sky.end_s)
    irradiance, ambient, cells = (
        held(sky.time_s, column, time_s) for column in (sky.irradiance_w_m2, sky.ambient_c, sky.cell_temperature_c)
    )
    panel_w, panel_v = _maximum(panel, diode, irradiance, cells)
    tracked_w = np.minimum(panel_w, tracking(edges, irradiance, cells, panel_w))
    standard_w = _maximum(panel, diode, np.array([REFERENCE_IRRADIANCE_W_M2]), np.array([REFERENCE_TEMPERATURE_C]))[0][
        0
    ]
    return Sunlight(
        time_s,
        np.diff(edges),
        irradiance,
        ambient,
        cells,
        standard_w * irradiance / REFERENCE_IRRADIANCE_W_M2,
        panel_v,
        available(panel_w, tracked_w, held(changes, load.power_w, time_s), chain, panel_v),
    )


def by_share(share: float) -> Tracking:
    """Return tracking by a share of the maximum power that is always the same."""
    return lambda edges, irradiance, cells, panel_w: share * panel_w


def in_closed_loop(source: Source, tracker: AnyTracker) -> Tracking:
    """Return tracking by a tracker that really runs, period by period."""

    def drawn_w(edges: Array, irradiance: Array, cells: Array, panel_w: Array) -> Array:
        # The end closes the last interval, which would otherwise have no length.
        again = (np.append(column, column[-1]) for column in (irradiance, cells))
        return capture(source, tracker, edges, *again)[:-1]

    return drawn_w


def _maximum(panel: Panel, diode: SingleDiode, irradiance: Array, cells: Array) -> tuple[Array, Array]:
    """Return maximum power [W] and the voltage at it [V] of all panels, shape (n,) each."""
    found = maximum_power(panel, diode, irradiance, cells)
    count = panel.panels_in_series * panel.panels_in_parallel
    return count * found.max_power_w, panel.panels_in_series * found.max_power_voltage_v
