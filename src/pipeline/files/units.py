"""Units as they stand in headings, and their way to the project's own."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from pipeline.errors import UserError, best_matches

IRRADIANCE, TEMPERATURE, SPEED, POWER, TIME, RATE, GRADIENT, NONE = (
    "irradiance",
    "temperature",
    "speed",
    "power",
    "time",
    "rate",
    "gradient",
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
    NONE: {},
}
_BRACKETS = re.compile(r"^(.*?)\s*[(\[{]\s*([^()\[\]{}]*?)\s*[)\]}]+\s*$")
_PVGIS = re.compile(r"G[bdr]?\([hin]\)")
"""Of PVGIS, where brackets hold no unit: light on the horizontal, on the inclined plane, towards the sun."""
_SLASH = re.compile(r"^(.*\S)\s+/\s+(\S+)$")
_SUFFIX = re.compile(r"^(.+)_(k?w_m2|k?wh_m2|w|kw|wh|kwh|c|k|f|m_s|km_h|s|min|h|w/m2|m/s)$")


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
    """Return a heading without its unit, and the unit: `GHI (W/m2)`, `GHI [W/m^2]`, `Voltage / V`, `ghi_w_m2`."""
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
    return heading, None


def known(dimension: str) -> Iterable[str]:
    """Return the spellings of the units of a dimension."""
    return _KNOWN[dimension]


def _plain(text: str) -> str:
    """Return a unit without what it may be written with or without: powers, degrees, dots, spaces."""
    found = text.lower().replace("²", "2").replace("⁻", "-").replace("¹", "1").replace("°", "").replace("º", "")
    found = found.replace("^", "").replace("**", "").replace("·", "").replace("*", "").replace(" per ", "/")
    found = found.replace("m-2", "m-2").replace("sqm", "m2").replace("watts", "w").replace("watt", "w")
    return found.replace(" ", "").replace(".", "").strip()
