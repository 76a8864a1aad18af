"""From a day's weather to the power at the battery's terminals."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.bus.flows import Available, available
from pipeline.bus.load import Drawn, held
from pipeline.converter.records import PowerChain
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2
from pipeline.weather.sky import Sky

Array = NDArray[np.float64]
Power = Callable[[Array, Array], Array]
"""Irradiance [W/m2] and cell temperature [degC] -> maximum power of all panels [W], shape (n,) each."""


class Sunlight(NamedTuple):
    """A day with everything that does not depend on the battery, constant from each time to the next, shape (n,) each.

    `reference_w` is what the panel would give at its efficiency of standard conditions.
    """

    time_s: Array
    irradiance_w_m2: Array
    ambient_c: Array
    cell_temperature_c: Array
    reference_w: Array
    could: Available
    end_s: float


def sunlight(sky: Sky, load: Drawn, panel_power: Power, standard_w: float, chain: PowerChain, end_s: float) -> Sunlight:
    """Follow a day's light to the battery's terminals.

    Arguments
    ---------
    sky, load : the weather, and what the load draws from the clock of the weather's first row on.
    panel_power : the panel's maximum power.
    standard_w : its value at standard test conditions [W].
    chain : tracker and converters.
    end_s : end of the day [s].
    """
    time_s = np.unique(np.concatenate([sky.time_s, load.clock_s - load.clock_s[0]]))
    time_s = time_s[time_s < end_s]
    irradiance, ambient, cells = (
        held(sky.time_s, column, time_s) for column in (sky.irradiance_w_m2, sky.ambient_c, sky.cell_temperature_c)
    )
    panel_w = panel_power(irradiance, cells)
    could = available(
        panel_w, panel_w * chain.tracker_efficiency, held(load.clock_s - load.clock_s[0], load.power_w, time_s), chain
    )
    reference_w = standard_w * irradiance / REFERENCE_IRRADIANCE_W_M2
    return Sunlight(time_s, irradiance, ambient, cells, reference_w, could, end_s)
