"""Temperature of a panel's cells from irradiance, air and wind, by pvlib."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.weather.records import Cells, FaimanCells, SapmCells


def cell_temperature_c(
    model: Cells, irradiance_w_m2: ArrayLike, ambient_c: ArrayLike, wind_m_s: ArrayLike
) -> NDArray[np.float64]:
    """Return the cells' temperature in steady state [degC], shape (n,).

    Arguments
    ---------
    model : one of pvlib's models with its numbers.
    irradiance_w_m2, ambient_c, wind_m_s : conditions, broadcast against each other, shape (n,).
    """
    from pvlib import temperature

    irradiance, ambient, wind = np.broadcast_arrays(
        *(np.asarray(part, dtype=float) for part in (irradiance_w_m2, ambient_c, wind_m_s))
    )
    if isinstance(model, SapmCells):
        found = temperature.sapm_cell(irradiance, ambient, wind, model.a, model.b_s_m, model.cell_above_back_k)
    elif isinstance(model, FaimanCells):
        found = temperature.faiman(irradiance, ambient, wind, model.u0_w_m2_k, model.u1_w_s_m3_k)
    else:
        found = temperature.ross(irradiance, ambient, noct=model.noct_c)
    return np.asarray(found, dtype=np.float64)
