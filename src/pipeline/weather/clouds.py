"""Clouds before the sun, drawn from a stream of their own: the same day every time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.weather.records import Clouds


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
