"""Weather: a place and date, or a file, in; irradiance, air and cell temperature over time out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from pipeline.experiments.days.numbers import WEATHER_NUMBERS
from pipeline.files.content import without_digest
from pipeline.files.weather import told, weather_rows
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.quantity import Quantity
from pipeline.weather.clear_sky import sky_of
from pipeline.weather.measured import DARK, Array, Gap, Measured, gaps, longest_gap_s
from pipeline.weather.records import MeasuredWeather, Weather

_JOULE_PER_KWH = 3.6e6


def gaps_within(weather: Weather, columns: Mapping[str, Array], measured: Measured | None) -> list[Gap]:
    """Return the gaps of a weather's file that begin within its columns; arguments as for `quantities`."""
    if measured is None or not isinstance(weather, MeasuredWeather):
        return []
    until_s = float(columns["time_s"][-1] + columns["interval_s"][-1] + measured.clock_s[0])
    return [gap for gap in gaps(measured, longest_gap_s(weather, measured)) if gap.clock_s < until_s]


def quantities(weather: Weather, columns: Mapping[str, Array], measured: Measured | None) -> list[Quantity]:
    """Return the named numbers of a day's weather.

    Arguments
    ---------
    columns : those of the table of the weather.
    measured : the rows of its file, where it has one.
    """
    lengths, irradiance = columns["interval_s"], columns["irradiance_w_m2"]
    missing = gaps_within(weather, columns, measured)
    dark = [gap for gap in missing if gap.filled == DARK]
    energy = float(np.sum(irradiance * lengths)) / _JOULE_PER_KWH
    values = {
        "irradiation_kwh_m2": energy,
        "highest_irradiance_w_m2": irradiance.max(),
        "length_s": lengths.sum(),
        "mean_ambient_c": np.average(columns["ambient_c"], weights=lengths),
        "highest_cell_temperature_c": columns["cell_temperature_c"].max(),
        "gaps": len(missing),
        "gap_s": sum(gap.length_s for gap in missing),
        "dark_gaps": len(dark),
        "dark_gap_s": sum(gap.length_s for gap in dark),
    }
    return [WEATHER_NUMBERS.quantity(name, float(value)) for name, value in values.items()]


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Write the weather of a day, and what it comes to."""
    weather: Weather = TypeAdapter(Weather).validate_python(without_digest(settings["weather"]))
    measured = weather_rows(weather)
    notes = list(told(weather))
    for sentence in notes:
        print(f"weather {settings['weather']['title']}: {sentence}")
    sky = sky_of(weather, float(settings["ambient_c"]), measured)
    end_s = min(sky.end_s, 3600.0 * float(settings["longest_h"]))
    rows = sky.time_s < end_s
    if not rows.all():
        beyond = int(np.sum(~rows))
        print(f"weather {settings['weather']['title']}: its first {end_s / 3600.0:g} h; {beyond} rows are beyond them")
    columns = {
        "time_s": sky.time_s,
        "clock_s": sky.time_s + sky.clock_s,
        "interval_s": np.zeros_like(sky.time_s),
        "irradiance_w_m2": sky.irradiance_w_m2,
        "ambient_c": sky.ambient_c,
        "cell_temperature_c": sky.cell_temperature_c,
    }
    columns = {name: np.asarray(column)[rows] for name, column in columns.items()}
    columns["interval_s"] = np.diff(columns["time_s"], append=end_s)
    found = quantities(weather, columns, measured)
    missing = gaps_within(weather, columns, measured)
    for gap in missing:
        print(
            f"weather {settings['weather']['title']}: gap of {gap.length_s:g} s in its file, {gap.clock_s:g} s after "
            f"midnight, {gap.filled}"
        )
    output.rows("gaps", missing)
    output.write("notes", {"note": notes})
    output.write("weather", columns)
    output.numbers(found)
