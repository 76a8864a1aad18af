"""The panel against pvlib: maximum power of fifty modules, and the energy of a day by its ModelChain."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.panel.database import PanelEntry, look_up, names
from pipeline.panel.maximum_power import maximum_power
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode, fit

Array = NDArray[np.float64]
Row = tuple[str, float, float]

MODULES, CONDITIONS, SEED = 50, 20, 20150401
POWER_BOUND, ENERGY_BOUND = 1e-6, 5e-3
_PLACE = {"latitude": 23.0, "longitude": 120.2, "tz": "Asia/Taipei", "altitude": 20.0}
_FAIMAN = {"u0": 25.0, "u1": 6.84}
_TURBIDITY, _AIR_C, _WIND_M_S, _TILT_DEG = 4.0, 25.0, 2.0, 23.0


def rows() -> list[Row]:
    """Return quantity, value and the bound it may not exceed, of both checks."""
    return [*maximum_power_rows(), *energy_rows()]


def maximum_power_rows() -> list[Row]:
    """Return the largest relative difference of maximum power from pvlib's, over modules drawn by a fixed seed.

    pvlib reads its own database, its own parameters and its own laws of irradiance and temperature.
    """
    from pvlib.pvsystem import calcparams_cec, max_power_point, retrieve_sam

    rng = np.random.default_rng(SEED)
    drawn = rng.choice(names("cec"), MODULES, replace=False)
    irradiance = rng.uniform(20.0, 1200.0, (MODULES, CONDITIONS))
    temperature = rng.uniform(-20.0, 80.0, (MODULES, CONDITIONS))
    modules = retrieve_sam("CECMod")
    largest = 0.0
    for name, light, cells in zip(drawn, irradiance, temperature, strict=True):
        panel, diode = _known(str(name))
        ours = maximum_power(panel, diode, light, cells).max_power_w
        their = modules[str(name)]
        circuit = calcparams_cec(
            *(light, cells, their.alpha_sc, their.a_ref, their.I_L_ref, their.I_o_ref),
            *(their.R_sh_ref, their.R_s, their.Adjust),
        )
        theirs = np.asarray(max_power_point(*circuit, method="brentq")["p_mp"])
        largest = max(largest, float(np.max(np.abs(ours / theirs - 1.0))))
    title = f"maximum power of {MODULES} modules in {CONDITIONS} conditions each, largest relative difference to pvlib"
    return [(title, largest, POWER_BOUND)]


def energy_rows(name: str = "Kyocera_Solar_KC130GT") -> list[Row]:
    """Return the relative difference of a clear day's energy from that of pvlib's ModelChain.

    Both are given the irradiance in the panel's plane, the air and the wind; cells warm by Faiman's law, of which ours
    is written down here.
    """
    from pvlib.modelchain import ModelChain
    from pvlib.pvsystem import PVSystem, retrieve_sam

    weather, location = _clear_day()
    poa = weather["poa_global"].to_numpy()
    cells = _AIR_C + poa / (_FAIMAN["u0"] + _FAIMAN["u1"] * _WIND_M_S)
    panel, diode = _known(name)
    ours = float(maximum_power(panel, diode, poa, cells).max_power_w.sum())
    system = PVSystem(
        surface_tilt=_TILT_DEG,
        surface_azimuth=180.0,
        module_parameters=retrieve_sam("CECMod")[name].to_dict(),
        inverter_parameters={"pdc0": 1e6},
        temperature_model_parameters=_FAIMAN,
    )
    chain = ModelChain(
        system,
        location,
        dc_model="cec",
        ac_model="pvwatts",
        aoi_model="no_loss",
        spectral_model="no_loss",
        temperature_model="faiman",
        losses_model="no_loss",
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of pandas and scipy inside pvlib
        chain.run_model_from_poa(weather)
    theirs = float(chain.results.dc["p_mp"].fillna(0.0).sum())
    return [
        ("energy of a clear day, relative difference to pvlib's ModelChain", abs(ours / theirs - 1.0), ENERGY_BOUND)
    ]


def _clear_day() -> tuple[Any, Any]:
    """Return a clear day minute by minute in the plane of the panel, and the place, both as pvlib has them."""
    import pandas as pd
    from pvlib.irradiance import get_total_irradiance
    from pvlib.location import Location

    location = Location(**_PLACE)
    times = pd.date_range("2015-04-01", periods=1440, freq="1min", tz=str(_PLACE["tz"]))
    sun = location.get_solarposition(times)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # those of pandas and scipy inside pvlib
        sky = location.get_clearsky(times, solar_position=sun, linke_turbidity=_TURBIDITY)
    total = get_total_irradiance(
        _TILT_DEG, 180.0, sun["apparent_zenith"], sun["azimuth"], sky["dni"], sky["ghi"], sky["dhi"]
    )
    columns = ("poa_global", "poa_direct", "poa_diffuse")
    weather = total[list(columns)].fillna(0.0).clip(lower=0.0)
    return weather.assign(temp_air=_AIR_C, wind_speed=_WIND_M_S), location


def _known(name: str) -> tuple[Panel, SingleDiode]:
    panel = Panel.model_validate(look_up(PanelEntry(database="cec", name=name)))
    return panel, fit(panel)
