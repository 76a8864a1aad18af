"""A person's own files: what is read, and every mistake told with file, row, column, value and what is allowed."""

import datetime
import re

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline import own_series, series_file
from pipeline.bus.records import MeasuredLoad
from pipeline.errors import UserError
from pipeline.weather.records import MeasuredWeather, NoctCells

GOOD = "time_s,irradiance_w_m2,ambient_c\n21600,0,15\n21660,12.5,15.1\n21780,30,15.2\n"


def write(folder, text, name="own.csv"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def read(path):
    return series_file.read(path, own_series.WEATHER)


def test_a_csv_is_read(tmp_path):
    found = read(write(tmp_path, GOOD))
    assert set(found) == {"clock_s", "irradiance_w_m2", "ambient_c"}
    np.testing.assert_array_equal(found["clock_s"], [21600, 21660, 21780])
    np.testing.assert_array_equal(found["irradiance_w_m2"], [0, 12.5, 30])


def test_spaces_a_mark_of_byte_order_and_other_columns_do_no_harm(tmp_path):
    text = "\ufeffremark, time_s, irradiance_w_m2, ambient_c, wind_m_s\n\na, 0, 1, 2, 3\nb, 1, 1, 2, 4\n"
    found = read(write(tmp_path, text))
    assert found["wind_m_s"].tolist() == [3, 4]
    assert "remark" not in found


@pytest.mark.parametrize("offset", ["", "+08:00", "Z"])
def test_times_of_day_count_from_midnight(tmp_path, offset):
    rows = [f"2015-03-20T06:30:00{offset},5,15", f"2015-03-21T00:00:01{offset},5,15"]
    found = read(write(tmp_path, "\n".join(["time,irradiance_w_m2,ambient_c", *rows])))
    assert found["clock_s"].tolist() == [6.5 * 3600, 86401]


def test_times_with_offsets_are_compared_as_moments(tmp_path):
    rows = ["2015-03-20T06:00:00+08:00,5,15", "2015-03-20T00:00:00+01:00,5,15"]
    found = read(write(tmp_path, "\n".join(["time,irradiance_w_m2,ambient_c", *rows])))
    assert found["clock_s"].tolist() == [6 * 3600, 7 * 3600]


def test_a_parquet_file_is_read(tmp_path):
    start = datetime.datetime(2015, 3, 20, 6)
    columns = {
        "time": [start, start + datetime.timedelta(seconds=90)],
        "irradiance_w_m2": [1.0, 2.0],
        "ambient_c": [15, 16],
    }
    pq.write_table(pa.table(columns), tmp_path / "own.parquet")
    found = read(tmp_path / "own.parquet")
    assert found["clock_s"].tolist() == [21600, 21690]
    assert found["ambient_c"].tolist() == [15, 16]


BAD = {
    "no column": (GOOD.replace("irradiance_w_m2", "irradiance"), r"no column 'irradiance_w_m2' \[W/m2\].*irradiance"),
    "no time": (GOOD.replace("time_s", "seconds"), r"has neither of the columns time_s \[s\] and time"),
    "two times": ("time,time_s,irradiance_w_m2,ambient_c\n1,1,1,1\n2,2,2,2\n", "has both of the columns time_s"),
    "a column twice": (
        "time_s,ambient_c,irradiance_w_m2,ambient_c\n0,1,1,1\n",
        r"line 1: column 'ambient_c' stands there 2",
    ),
    "a word": (
        GOOD.replace("12.5", "dim"),
        r"line 3, column irradiance_w_m2: value 'dim'; allowed .* -20 to 2000 W/m2",
    ),
    "nothing": (GOOD.replace("12.5", ""), r"line 3, column irradiance_w_m2: empty; allowed is a number from -20"),
    "not a number": (GOOD.replace("12.5", "nan"), r"line 3, column irradiance_w_m2: value 'nan'"),
    "infinite": (GOOD.replace("12.5", "inf"), r"line 3, column irradiance_w_m2: value 'inf'"),
    "too bright": (GOOD.replace("12.5", "2001"), r"line 3, column irradiance_w_m2: value '2001'; .* 2000 W/m2"),
    "in kelvin": (GOOD.replace(",15.2", ",288.4"), r"line 4, column ambient_c: value '288.4'; .* -60 to 60 degC"),
    "back in time": (
        GOOD.replace("21780", "21600"),
        r"line 4, column time_s: value '21600'; .* after .* value '21660'",
    ),
    "twice the same": (
        GOOD.replace("21780", "21660"),
        r"line 4, column time_s: value '21660'; allowed is a time after",
    ),
    "before midnight": (GOOD.replace("21600", "-1"), r"line 2, column time_s: -1; allowed is 0"),
    "a cell too few": (GOOD.replace("21660,12.5,15.1", "21660,12.5"), "line 3: 2 values; allowed are 3"),
    "a cell too many": (GOOD.replace("12.5,", "12,5,"), "line 3: 4 values; allowed are 3"),
    "one row": ("\n".join(GOOD.split("\n")[:2]), "1 rows; allowed are 2 and more"),
    "no rows": (GOOD.split("\n")[0], "0 rows"),
    "empty": ("", "empty; allowed is a line of column names"),
    "no such day": (
        "time,irradiance_w_m2,ambient_c\n2015-02-30T00:00:00,1,1\n2015-03-01T00:00:00,1,1\n",
        r"line 2, column time: value '2015-02-30T00:00:00'; allowed is a time as 2015-03-20",
    ),
    "offsets for some": (
        "time,irradiance_w_m2,ambient_c\n2015-02-20T00:00:00,1,1\n2015-03-01T00:00:00Z,1,1\n",
        "line 3, column time: .*all have an offset",
    ),
    "wind against": (
        "time_s,irradiance_w_m2,ambient_c,wind_m_s\n0,1,1,1\n1,1,1,-1\n",
        "line 3, column wind_m_s: value '-1'; .* 0 to 100 m/s",
    ),
}


@pytest.mark.parametrize("mistake", BAD)
def test_a_mistake_is_told(tmp_path, mistake):
    text, message = BAD[mistake]
    path = write(tmp_path, text)
    with pytest.raises(UserError, match=rf"{re.escape(str(path))}: .*{message}|{re.escape(str(path))}: {message}"):
        read(path)


def test_other_files_are_refused(tmp_path):
    with pytest.raises(UserError, match="no such file"):
        read(tmp_path / "none.csv")
    with pytest.raises(UserError, match=r"ends in '.txt'; allowed are .csv, .parquet"):
        read(write(tmp_path, GOOD, "own.txt"))
    with pytest.raises(UserError, match="not a readable Parquet file"):
        read(write(tmp_path, GOOD, "own.parquet"))
    (tmp_path / "latin.csv").write_bytes(b"time_s,\xe9\n1,2\n")
    with pytest.raises(UserError, match="not a CSV file in UTF-8"):
        read(tmp_path / "latin.csv")


def test_a_parquet_row_is_named(tmp_path):
    columns = {"time_s": [0.0, 1.0], "irradiance_w_m2": [1.0, None], "ambient_c": [1.0, 1.0]}
    pq.write_table(pa.table(columns), tmp_path / "own.parquet")
    with pytest.raises(UserError, match="row 2, column irradiance_w_m2: empty"):
        read(tmp_path / "own.parquet")


def test_the_content_of_a_file_enters_the_key(tmp_path):
    path = write(tmp_path, GOOD)
    card = MeasuredWeather(title="own", file=str(path), wind_m_s=1.0, cell_temperature=NoctCells(noct_c=45.0))
    before = own_series.settings(card, "own")
    assert own_series.settings(card, "own") == before
    write(tmp_path, GOOD.replace("12.5", "12.6"))
    assert own_series.settings(card, "own")["file_sha256"] != before["file_sha256"]
    assert MeasuredWeather.model_validate(own_series.without_digest(before)) == card


def test_a_load_is_read_in_the_same_way(tmp_path):
    path = write(tmp_path, "time_s,power_w\n0,3\n3600,5\n")
    found = own_series.load_rows(MeasuredLoad(title="own", file=str(path)))
    assert found is not None
    assert (found.clock_s.tolist(), found.power_w.tolist()) == ([0, 3600], [3, 5])
    write(tmp_path, "time_s,power_w\n0,-3\n")
    with pytest.raises(UserError, match="line 2, column power_w: value '-3'"):
        own_series.load_rows(MeasuredLoad(title="own", file=str(path)))
