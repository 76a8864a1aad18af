"""A day at a place, clear or with clouds, by pvlib; and the sky of any weather card."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import UserError
from pipeline.panel.records import ConstantWeather
from pipeline.weather.measured import Array, Measured, Sky, filled
from pipeline.weather.records import Air, ClearSky, Clouds, CloudySky, Weather
from pipeline.weather.transposition import cell_temperature_c

_DAY_S = 86400.0


def transmittance(clouds: Clouds, clock_s: ArrayLike) -> NDArray[np.float64]:
    """Return the share of the clear sky's global irradiance at times of a day; exactly 1 where no cloud is.

    The lengths of clouds and of the sun between them are exponential (a two-state Markov chain in continuous time),
    their means such that the sun has its share of the time. Over an edge the share changes evenly, and faster where the
    next one would begin before it has passed.

    Arguments
    ---------
    clouds : the record; its seed alone decides which day it is.
    clock_s : times, rising from 0 [s], shape (n,).
    """
    times = np.asarray(clock_s, dtype=float)
    if clouds.sun_share == 1.0 or not times.size:
        return np.ones_like(times)
    random = np.random.default_rng(np.random.SeedSequence([clouds.seed]))
    mean_sun_s = clouds.mean_cloud_s * clouds.sun_share / (1.0 - clouds.sun_share)
    sunny = bool(random.random() < clouds.sun_share)
    starts, shares, at_s = [], [], 0.0
    while at_s <= times[-1]:
        starts.append(at_s)
        through = clouds.transmittance * (1.0 + clouds.spread * (2.0 * random.random() - 1.0))
        shares.append(1.0 if sunny else through)
        at_s += random.exponential(mean_sun_s if sunny else clouds.mean_cloud_s)
        sunny = not sunny and mean_sun_s > 0.0
    if clouds.edge_s == 0.0:
        return np.array(shares)[np.searchsorted(starts, times, side="right") - 1]
    passed = np.minimum(np.array(starts[1:]) + clouds.edge_s, [*starts[2:], np.inf])
    corners = np.append(0.0, np.column_stack([starts[1:], passed]).ravel())
    levels = np.append(shares[0], np.column_stack([shares[:-1], shares[1:]]).ravel())
    return np.asarray(np.interp(times, corners, levels), dtype=np.float64)


class Components(NamedTuple):
    """Irradiance on the horizontal, from the sun's direction, and diffuse [W/m2], shape (n,) each."""

    ghi: Array
    dni: Array
    dhi: Array


class Sun(NamedTuple):
    """Where the sun stands in each interval [deg], [1], [W/m2], shape (n,) each."""

    day_of_year: NDArray[np.int64]
    zenith: Array
    apparent_zenith: Array
    azimuth: Array
    airmass: Array
    extra: Array


def day(weather: ClearSky) -> Sky:
    """Return a day from its first light to its last, each interval with the values of its middle.

    Under a cloud the clear sky's global irradiance is cut to the cloud's share and split anew into beam and diffuse by
    Erbs et al. (1982), DOI 10.1016/0038-092X(82)90302-4; onto the panel by Hay and Davies (1980).

    Raises
    ------
    UserError : the sun does not rise.
    """
    start_s: Array = np.arange(round(_DAY_S / weather.interval_s), dtype=np.float64) * weather.interval_s
    sun = sun_at(weather, start_s + 0.5 * weather.interval_s)
    found = clear(weather, sun)
    if isinstance(weather, CloudySky):
        found = clouded(weather, sun, found, start_s + 0.5 * weather.interval_s)
    irradiance = on_panel(weather, sun, found)
    lit = np.flatnonzero(irradiance > 0.0)
    if not len(lit):
        raise UserError(
            f"date is {weather.date}, place.latitude_deg {weather.place.latitude_deg:g}: the sun does not rise on the "
            "panel; take another date or place"
        )
    rows = slice(lit[0], lit[-1] + 1)
    time_s, irradiance = start_s[rows], irradiance[rows]
    ambient = air_c(weather.air, time_s + 0.5 * weather.interval_s)
    cells = cell_temperature_c(weather.cell_temperature, irradiance, ambient, weather.air.wind_m_s)
    first = float(time_s[0])
    return Sky(time_s - first, irradiance, ambient, cells, first, float(time_s[-1]) - first + weather.interval_s)


def sun_at(weather: ClearSky, clock_s: Array) -> Sun:
    """Return where the sun stands at seconds since local midnight."""
    import pandas as pd
    from pvlib import atmosphere, irradiance, solarposition

    place = weather.place
    midnight = pd.Timestamp(weather.date, tz="UTC") - pd.Timedelta(hours=place.utc_offset_h)
    times = midnight + pd.to_timedelta(clock_s, unit="s")
    found = solarposition.get_solarposition(times, place.latitude_deg, place.longitude_deg, altitude=place.altitude_m)
    relative = atmosphere.get_relative_airmass(found["apparent_zenith"])
    airmass = atmosphere.get_absolute_airmass(relative, atmosphere.alt2pres(place.altitude_m))
    parts = (found["zenith"], found["apparent_zenith"], found["azimuth"], airmass)
    day_of_year = times.day_of_year.to_numpy()
    extra = irradiance.get_extra_radiation(day_of_year)
    return Sun(day_of_year, *(np.asarray(part, dtype=float) for part in (*parts, extra)))


def clear(weather: ClearSky, sun: Sun) -> Components:
    """Return the clear sky's irradiance."""
    from pvlib import clearsky

    # At night pvlib divides by a beam that is zero.
    with np.errstate(divide="ignore", invalid="ignore"):
        found = clearsky.ineichen(
            sun.apparent_zenith,
            sun.airmass,
            weather.linke_turbidity,
            altitude=weather.place.altitude_m,
            dni_extra=sun.extra,
        )
    return Components(*(np.nan_to_num(np.asarray(found[name], dtype=float)) for name in ("ghi", "dni", "dhi")))


def clouded(weather: CloudySky, sun: Sun, found: Components, clock_s: Array) -> Components:
    """Return the irradiance with clouds before the sun; between clouds it is the clear sky's."""
    from pvlib import irradiance

    share = transmittance(weather.clouds, clock_s)
    ghi = share * found.ghi
    split = irradiance.erbs(ghi, sun.zenith, sun.day_of_year)
    dni, dhi = (np.nan_to_num(np.asarray(split[name], dtype=float)) for name in ("dni", "dhi"))
    open_sky = share == 1.0
    return Components(ghi, np.where(open_sky, found.dni, dni), np.where(open_sky, found.dhi, dhi))


def on_panel(weather: ClearSky, sun: Sun, found: Components) -> Array:
    """Return the irradiance on the panel's plane [W/m2], shape (n,)."""
    from pvlib import irradiance

    total = irradiance.get_total_irradiance(
        weather.surface.tilt_deg,
        weather.surface.azimuth_deg,
        sun.apparent_zenith,
        sun.azimuth,
        found.dni,
        found.ghi,
        found.dhi,
        dni_extra=sun.extra,
        albedo=weather.surface.albedo,
        model="haydavies",
    )
    return np.asarray(np.maximum(0.0, np.nan_to_num(total["poa_global"])), dtype=np.float64)


def air_c(air: Air, clock_s: Array) -> Array:
    """Return the temperature of the air at seconds since midnight [degC], shape (n,)."""
    turn = 2.0 * np.pi * (clock_s - 3600.0 * air.warmest_h) / _DAY_S
    middle, half = 0.5 * (air.highest_c + air.lowest_c), 0.5 * (air.highest_c - air.lowest_c)
    return np.asarray(middle + half * np.cos(turn), dtype=np.float64)


__all__ = ["Array", "Measured", "Sky", "sky_of"]


def sky_of(weather: Weather, ambient_c: float, measured: Measured | None = None) -> Sky:
    """Return the weather as columns; a day begins with its first light and ends with its last.

    Arguments
    ---------
    weather : the record.
    ambient_c : temperature of the air where the weather does not say [degC].
    measured : what the weather's file holds, where it has one.

    Raises
    ------
    UserError : a place and date without any sun.
    """
    if isinstance(weather, ConstantWeather):
        irradiance, cells = np.array([weather.irradiance_w_m2]), np.array([weather.cell_temperature_c])
        return Sky(np.zeros(1), irradiance, np.array([ambient_c]), cells, 0.0, np.inf)
    if isinstance(weather, ClearSky):
        return day(weather)
    if measured is None:
        raise ValueError(f"weather {weather.title!r} needs the rows of its file, {weather.file}")
    return filled(weather, measured)
