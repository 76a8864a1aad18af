"""Measured light on the horizontal brought onto a panel, by pvlib."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.weather.records import Cells, FaimanCells, SapmCells, Surface

Array = NDArray[np.float64]

_LOW_SUN_DEG = 88.0  # beyond which a beam found by division means nothing, as in pvlib.irradiance.dni
_NIGHT_DEG = 96.0


class Site(NamedTuple):
    """Where light was measured: [deg], positive north and east, [m]."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float = 0.0


class Parts(NamedTuple):
    """What was measured of the light [W/m2], shape (n,) each: global, beam, beam on the horizontal, diffuse."""

    ghi: Array | None = None
    dni: Array | None = None
    bhi: Array | None = None
    dhi: Array | None = None


class OnPanel(NamedTuple):
    """Light on the panel [W/m2], shape (n,); how it was found; the share of the light that came without a sun [1]."""

    irradiance_w_m2: Array
    how: str
    night_share: float


def on_panel(parts: Parts, universal_s: Array, site: Site, surface: Surface) -> OnPanel:
    """Return the light on a panel from what was measured on the horizontal.

    Where two of global, beam and diffuse are there the third follows from global = beam cos(zenith) + diffuse; global
    alone is split after Erbs et al. (1982), DOI 10.1016/0038-092X(82)90302-4. Onto the panel by Hay and Davies (1980),
    as pvlib's ModelChain does it unasked.

    Arguments
    ---------
    parts : what was measured; `enough` tells whether it is enough.
    universal_s : middles of the intervals, since 1970 in universal time [s], shape (n,).
    site, surface : where and how the panel stands.

    Raises
    ------
    ValueError : neither global light, nor beam and diffuse.
    """
    import pandas as pd
    from pvlib import irradiance, solarposition

    times = pd.DatetimeIndex(np.round(universal_s * 1e3).astype("datetime64[ms]")).tz_localize("UTC")
    sun = solarposition.get_solarposition(times, site.latitude_deg, site.longitude_deg, altitude=site.altitude_m)
    zenith = sun["zenith"].to_numpy(dtype=float)
    day_of_year = times.day_of_year.to_numpy()
    ghi, dni, dhi, how = _whole(parts, zenith, day_of_year)
    with np.errstate(divide="ignore", invalid="ignore"):
        total = irradiance.get_total_irradiance(
            surface.tilt_deg,
            surface.azimuth_deg,
            sun["apparent_zenith"].to_numpy(dtype=float),
            sun["azimuth"].to_numpy(dtype=float),
            dni,
            ghi,
            dhi,
            dni_extra=np.asarray(irradiance.get_extra_radiation(day_of_year), dtype=float),
            albedo=surface.albedo,
            model="haydavies",
        )
    found = np.asarray(np.maximum(0.0, np.nan_to_num(total["poa_global"])), dtype=np.float64)
    light = float(ghi.sum())
    night = float(ghi[zenith > _NIGHT_DEG].sum()) / light if light > 0.0 else 0.0
    return OnPanel(found, how, night)


def enough(names: set[str]) -> bool:
    """Tell whether light on the horizontal is known well enough: global, or beam and diffuse."""
    return "ghi" in names or ("dhi" in names and bool(names & {"dni", "bhi"}))


def _whole(parts: Parts, zenith: Array, day_of_year: NDArray[np.int64]) -> tuple[Array, Array, Array, str]:
    """Return global, beam and diffuse light, and how they were found."""
    from pvlib import irradiance

    ghi, dni, bhi, dhi = (None if part is None else np.maximum(0.0, part) for part in parts)
    cosine = np.cos(np.radians(zenith))
    low = zenith > _LOW_SUN_DEG
    if dni is None and bhi is not None and dhi is not None:
        dni = np.where(low, 0.0, bhi / np.where(low, 1.0, cosine))
        ghi = bhi + dhi if ghi is None else ghi
        return ghi, dni, dhi, "beam and diffuse light as measured"
    if dni is not None and dhi is not None:
        ghi = dhi + dni * np.maximum(0.0, cosine) if ghi is None else ghi
        return ghi, dni, dhi, "beam and diffuse light as measured"
    if ghi is None:
        raise ValueError("neither global light, nor beam and diffuse")
    if dhi is not None:
        dni = np.where(low, 0.0, np.maximum(0.0, ghi - dhi) / np.where(low, 1.0, cosine))
        return ghi, dni, dhi, "beam light from global and diffuse"
    if dni is not None:
        return ghi, dni, np.maximum(0.0, ghi - dni * np.maximum(0.0, cosine)), "diffuse light from global and beam"
    split = irradiance.erbs(ghi, zenith, day_of_year)
    dni, dhi = (np.nan_to_num(np.asarray(split[name], dtype=float)) for name in ("dni", "dhi"))
    return ghi, dni, dhi, "beam and diffuse light from global alone, after Erbs et al. (1982)"


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
