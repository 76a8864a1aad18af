"""The quantities that files hold: what they are called, their unit, what they may be."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError
from pipeline.files.units import IRRADIANCE, POWER, SPEED, TEMPERATURE


class Quantity(NamedTuple):
    """A quantity of a file.

    Arguments
    ---------
    name : as in `columns` and `units` of a record; `alias` : pvlib's name for it, which may stand there too.
    dimension, unit : of which kind it is, and the unit it is returned in.
    low, high : what it may be.
    words : what headings call it, as `pipeline.files.numbers.plain` gives them.
    assumed : whether a heading without a unit has the unit above.
    meaning : what it is, for a person who is asked for it.
    """

    name: str
    alias: str
    dimension: str
    unit: str
    low: float
    high: float
    words: frozenset[str]
    meaning: str
    assumed: bool = True


def _light(name: str, alias: str, meaning: str, *words: str) -> Quantity:
    # Pyranometers read some W/m2 below zero at night.
    return Quantity(name, alias, IRRADIANCE, "W/m2", -20.0, 2000.0, frozenset((name, alias, *words)), meaning)


ON_PANEL = _light(
    *("irradiance_w_m2", "poa_global", "global irradiance on the panel's plane"),
    *("poa", "poaglobal", "poairradiance", "poatotal", "gpoa", "planeofarray", "planeofarrayirradiance", "gi"),
    *("gti", "globaltiltedirradiance", "globalinclined", "globinc", "irradianceonthepanel", "tiltedirradiance"),
    *("poairradiancew", "intheplane", "planeofarraytotalirradiance", "einstrahlungmodulebene"),
)
GLOBAL = _light(
    *("ghi", "ghi", "global irradiance on the horizontal"),
    *("globalhorizontal", "globalhorizontalirradiance", "globalhorizontalradiation", "globalhoriz", "globhor", "gh"),
    *("shortwaveradiation", "globalradiation", "globalirradiance", "globalstrahlung", "allskysfcswdwn", "dwsolar"),
    *("globalhorizontalirradiation", "horizontalirradiance", "horizontalglobalirradiance", "globalhoriz.", "glo"),
    *("surfacesolarradiationdownwards", "ssrd", "globalps", "globalcmp22", "globalpsp", "solarradiationhorizontal"),
)
BEAM = _light(
    *("dni", "dni", "beam irradiance towards the sun"),
    *("directnormal", "directnormalirradiance", "directnormalradiation", "beamirradiance", "beamnormal", "bni", "gbn"),
    *("beamnormalirradiance", "directnip", "directchp11", "allskysfcswdni", "directnormalirradiation"),
)
BEAM_HORIZONTAL = _light(
    *("bhi", "bhi", "beam irradiance on the horizontal"),
    *(
        "directradiation",
        "directhorizontal",
        "beamhorizontal",
        "gbh",
        "beamhorizontalirradiance",
        "directhorizontalirradiance",
    ),
)
DIFFUSE = _light(
    *("dhi", "dhi", "diffuse irradiance on the horizontal"),
    *("dif", "diffuse", "diffusehorizontal", "diffusehorizontalirradiance", "diffuseirradiance", "diffuseradiation"),
    *("gdh", "diffusehoriz", "diffhi", "allskysfcswdiff", "diffusehorizontalradiation", "diffusps", "diffhor"),
)
AIR = Quantity(
    *("ambient_c", "temp_air", TEMPERATURE, "degC", -60.0, 60.0),
    frozenset(
        (
            *(
                "ambient",
                "tempair",
                "airtemp",
                "airtemperature",
                "temperature",
                "temp",
                "ambienttemperature",
                "ambienttemp",
            ),
            *("tamb", "tambient", "t2m", "temperature2m", "drybulb", "drybulbtemperature", "drybulbtemp", "tair", "ta"),
            *("lufttemperatur", "temperatur", "outdoortemperature", "outdoortemp", "tempc", "drybulbt", "temp2m"),
            *("towerdrybulbtemp", "dryairtemp", "tdry"),
        )
    ),
    "temperature of the air",
)
WIND = Quantity(
    *("wind_m_s", "wind_speed", SPEED, "m/s", 0.0, 100.0),
    frozenset(
        (
            *("wind", "windspeed", "ws", "wspd", "windspd", "windvelocity", "avgwindspeed", "windgeschwindigkeit"),
            *("ws10m", "ws2m", "windspeed10m", "windspeed2m", "ff", "windspeedm"),
        )
    ),
    "speed of the wind",
)
DRAWN = Quantity(
    *("power_w", "power", POWER, "W", 0.0, 1e6),
    frozenset(
        (
            *("power", "load", "loadpower", "demand", "pload", "activepower", "leistung", "consumption", "p", "value"),
            *("energy", "verbrauch", "loadenergy", "energyconsumption", "usage", "electricity", "electricload"),
        )
    ),
    "power that the load draws, or energy in each interval",
    assumed=False,
)
WEATHER = (ON_PANEL, GLOBAL, BEAM, BEAM_HORIZONTAL, DIFFUSE, AIR, WIND)
LOAD = (DRAWN,)
UNCLEAR = frozenset(
    (
        *(
            "irradiance",
            "irradiation",
            "radiation",
            "solarradiation",
            "solar",
            "solarirradiance",
            "insolation",
            "g",
            "sun",
        ),
        *(
            "pyranometer",
            "einstrahlung",
            "strahlung",
            "solarirradiation",
            "radiationsolaire",
            "rayonnement",
            "solarrad",
        ),
    )
)
"""Headings of light that do not say whether it falls on the horizontal or on the panel."""


Array = NDArray[np.float64]

LEAST_OF_A_DAY_W_M2 = 10.0
"""What the brightest row of a day must reach: the darkest overcast days do, days in kW/m2 do not."""
WARMEST_NIGHT_C = 43.0
"""Above the highest daily minimum on record, 42.6 degC (Quriyat, Oman, 26 June 2018; WMO)."""
_MINUTES_OF_A_DAY, _HOURS_OF_A_DAY = 1440.0, 24.0
_ROWS_OF_A_DAY = 10


def of_value(quantity: Quantity, value: float, key: str) -> str:
    """Return what a value beyond its limits looks like, for the end of a message; empty where like nothing."""
    if quantity.dimension == TEMPERATURE:
        if 200.0 <= value <= 340.0:
            return _is_it("in kelvin", key, quantity, "K")
        if quantity.high < value <= 140.0:
            return _is_it("in degrees Fahrenheit", key, quantity, "F")
    if quantity.dimension == IRRADIANCE and value > quantity.high:
        return _is_it("an amount in each interval, in kJ/m2 or J/cm2", key, quantity, "kJ/m2")
    return ""


def refuse(path: Path, quantity: Quantity, heading: str, values: Array, key: str) -> None:
    """Refuse values that are possible one by one and not together, as a day's temperatures in degrees Fahrenheit.

    Raises
    ------
    UserError : with the guess, and the override that says the unit.
    """
    known = values[~np.isnan(values)]
    if not len(known) or quantity.dimension != TEMPERATURE:
        return
    if len(known) >= _ROWS_OF_A_DAY and float(known.min()) >= WARMEST_NIGHT_C:
        raise UserError(
            f"{path}: column {heading}: from {known.min():g} to {known.max():g} {quantity.unit}; no night is warmer "
            f"than {WARMEST_NIGHT_C:g} degC{_is_it('in degrees Fahrenheit', key, quantity, 'F')}"
        )


def refuse_dark(path: Path, heading: str, name: str, values: Array, key: str) -> None:
    """Refuse a day whose light looks like kW/m2.

    Raises
    ------
    UserError : the brightest row lies below 10 W/m2.
    """
    most = float(np.nanmax(values)) if len(values) and not np.isnan(values).all() else 0.0
    if most < LEAST_OF_A_DAY_W_M2:
        raise UserError(
            f"{path}: column {heading}: at most {most:g} W/m2 all day; allowed is a day that reaches "
            f"{LEAST_OF_A_DAY_W_M2:g} W/m2. Is the file in kW/m2? '{key}units={{{name}: kW/m2}}'"
        )


def refuse_short(path: Path, column: str, starts_s: Array, step_s: float, key: str) -> None:
    """Refuse seconds since midnight that look like minutes or hours of a whole day.

    Raises
    ------
    UserError : many rows that all lie in the first 24 minutes or seconds.
    """
    if len(starts_s) < _ROWS_OF_A_DAY:
        return
    end_s = float(starts_s[-1]) + step_s
    for limit, name, unit in ((_HOURS_OF_A_DAY, "hours", "h"), (_MINUTES_OF_A_DAY, "minutes", "min")):
        if end_s <= limit + 1e-9:
            raise UserError(
                f"{path}: column {column}: {len(starts_s)} rows within {end_s:g} s after midnight; are they {name}? "
                f"'{key}units={{time_s: {unit}}}'; or, where they are seconds, '{key}units={{time_s: s}}'"
            )


def _is_it(what: str, key: str, quantity: Quantity, unit: str) -> str:
    return f". Is it {what}? '{key}units={{{quantity.name}: {unit}}}'"
