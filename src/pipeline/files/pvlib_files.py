"""Weather files read by pvlib, as tables."""

from __future__ import annotations

import re
import tempfile
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pipeline.errors import UserError
from pipeline.files.cells import Table
from pipeline.files.clock import Clock
from pipeline.files.content import Content, text_of
from pipeline.files.time_columns import WANTED
from pipeline.record import Label

if TYPE_CHECKING:
    import pandas as pd


class Known(NamedTuple):
    """A format.

    Arguments
    ---------
    name : as in the key `format`; `title` : for people.
    tells : whether the first lines of a file are of it.
    label : where in its interval a time stands, as pvlib's reader returns it.
    typical : whether it is a year put together from several.
    heading : how the line above the data begins, or their number of lines, to name rows; none where rows are not lines.
    """

    name: str
    title: str
    tells: Callable[[Sequence[str]], bool]
    label: Label
    typical: bool = False
    heading: str | int | None = None


def _any(lines: Sequence[str], start: str, most: int = 60) -> bool:
    return any(line.startswith(start) for line in lines[:most])


def _formats_line(lines: Sequence[str], place: int) -> str:
    return lines[place] if len(lines) > place else ""


def _fits(pattern: str, place: int = 0) -> Callable[[Sequence[str]], bool]:
    compiled = re.compile(pattern)
    return lambda lines: bool(compiled.match(_formats_line(lines, place)))


def _is_pvgis(what: str) -> Callable[[Sequence[str]], bool]:
    def tells(lines: Sequence[str]) -> bool:
        if _formats_line(lines, 0).lstrip().startswith("{"):
            text = "".join(lines[:200])[:100_000]
            return '"outputs"' in text and f'"{"tmy_hourly" if what == "time(UTC)" else "hourly"}"' in text
        return _formats_line(lines, 0).startswith("Latitude (decimal degrees)") and _any(lines, what)

    return tells


FORMATS = (
    # Wilcox and Marion (2008), NREL/TP-581-43156: hours from 01:00 to 24:00, each the end of its own.
    Known("tmy3", "TMY3", _fits(r"Date \(MM/DD/YYYY\),Time \(HH:MM\),ETR ", 1), "end", True, 2),
    Known(
        "solaranywhere",
        "SolarAnywhere",
        lambda lines: "ObservationTime(LST)" in _formats_line(lines, 1),
        "end",
        False,
        2,
    ),
    # Marion and Urban (1995), DOI 10.2172/87130; pvlib counts its hours from 0.
    Known("tmy2", "TMY2", _fits(r" ?\d{5} .{20,30} *-?\d+ [NS] +\d+ +\d+ [EW] +\d+ +\d+ +-?\d+"), "start", True, 1),
    # EnergyPlus, Auxiliary Programs; pvlib counts its hours from 0.
    Known("epw", "EPW", _fits("LOCATION,"), "start", True, 8),
    Known("psm4", "NSRDB PSM", _fits("Source,Location ID,"), "middle", False, 3),
    Known("pvgis_tmy", "PVGIS typical year", _is_pvgis("time(UTC)"), "middle", True, "time(UTC)"),
    Known("pvgis_hourly", "PVGIS hourly", _is_pvgis("time,"), "middle", False, "time,"),
    Known(
        "cams",
        "CAMS radiation",
        lambda lines: _any(lines, "# Observation period", 100),
        "start",
        False,
        "# Observation",
    ),
    Known("midc", "MIDC", _fits(r"DATE \(MM/DD/YYYY\),|[^,]*,Year,DOY,[A-Z]{3},"), "end", False, 1),
    Known("surfrad", "SURFRAD", _fits(r" +-?[\d.]+ +-?[\d.]+ +-?\d+ +m +version", 1), "end", False, 2),
    Known("bsrn", "BSRN station-to-archive", _fits(r"[*][CU]0001"), "start"),
    Known("crn", "US Climate Reference Network", _fits(r"\d{5} \d{8} \d{4} \d{8} \d{4} "), "end", False, 0),
    Known("srml", "SRML", _fits(r"\d+\t\d{4}\t(\d+\t\d+\t?)+"), "start", False, 1),
    Known("solrad", "SOLRAD", lambda lines: _solrad(lines), "end", False, 2),
)
BY_NAME = {one.name: one for one in FORMATS}


def _solrad(lines: Sequence[str]) -> bool:
    numbers = r" *-?\d+\.\d+ +-?\d+\.\d+ +-?\d+(\.\d+)? +-?\d+( +version.*)? *$"
    return bool(re.match(numbers, _formats_line(lines, 1))) and bool(
        re.match(r" *\d{4} +\d+ +\d+ +\d+ ", _formats_line(lines, 2))
    )


def taken_for(lines: Sequence[str]) -> Known | None:
    """Return the format that a file's first lines are of; none where of none, which is then a table."""
    return next((one for one in FORMATS if one.tells(lines)), None)


_NAMES = {
    "ghi": "ghi",
    "dni": "dni",
    "dhi": "dhi",
    "bhi": "bhi",
    "poa_global": "irradiance_w_m2",
    "temp_air": "ambient_c",
    "wind_speed": "wind_m_s",
}
_TMY2 = {"GHI": "ghi", "DNI": "dni", "DHI": "dhi", "DryBulb": "temp_air", "Wspd": "wind_speed"}
_LIGHT = frozenset(("ghi", "dni", "dhi", "bhi", "irradiance_w_m2"))
_MISSING_LIGHT, _NO_LIGHT, _NO_AIR, _NO_WIND = -90.0, 9999.0, 99.0, 99.0


class Header(NamedTuple):
    """What a file says of where it was measured: [deg], [m], local less universal time [h]; none where it does not."""

    latitude_deg: float | None = None
    longitude_deg: float | None = None
    altitude_m: float | None = None
    utc_offset_h: float | None = None


class PvlibFile(NamedTuple):
    """A file as pvlib read it: a table with our names where pvlib has its own, its times, its header."""

    table: Table
    clock: Clock
    header: Header


def read(content: Content, known: Known, asked: bool) -> PvlibFile:
    """Read a file with pvlib's reader of its format.

    pvlib reads from a file of its own, decoded and unpacked, so that neither packing nor encoding matters.

    Arguments
    ---------
    content : the file.
    known : the format.
    asked : whether the person named the format, or it was found.

    Raises
    ------
    UserError : pvlib refuses the file.
    """
    text, said = text_of(content)
    suffix = ".json" if text.lstrip().startswith("{") else ".csv"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"weather-{'msn' if 'msn' in content.name else 'file'}{suffix}"
        path.write_text(text, encoding="ascii", errors="replace", newline="")
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                frame, meta = _call(known.name, path, text)
                frame = _cleaned(frame, known.name)
                clock = _clock(frame, known)
        except Exception as error:  # what a reader raises on a file that is not of its format is of every kind
            how = (
                f"{content.path}: format is {known.name}, and"
                if asked
                else f"{content.path}: was taken for {known.title}, but"
            )
            raise UserError(
                f"{how} pvlib's reader refuses it ({type(error).__name__}: {_line(error)}); was it edited, or "
                "cut short? Any table is read with format=csv and columns={ghi: HEADING, ...}"
            ) from None
    places = _places(text, known, len(frame))
    columns: dict[str, Any] = {str(name): frame[name].tolist() for name in frame.columns}
    table = Table(content.path, columns, {}, "row" if places is None else "line", places or range(1, len(frame) + 1))
    table = table._replace(said=(*content.said, *said, *_plane(meta)))
    return PvlibFile(table, clock, _header(meta, known.name))


def _line(error: Exception) -> str:
    return " ".join(str(error).split())[:200]


def _call(name: str, path: Path, text: str) -> tuple[pd.DataFrame, Mapping[str, Any]]:
    from pvlib import iotools

    plain = {
        "tmy2": iotools.read_tmy2,
        "epw": iotools.read_epw,
        "psm4": iotools.read_nsrdb_psm4,
        "pvgis_hourly": iotools.read_pvgis_hourly,
        "pvgis_tmy": iotools.read_pvgis_tmy,
        "cams": iotools.read_cams,
        "surfrad": iotools.read_surfrad,
        "solrad": iotools.read_solrad,
        "bsrn": iotools.read_bsrn,
        "solaranywhere": iotools.read_solaranywhere,
    }
    if name in plain:
        return plain[name](str(path))  # type: ignore[no-any-return]
    if name == "tmy3":
        return iotools.read_tmy3(str(path), map_variables=True)  # type: ignore[no-any-return]
    if name == "midc":
        from pvlib.iotools import midc

        names = {heading: own for site in midc.MIDC_VARIABLE_MAP.values() for heading, own in site.items()}
        first = text.splitlines()[0].split(",")
        frame = midc.read_midc(str(path), raw_data="DOY" in first)
        for heading in first:
            if heading in names and names[heading] not in frame.columns:
                frame[names[heading]] = frame[heading]
        return frame, {}
    reader = {"srml": iotools.read_srml, "crn": iotools.read_crn}[name]
    frame = reader(str(path))
    # CRN says in every row where it was measured.
    place = {own: frame[own].iloc[0] for own in ("latitude", "longitude") if own in frame.columns}
    return frame, place


def _cleaned(frame: pd.DataFrame, name: str) -> pd.DataFrame:
    """Give columns our names, and NaN where the format says that nothing was measured."""
    if name == "tmy2":
        frame = frame.rename(columns=_TMY2)
        # Tenths of a degree and of a metre a second: Marion and Urban (1995), Table 3-2.
        frame["temp_air"], frame["wind_speed"] = 0.1 * frame["temp_air"], 0.1 * frame["wind_speed"]
    if name == "srml":
        frame = frame.rename(columns=_srml_names(list(frame.columns)))
    frame = frame.rename(columns={old: new for old, new in _NAMES.items() if old in frame.columns})
    if "irradiance_w_m2" not in frame.columns and {"poa_direct", "poa_sky_diffuse"} <= set(frame.columns):
        ground = frame["poa_ground_diffuse"] if "poa_ground_diffuse" in frame.columns else 0.0
        frame["irradiance_w_m2"] = frame["poa_direct"] + frame["poa_sky_diffuse"] + ground
    for column in frame.columns.intersection(list(_NAMES.values())):
        values = frame[column].to_numpy(dtype=float)
        if column in _LIGHT:
            gone = (values < _MISSING_LIGHT) | (values >= _NO_LIGHT)
        else:
            gone = (values < _MISSING_LIGHT) | (values >= (_NO_AIR if column == "ambient_c" else _NO_WIND))
        frame[column] = np.where(gone, np.nan, values)
    return frame


def _srml_names(columns: list[str]) -> dict[str, str]:
    """Return the first of each of SRML's numbered instruments as the quantity: `ghi_1` is `ghi`."""
    found: dict[str, str] = {}
    for column in columns:
        base = str(column).rsplit("_", 1)[0]
        if base in _NAMES and not str(column).endswith("flag") and base not in found.values():
            found[str(column)] = base
    return found


def _clock(frame: pd.DataFrame, known: Known) -> Clock:
    import pandas as pd

    index = pd.DatetimeIndex(frame.index)
    wall = (index.tz_localize(None) - pd.Timestamp(0)).total_seconds().to_numpy(dtype=float)
    if index.tz is None:
        offset = np.full(len(index), np.nan)
    else:
        offset = wall - (index.tz_convert("UTC").tz_localize(None) - pd.Timestamp(0)).total_seconds().to_numpy(
            dtype=float
        )
    shown = index.strftime("%Y-%m-%d %H:%M")
    return Clock(
        *(wall, offset, True, known.label, "of times", WANTED, lambda row: f"value {shown[row]}"),
        said=(),
        typical=known.typical,
    )


def _places(text: str, known: Known, count: int) -> range | None:
    if known.heading is None or text.lstrip().startswith("{"):
        return None
    first = known.heading
    if isinstance(first, str):
        start = first
        first = next((number for number, line in enumerate(text.splitlines(), 1) if line.startswith(start)), 0)
    return range(first + 1, first + 1 + count)


def _plane(meta: Mapping[str, Any]) -> tuple[str, ...]:
    """Return how the plane of PVGIS's light stands, which counts its azimuth from the south."""
    given = meta.get("inputs", {}) if isinstance(meta, Mapping) else {}
    found = [f"{name.lower()} {given[name]}" for name in ("Slope", "Azimuth") if given.get(name)]
    return (f"its plane: {', '.join(found)} (from the south)",) if found else ()


def _header(meta: Mapping[str, Any], name: str) -> Header:
    given: Mapping[str, Any] = meta.get("inputs", meta) if isinstance(meta, Mapping) else {}
    given = given.get("location", given) if isinstance(given.get("location"), Mapping) else given

    def value(*keys: str) -> float | None:
        for key in keys:
            try:
                return float(given[key])
            except (KeyError, TypeError, ValueError):
                continue
        return None

    zone = (
        None if name.startswith(("pvgis", "cams", "surfrad", "bsrn")) else value("TZ", "Time Zone", "Local Time Zone")
    )
    return Header(value("latitude", "Latitude"), value("longitude", "Longitude"), value("altitude", "elevation"), zone)
