"""The panel against pvlib: maximum power of fifty modules, and the energy of a day by its ModelChain."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.bus.load import Drawn
from pipeline.converter.records import Converter, PowerChain
from pipeline.day.sunlight import by_share, sunlight
from pipeline.experiments.validation.records import Curve, Found, at_least, at_most, largest
from pipeline.panel.database import PanelEntry, look_up, names
from pipeline.panel.maximum_power import maximum_power
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode, fit
from pipeline.weather.clear_sky import sky_of
from pipeline.weather.records import Air, ClearSky, FaimanCells, Place, Surface

MODULE = "Kyocera_Solar_KC130GT"
MINUTES = 1440
# Not due south, so that a clock that is wrong shows in every hour of the day.
CARD = ClearSky(
    title="clear",
    place=Place(latitude_deg=23.0, longitude_deg=120.2, altitude_m=20.0, utc_offset_h=8.0),
    date="2015-04-01",
    surface=Surface(tilt_deg=23.0, azimuth_deg=150.0, albedo=0.25),
    linke_turbidity=4.0,
    air=Air(lowest_c=16.0, highest_c=30.0, warmest_h=14.0, wind_m_s=2.0),
    cell_temperature=FaimanCells(u0_w_m2_k=25.0, u1_w_s_m3_k=6.84),
    interval_s=60.0,
)
MISTAKES: dict[str, dict[str, object]] = {
    "the clock an hour late": {"place": {"utc_offset_h": 7.0}},
    "a month early": {"date": "2015-03-01"},
    "tilted by 10 degrees more": {"surface": {"tilt_deg": 33.0}},
    "facing south": {"surface": {"azimuth_deg": 180.0}},
    "black ground": {"surface": {"albedo": 0.0}},
    "a clearer sky": {"linke_turbidity": 3.8},
    "no wind on the cells": {"air": {"wind_m_s": 0.0}},
    "air warmest at night": {"air": {"warmest_h": 2.0}},
}
"""What is wrong -> what of the card differs, so that the check must show it."""
_CHAIN = PowerChain(
    title="lossless",
    bus_voltage_v=48.0,
    tracker_efficiency=1.0,
    boost=Converter(efficiency=1.0),
    buck=Converter(efficiency=1.0),
)


def with_mistake(changes: dict[str, object]) -> ClearSky:
    """Return the card with a mistake in it."""
    card = CARD.model_dump()
    for name, value in changes.items():
        card[name] = card[name] | value if isinstance(value, dict) else value
    return ClearSky.model_validate(card)


def ours_w(panel: Panel, diode: SingleDiode, card: ClearSky = CARD) -> Array:
    """Return the power at each minute of the day by our rooms: sky, cells, sunlight; dark where there is no light."""
    sky = sky_of(card, 0.0)
    load = Drawn(np.array([sky.clock_s]), np.zeros(1))
    light = sunlight(sky, load, panel, diode, by_share(1.0), _CHAIN)
    found = np.zeros(MINUTES)
    rows = np.round((light.time_s + sky.clock_s) / 60.0).astype(int)
    found[rows] = light.could.tracked_w
    return found


def theirs_w() -> Array:
    """Return the same by pvlib's ModelChain from its own clear sky; its air is written down here."""
    import pandas as pd
    from pvlib.location import Location
    from pvlib.modelchain import ModelChain
    from pvlib.pvsystem import PVSystem, retrieve_sam

    location = Location(23.0, 120.2, tz="Asia/Taipei", altitude=20.0)
    times = pd.date_range("2015-04-01 00:00:30", periods=MINUTES, freq="1min", tz="Asia/Taipei")
    system = PVSystem(
        surface_tilt=23.0,
        surface_azimuth=150.0,
        albedo=0.25,
        module_parameters=retrieve_sam("CECMod")[MODULE].to_dict(),
        inverter_parameters={"pdc0": 1e6},
        temperature_model_parameters={"u0": 25.0, "u1": 6.84},
    )
    chain = ModelChain(
        system,
        location,
        transposition_model="haydavies",
        dc_model="cec",
        ac_model="pvwatts",
        aoi_model="no_loss",
        spectral_model="no_loss",
        temperature_model="faiman",
        losses_model="no_loss",
    )
    hours = np.arange(MINUTES) / 60.0 + 0.5 / 60.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of pandas and scipy inside pvlib
        weather = location.get_clearsky(times, linke_turbidity=4.0)
        weather["temp_air"] = 23.0 + 7.0 * np.cos(2.0 * np.pi * (hours - 14.0) / 24.0)
        chain.run_model(weather.assign(wind_speed=2.0))
    return np.asarray(chain.results.dc["p_mp"].fillna(0.0), dtype=np.float64)


def difference(ours: Array, theirs: Array) -> tuple[float, float]:
    """Return by how much the day's energy differs, over theirs, and the power of a minute, over the most of theirs."""
    energy = abs(float(ours.sum() / theirs.sum()) - 1.0)
    return energy, float(np.max(np.abs(ours - theirs)) / theirs.max())


Array = NDArray[np.float64]

MODULES, CONDITIONS, SEED = 50, 20, 20150401
POWER_BOUND, ENERGY_BOUND = 1e-6, 5e-3


def check(settings: Mapping[str, Any]) -> Found:
    """Return both checks, mistakes that the day must show, and the differences over irradiance and over the day."""
    irradiance, power = maximum_power_differences()
    panel, diode = _known(MODULE)
    ours, theirs = ours_w(panel, diode), theirs_w()
    energy, minute = difference(ours, theirs)
    hours, over_most = np.arange(MINUTES) / 60.0, (ours - theirs) / float(theirs.max())
    up = "difference [1]"
    rows = [
        at_most(f"maximum power, {MODULES} modules in {CONDITIONS} conditions each", largest(power), POWER_BOUND),
        at_most("energy of a clear day, against pvlib's ModelChain", energy, ENERGY_BOUND),
        at_most("power of every minute of it, over its most", minute, ENERGY_BOUND),
    ]
    for mistake, changes in MISTAKES.items():
        wrong = ours_w(panel, diode, with_mistake(changes))
        rows.append(at_least(f"mistake: {mistake}", max(difference(wrong, theirs)), ENERGY_BOUND))
    return Found(
        rows,
        [
            Curve("maximum power over pvlib's", f"{MODULES} modules", "irradiance [W/m²]", up, irradiance, power),
            Curve("power on a clear day over its most", "ModelChain", "time [h]", up, hours, over_most),
        ],
    )


def maximum_power_differences() -> tuple[Array, Array]:
    """Return irradiance, rising, and relative difference of maximum power from pvlib's, shape (1000,) each.

    The modules are drawn by a fixed seed; pvlib reads the database itself and has its own laws of irradiance.
    """
    from pvlib.pvsystem import calcparams_cec, max_power_point, retrieve_sam

    rng = np.random.default_rng(SEED)
    drawn = rng.choice(names("cec"), MODULES, replace=False)
    irradiance = rng.uniform(20.0, 1200.0, (MODULES, CONDITIONS))
    temperature = rng.uniform(-20.0, 80.0, (MODULES, CONDITIONS))
    modules = retrieve_sam("CECMod")
    found = np.empty((MODULES, CONDITIONS))
    for row, (name, light, cells) in enumerate(zip(drawn, irradiance, temperature, strict=True)):
        panel, diode = _known(str(name))
        their = modules[str(name)]
        circuit = calcparams_cec(
            *(light, cells, their.alpha_sc, their.a_ref, their.I_L_ref, their.I_o_ref),
            *(their.R_sh_ref, their.R_s, their.Adjust),
        )
        theirs = np.asarray(max_power_point(*circuit, method="brentq")["p_mp"])
        found[row] = maximum_power(panel, diode, light, cells).max_power_w / theirs - 1.0
    order = np.argsort(irradiance, axis=None)
    return irradiance.ravel()[order], found.ravel()[order]


def _known(name: str) -> tuple[Panel, SingleDiode]:
    panel = Panel.model_validate(look_up(PanelEntry(database="cec", name=name)))
    return panel, fit(panel)
