"""A day of a published file against pvlib's ModelChain on the same file: the panel's energy at maximum power."""

import warnings
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from pvlib import iotools, modelchain, pvsystem
from pvlib.location import Location

from pipeline.files.weather import weather_rows
from pipeline.panel.database import PanelEntry, look_up
from pipeline.panel.maximum_power import maximum_power
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import fit
from pipeline.weather.measured import filled
from pipeline.weather.records import FaimanCells, MeasuredWeather

DATA = Path(find_spec("pvlib").submodule_search_locations[0]) / "data"
SURFACE = {"tilt_deg": 30.0, "azimuth_deg": 160.0, "albedo": 0.2}
CELLS = FaimanCells(u0_w_m2_k=25.0, u1_w_s_m3_k=6.84)
PANEL = "Kyocera_Solar_KC130GT"


@cache
def published(name):
    """Return a file as pvlib reads it, and how far the middle of an interval lies from its label."""
    path = DATA / name
    if name.endswith("tm2"):
        frame, meta = iotools.read_tmy2(str(path))
        frame = pd.DataFrame(
            {
                **{own: frame[theirs] for own, theirs in (("ghi", "GHI"), ("dni", "DNI"), ("dhi", "DHI"))},
                "temp_air": 0.1 * frame["DryBulb"],
                "wind_speed": 0.1 * frame["Wspd"],
            }
        )
        return frame, meta, pd.Timedelta(minutes=30)
    frame, meta = iotools.read_tmy3(path, map_variables=True)
    return frame, meta, -pd.Timedelta(minutes=30)


def energy_by_model_chain(name, month, day):
    frame, meta, shift = published(name)
    frame = frame[["ghi", "dni", "dhi", "temp_air", "wind_speed"]].copy()
    frame.index = frame.index + shift
    frame = frame[(frame.index.month == month) & (frame.index.day == day)]
    entry = look_up(PanelEntry(database="cec", name=PANEL))
    diode = entry["single_diode"]
    module = {
        "alpha_sc": entry["alpha_isc_a_per_k"],
        "a_ref": diode["modified_ideality_v"],
        "I_L_ref": diode["photocurrent_a"],
        "I_o_ref": diode["saturation_current_a"],
        "R_s": diode["series_resistance_ohm"],
        "R_sh_ref": diode["shunt_resistance_ohm"],
        "Adjust": diode["adjust_percent"],
    }
    array = pvsystem.Array(
        pvsystem.FixedMount(SURFACE["tilt_deg"], SURFACE["azimuth_deg"]),
        albedo=SURFACE["albedo"],
        module_parameters=module,
        temperature_model_parameters={"u0": CELLS.u0_w_m2_k, "u1": CELLS.u1_w_s_m3_k},
    )
    chain = modelchain.ModelChain(
        pvsystem.PVSystem([array], inverter_parameters={"pdc0": 1e3}),
        Location(meta["latitude"], meta["longitude"], altitude=meta["altitude"]),
        dc_model="cec",
        ac_model="pvwatts",
        aoi_model="no_loss",
        spectral_model="no_loss",
        temperature_model="faiman",
    )
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # of pandas and scipy inside pvlib, at night
        chain.run_model(frame)
    return float(chain.results.dc["p_mp"].fillna(0.0).sum())


def energy_by_ours(name, month, day, **more):
    card = MeasuredWeather(
        title="own",
        file=str(DATA / name),
        date=f"2015-{month:02d}-{day:02d}",
        surface=SURFACE,
        wind_m_s=1.0,
        cell_temperature=CELLS,
        **more,
    )
    sky = filled(card, weather_rows(card))
    panel = Panel.model_validate(look_up(PanelEntry(database="cec", name=PANEL)))
    power = maximum_power(panel, fit(panel), sky.irradiance_w_m2, sky.cell_temperature_c).max_power_w
    return float(np.sum(power * np.diff(sky.time_s, append=sky.end_s)) / 3600.0)


@pytest.mark.parametrize("name", ["703165TY.csv", "723170TYA.CSV", "12839.tm2"])
@pytest.mark.parametrize(("month", "day"), [(1, 15), (3, 20), (6, 21), (10, 2), (12, 31)])
def test_a_day_of_a_published_file_gives_the_energy_of_pvlibs_model_chain(name, month, day):
    expected = energy_by_model_chain(name, month, day)
    assert expected > 50.0
    assert energy_by_ours(name, month, day) == pytest.approx(expected, rel=1e-3)


def test_the_middle_of_the_hour_matters():
    """Half an hour's shift of the sun is what labels taken for something else would cost."""
    right = energy_by_ours("723170TYA.CSV", 10, 2)
    assert abs(energy_by_ours("723170TYA.CSV", 10, 2, label="start") / right - 1.0) > 0.005
