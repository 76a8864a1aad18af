"""The quantities that files hold: what they are called, their units, what values they may have."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import UserError, best_matches

IRRADIANCE, TEMPERATURE, SPEED, POWER, TIME, RATE, GRADIENT, VOLTAGE, CURRENT, NONE = (
    "irradiance",
    "temperature",
    "speed",
    "power",
    "time",
    "rate",
    "gradient",
    "voltage",
    "current",
    "none",
)
BASE = {
    IRRADIANCE: "W/m2",
    TEMPERATURE: "degC",
    SPEED: "m/s",
    POWER: "W",
    TIME: "s",
    RATE: "C",
    GRADIENT: "degC per unit of time",
    VOLTAGE: "V",
    CURRENT: "A",
    NONE: "1",
}


class Unit(NamedTuple):
    """base = (value + shift) * factor; `each_interval` : an amount in each row's interval, divided by its length."""

    factor: float
    shift: float = 0.0
    each_interval: bool = False


_HOUR_S = 3600.0
_BTU_FT2_W_M2 = 3.154590745
_KNOWN: dict[str, dict[str, Unit]] = {
    IRRADIANCE: {
        **dict.fromkeys(("w/m2", "wm-2", "w/m²", "wh/m2/h", "whm-2h-1"), Unit(1.0)),
        **dict.fromkeys(("kw/m2", "kwm-2", "kwh/m2/h"), Unit(1e3)),
        "mw/cm2": Unit(10.0),
        "kj/m2/h": Unit(1e3 / _HOUR_S),
        "mj/m2/h": Unit(1e6 / _HOUR_S),
        "btu/h/ft2": Unit(_BTU_FT2_W_M2),
        **dict.fromkeys(("wh/m2", "whm-2"), Unit(_HOUR_S, each_interval=True)),
        **dict.fromkeys(("kwh/m2", "kwhm-2"), Unit(1e3 * _HOUR_S, each_interval=True)),
        **dict.fromkeys(("j/m2", "jm-2"), Unit(1.0, each_interval=True)),
        **dict.fromkeys(("kj/m2", "kjm-2"), Unit(1e3, each_interval=True)),
        **dict.fromkeys(("mj/m2", "mjm-2"), Unit(1e6, each_interval=True)),
        **dict.fromkeys(("j/cm2", "jcm-2"), Unit(1e4, each_interval=True)),
    },
    TEMPERATURE: {
        **dict.fromkeys(("c", "degc", "celsius", "degreec", "degreesc"), Unit(1.0)),
        **dict.fromkeys(("k", "kelvin", "degk"), Unit(1.0, -273.15)),
        **dict.fromkeys(("f", "degf", "fahrenheit", "degreef", "degreesf"), Unit(5.0 / 9.0, -32.0)),
    },
    SPEED: {
        **dict.fromkeys(("m/s", "ms-1", "mps", "meter/s"), Unit(1.0)),
        **dict.fromkeys(("km/h", "kmh", "kph", "kmh-1"), Unit(1.0 / 3.6)),
        **dict.fromkeys(("mph", "mi/h", "mp/h", "miles/h"), Unit(0.44704)),
        **dict.fromkeys(("kn", "kt", "kts", "knots"), Unit(1852.0 / 3600.0)),
        "ft/s": Unit(0.3048),
    },
    POWER: {
        **dict.fromkeys(("w", "watt", "watts"), Unit(1.0)),
        "kw": Unit(1e3),
        "wh/h": Unit(1.0),
        "kwh/h": Unit(1e3),
        "wh": Unit(_HOUR_S, each_interval=True),
        "kwh": Unit(1e3 * _HOUR_S, each_interval=True),
        "j": Unit(1.0, each_interval=True),
        "kj": Unit(1e3, each_interval=True),
        "mj": Unit(1e6, each_interval=True),
    },
    TIME: {
        **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), Unit(1.0)),
        "ms": Unit(1e-3),
        **dict.fromkeys(("min", "mins", "minute", "minutes"), Unit(60.0)),
        **dict.fromkeys(("h", "hr", "hrs", "hour", "hours"), Unit(_HOUR_S)),
    },
    RATE: {"c": Unit(1.0), "1/h": Unit(1.0), "c-rate": Unit(1.0)},
    GRADIENT: {},
    VOLTAGE: {**dict.fromkeys(("v", "volt", "volts"), Unit(1.0)), "mv": Unit(1e-3), "uv": Unit(1e-6)},
    CURRENT: {
        **dict.fromkeys(("a", "amp", "amps", "ampere", "amperes"), Unit(1.0)),
        "ma": Unit(1e-3),
        **dict.fromkeys(("ua", "µa"), Unit(1e-6)),
    },
    NONE: {},
}
_BRACKETS = re.compile(r"^(.*?)\s*[(\[{]\s*([^()\[\]{}]*?)\s*[)\]}]+\s*$")
_PVGIS = re.compile(r"G[bdr]?\([hin]\)")
"""Of PVGIS, where brackets hold no unit: light on the horizontal, on the inclined plane, towards the sun."""
_SLASH = re.compile(r"^(.*\S)\s+/\s+(\S+)$")
_SUFFIX = re.compile(r"^(.+)_(k?w_m2|k?wh_m2|w|kw|wh|kwh|c|k|f|m_s|km_h|s|min|h|w/m2|m/s|mV|mA|uA|µA|mv|ma|ua)$")
_CLOSE = re.compile(r"^((?!.*\b(?:k?m|mi)/)[^/]*[^/\s])/(ms|s|sec|min|h|m?V|[mµu]?A|°C|degC|C|K)$")
"""Of potentiostats: `time/s`, `Ewe/V`, `I/mA`; no speed."""


def unit(text: str, dimension: str) -> Unit | None:
    """Return a unit of a dimension; none where it is not known."""
    return _KNOWN[dimension].get(_plain(text))


def wanted(text: str, dimension: str, name: str) -> Unit:
    """Return a unit that a person names for a quantity.

    Raises
    ------
    UserError : not known for this dimension; those that are known are named.
    """
    found = unit(text, dimension)
    if found is None:
        known = sorted(_KNOWN[dimension])
        raise UserError(f"units.{name} is {text!r}; {best_matches(text, known)}; allowed are {', '.join(known)}")
    return found


def is_unit(text: str) -> bool:
    """Tell whether a cell names a unit of any dimension, or is one in brackets, a percentage or a dash."""
    plain = _plain(text.strip().strip("[]()"))
    known = any(plain in units for units in _KNOWN.values())
    return known or text.strip() in ("-", "%", "deg", "°") or bool(re.fullmatch(r"\s*[\[(].*[\])]\s*", text))


def split(heading: str) -> tuple[str, str | None]:
    """Return a heading without its unit, and the unit: `GHI (W/m2)`, `Voltage / V`, `I/mA`, `ghi_w_m2`."""
    if _PVGIS.fullmatch(heading.strip()):
        return heading, None
    bracketed = _BRACKETS.match(heading)
    if bracketed and bracketed[1]:
        return bracketed[1], bracketed[2]
    slashed = _SLASH.match(heading)
    if slashed:
        return slashed[1], slashed[2]
    suffixed = _SUFFIX.match(heading)
    if suffixed:
        return suffixed[1], suffixed[2].replace("_", "/")
    close = _CLOSE.match(heading.strip())
    return (close[1], close[2]) if close else (heading, None)


def known(dimension: str) -> Iterable[str]:
    """Return the spellings of the units of a dimension."""
    return _KNOWN[dimension]


def _plain(text: str) -> str:
    """Return a unit without what it may be written with or without: powers, degrees, dots, spaces."""
    found = text.lower().replace("²", "2").replace("⁻", "-").replace("¹", "1").replace("°", "").replace("º", "")
    found = found.replace("^", "").replace("**", "").replace("·", "").replace("*", "").replace(" per ", "/")
    found = found.replace("m-2", "m-2").replace("sqm", "m2").replace("watts", "w").replace("watt", "w")
    return found.replace(" ", "").replace(".", "").strip()


class Quantity(NamedTuple):
    """A quantity of a file.

    Arguments
    ---------
    name : as in `columns` and `units` of a record; `alias` : pvlib's name for it, which may stand there too.
    dimension, unit : of which kind it is, and the unit it is returned in.
    low, high : what it may be.
    words : what headings call it, as `pipeline.files.cells.plain` gives them.
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
