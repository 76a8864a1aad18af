"""Weather: a place and date, or a file, in; irradiance, air and cell temperature over time out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from pipeline import own_series, quantity, schemas, schemas_day, tables
from pipeline.weather.measured import Gap
from pipeline.weather.records import Weather
from pipeline.weather.sky import sky_of
from pipeline.weather.summary import gaps_within, quantities


def run(settings: Mapping[str, Any], inputs: Mapping[str, Path], output: Path) -> None:
    """Write the weather of a day, and what it comes to."""
    weather: Weather = TypeAdapter(Weather).validate_python(own_series.without_digest(settings["weather"]))
    measured = own_series.weather_rows(weather)
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
    listed = {name: [getattr(gap, name) for gap in missing] for name in Gap._fields}
    tables.write(schemas_day.WEATHER_GAPS, listed, output / "gaps.parquet")
    tables.write(schemas_day.WEATHER, columns, output / "weather.parquet")
    tables.write(schemas.QUANTITIES, quantity.columns(found), output / "quantities.parquet")
