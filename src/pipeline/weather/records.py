"""What weather is made of; light to import."""

from __future__ import annotations

import datetime
from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, Field, field_validator, model_validator

from pipeline.errors import best_matches
from pipeline.panel.records import ConstantWeather
from pipeline.record import OwnFile, Record

_MOST_OFF_H = 4.0
YEARS = range(1800, 2201)
"""Years that a date or a time may have: arithmetic ends at the years 1 and 9999, that of pandas at 1677 and 2262."""


def _is_a_date(date: str) -> str:
    try:
        usual = datetime.date.fromisoformat(date).isoformat() == date
    except ValueError:
        usual = False
    if not usual:
        raise ValueError(f"date is {date!r}; it must be a day as YYYY-MM-DD, e.g. 2015-03-20")
    if int(date[:4]) not in YEARS:
        raise ValueError(f"date is {date!r}; allowed are the years {YEARS[0]} to {YEARS[-1]}")
    return date


Date = Annotated[str, AfterValidator(_is_a_date)]


class SapmCells(Record):
    """Cell temperature after King et al. (2004), SAND2004-3535: module back from wind, cells above it."""

    kind: Literal["sapm"] = "sapm"
    a: float = Field(le=0, description="exponent without wind [1]")
    b_s_m: float = Field(le=0, description="its change with wind [s/m]")
    cell_above_back_k: float = Field(ge=0, description="cells above the module's back at 1000 W/m2 [K]")


class FaimanCells(Record):
    """Cell temperature after Faiman (2008), DOI 10.1002/pip.813: a loss factor that grows with wind."""

    kind: Literal["faiman"] = "faiman"
    u0_w_m2_k: float = Field(gt=0, description="heat loss without wind [W/m2/K]")
    u1_w_s_m3_k: float = Field(ge=0, description="its growth with wind [W s/m3/K]")


class NoctCells(Record):
    """Cell temperature from the nominal operating cell temperature alone, after Ross (1980)."""

    kind: Literal["noct"] = "noct"
    noct_c: float = Field(gt=20, le=90, description="nominal operating cell temperature [degC]")


Cells: TypeAlias = Annotated[SapmCells | FaimanCells | NoctCells, Field(discriminator="kind")]


class Place(Record):
    """Where the panel stands."""

    latitude_deg: float = Field(ge=-90, le=90, description="latitude, positive north [deg]")
    longitude_deg: float = Field(ge=-180, le=180, description="longitude, positive east [deg]")
    altitude_m: float = Field(ge=-450, le=9000, description="altitude [m]")
    utc_offset_h: float = Field(ge=-12, le=14, description="local time less universal time [h]")

    @model_validator(mode="after")
    def _by_day(self) -> Place:
        off_h = (self.utc_offset_h - self.longitude_deg / 15.0 + 12.0) % 24.0 - 12.0
        if abs(off_h) > _MOST_OFF_H:
            raise ValueError(
                f"utc_offset_h is {self.utc_offset_h:g} h at longitude_deg {self.longitude_deg:g}, {abs(off_h):.1f} h "
                f"off the sun's time; allowed are {_MOST_OFF_H:g} h, or the day would not lie between two midnights"
            )
        return self


class Surface(Record):
    """How the panel stands."""

    tilt_deg: float = Field(ge=0, le=90, description="tilt from the horizontal [deg]")
    azimuth_deg: float = Field(ge=0, le=360, description="azimuth, 180 faces south [deg]")
    albedo: float = Field(ge=0, le=1, description="share of light the ground reflects [1]")


class Air(Record):
    """The air over a day, a sine between its extremes."""

    lowest_c: float = Field(ge=-60, le=60, description="lowest temperature [degC]")
    highest_c: float = Field(ge=-60, le=60, description="highest temperature [degC]")
    warmest_h: float = Field(ge=0, le=24, description="local time at which it is warmest [h]")
    wind_m_s: float = Field(ge=0, le=40, description="wind at the panel [m/s]")

    @model_validator(mode="after")
    def _ordered(self) -> Air:
        if self.highest_c < self.lowest_c:
            raise ValueError(f"highest_c is {self.highest_c:g} degC; it must not lie below lowest_c, {self.lowest_c:g}")
        return self


class ClearSky(Record):
    """A day under a clear sky: Ineichen and Perez (2002), DOI 10.1016/S0038-092X(02)00045-2, through pvlib."""

    kind: Literal["clear_sky"] = "clear_sky"
    title: str = Field(min_length=1, description="name of the weather, for people")
    place: Place
    date: Date = Field(description="date of the day, YYYY-MM-DD")
    surface: Surface
    linke_turbidity: float = Field(ge=1, le=10, description="Linke turbidity, clear dry air being 1 to 2 [1]")
    air: Air
    cell_temperature: Cells
    interval_s: float = Field(default=60.0, ge=1, le=3600, description="interval over which the sun stands still [s]")

    @model_validator(mode="after")
    def _whole_day(self) -> ClearSky:
        if (86400.0 / self.interval_s) % 1.0 > 1e-9:
            raise ValueError(f"interval_s is {self.interval_s:g} s; it must divide a day of 86400 s")
        return self


class Clouds(Record):
    """Clouds that pass: sun and cloud in turn, for lengths of time drawn from exponential distributions.

    Each cloud lets a share of the clear sky's global irradiance through, drawn evenly about the mean.
    """

    sun_share: float = Field(ge=0, le=1, description="mean share of time without a cloud before the sun [1]")
    mean_cloud_s: float = Field(ge=10, le=86400, description="mean time a cloud takes to pass [s]")
    transmittance: float = Field(gt=0, le=1, description="mean share of global irradiance under a cloud [1]")
    spread: float = Field(ge=0, lt=1, description="largest departure of a cloud from this mean, over the mean [1]")
    edge_s: float = Field(default=0.0, ge=0, le=60, description="time the edge of a cloud takes to pass [s]")
    seed: int = Field(ge=0, description="root of the day's random stream [1]")

    @model_validator(mode="after")
    def _no_amplifier(self) -> Clouds:
        most = self.transmittance * (1.0 + self.spread)
        if most > 1.0:
            raise ValueError(f"transmittance x (1 + spread) is {most:g}; clouds let at most 1 through")
        return self


class CloudySky(ClearSky):
    """A day on which clouds pass before the clear sky."""

    kind: Literal["cloudy_sky"] = "cloudy_sky"  # type: ignore[assignment]
    clouds: Clouds


Format: TypeAlias = Literal[
    "auto",
    "csv",
    "bsrn",
    "cams",
    "crn",
    "epw",
    "midc",
    "psm4",
    "pvgis_hourly",
    "pvgis_tmy",
    "solaranywhere",
    "solrad",
    "srml",
    "surfrad",
    "tmy2",
    "tmy3",
]
"""What a weather's file is: found out, any table, or what pvlib has a reader for."""
LIGHT = ("irradiance_w_m2", "ghi", "dni", "bhi", "dhi")
COLUMNS = ("time", "time_s", "date", *LIGHT, "poa_global", "poa", "ambient_c", "temp_air", "wind_m_s", "wind_speed")


class MeasuredWeather(OwnFile):
    """A file with the weather of a local day: light on the panel, or its parts and how the panel stands; air, wind.

    Each row holds over its interval. The parts of the light (`ghi`, `dni`, `dhi`, `bhi`; `ghi` alone is split) are
    brought onto the panel by Hay and Davies (1980) through pvlib, for which `surface` and `place` are needed; a format
    that says its place needs no `place`. Light on the panel (`irradiance_w_m2`) is taken as it is.
    """

    kind: Literal["table"] = "table"
    title: str = Field(min_length=1, description="name of the weather, for people")
    format: Format = Field(
        default="auto", description="what the file is; auto looks at it, and what it took it for is told"
    )
    date: Date | None = Field(
        default=None,
        description="local day that is taken of the file, needed where it has several; day of a file of times of day",
    )
    place: Place | None = Field(default=None, description="where the panel stands, where the file does not say it")
    surface: Surface | None = Field(
        default=None, description="how the panel stands, where the file has the light on the horizontal"
    )
    longest_gap_s: float = Field(
        default=600.0, ge=0, description="longest gap in the file that is interpolated; a longer one is dark [s]"
    )
    longest_gap_rows: float = Field(
        default=2.0,
        ge=0,
        description="missing rows that are interpolated, where these are longer, as in files by the hour [1]",
    )
    ambient_c: float | None = Field(
        default=None, ge=-60, le=60, description="temperature of the air where the file has none [degC]"
    )
    wind_m_s: float = Field(ge=0, le=40, description="wind at the panel where the file has none [m/s]")
    cell_temperature: Cells

    @field_validator("columns", "units")
    @classmethod
    def _known(cls, value: dict[str, str]) -> dict[str, str]:
        for name in value:
            if name not in COLUMNS:
                raise ValueError(f"{name!r} is no quantity of a weather; {best_matches(name, COLUMNS)}")
        return value

    @model_validator(mode="after")
    def _one_offset(self) -> MeasuredWeather:
        given = self.utc_offset_h
        if self.place is not None and given is not None and given != self.place.utc_offset_h:
            raise ValueError(
                f"utc_offset_h is {given:g} and place.utc_offset_h {self.place.utc_offset_h:g}; one is enough"
            )
        return self

    def longest_gap(self, step_s: float) -> float:
        """Return the longest gap that is interpolated in a file of an interval [s]."""
        return max(self.longest_gap_s, self.longest_gap_rows * step_s if self.longest_gap_s > 0.0 else 0.0)


Weather: TypeAlias = Annotated[ConstantWeather | ClearSky | CloudySky | MeasuredWeather, Field(discriminator="kind")]
"""Every kind of weather there is."""
