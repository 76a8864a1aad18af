"""A person's own files: what is read, and every mistake told with file, row, column, value and what is allowed."""

import datetime
import re

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline.bus.records import MeasuredLoad
from pipeline.errors import UserError
from pipeline.files import weather_file
from pipeline.files.content import settings, without_digest
from pipeline.files.load import load_rows
from pipeline.files.weather import date_of, told, weather_day, weather_rows
from pipeline.weather.records import MeasuredWeather, NoctCells

GOOD = "time_s,irradiance_w_m2,ambient_c\n21600,0,15\n21660,12.5,15.1\n21780,30,15.2\n"


def write(folder, text, name="own.csv"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def card(path, **more):
    cells = NoctCells(noct_c=45.0)
    return MeasuredWeather(title="own", file=str(path), wind_m_s=1.0, cell_temperature=cells, **more)


def read(path, **more):
    return weather_rows(card(path, **more))


def series(folder, *rows, offset_h=None):
    lines = ["time,irradiance_w_m2,ambient_c", *(f"{row},50,15" for row in rows)]
    return weather_day(card(write(folder, "\n".join(lines)), utc_offset_h=offset_h))


def test_a_csv_is_read(tmp_path):
    found = read(write(tmp_path, GOOD))
    assert found.wind_m_s is None
    np.testing.assert_array_equal(found.clock_s, [21600, 21660, 21780])
    np.testing.assert_array_equal(found.irradiance_w_m2, [0, 12.5, 30])


def test_spaces_a_mark_of_byte_order_and_other_columns_do_no_harm(tmp_path):
    text = "\ufeffremark, time_s, irradiance_w_m2, ambient_c, wind_m_s\n\na, 0, 11, 2, 3\nb, 1, 11, 2, 4\n"
    found = read(write(tmp_path, text))
    assert found.wind_m_s.tolist() == [3, 4]


@pytest.mark.parametrize("offset", ["", "+08:00", "-03:30"])
def test_times_count_from_the_local_midnight_of_the_first_day(tmp_path, offset):
    found = series(tmp_path, f"2015-03-20T06:30:00{offset}", f"2015-03-20T23:59:59{offset}")
    assert found.measured.clock_s.tolist() == [6.5 * 3600, 86399]
    assert found.date == datetime.date(2015, 3, 20)


def test_times_with_offsets_are_turned_to_local_time(tmp_path):
    """22:30 in universal time is half past six of the next day in Taiwan, whatever offset a row is written in."""
    found = series(tmp_path, "2015-03-19T22:30:00Z", "2015-03-20T00:00:00+01:00", offset_h=8.0)
    assert found.measured.clock_s.tolist() == [6.5 * 3600, 7 * 3600]
    assert found.date == datetime.date(2015, 3, 20)
    universal = series(tmp_path, "2015-03-20T00:00:00Z", "2015-03-20T01:00:00Z", offset_h=0.0)
    assert universal.measured.clock_s.tolist() == [0, 3600]


def test_times_of_day_have_no_date(tmp_path):
    found = series(tmp_path, "06:30", "06:30:30", "23:59:59.5")
    assert found.measured.clock_s.tolist() == [23400, 23430, 86399.5]
    assert found.date is None


@pytest.mark.parametrize(
    ("rows", "offset_h", "message"),
    [
        (("2015-03-20T06:30:00Z", "2015-03-20T07:00:00Z"), None, "in universal time, .*give utc_offset_h"),
        (
            ("2015-03-29T01:30:00+01:00", "2015-03-29T03:00:00+02:00"),
            None,
            r"line 3, column time: value '.*\+02:00'; allowed is the offset of the first row, \+0100; or give utc",
        ),
        (("2015-03-20T06:30:00", "2015-03-20T07:00:00"), 8.0, "carry no offset.* utc_offset_h is 8, allowed is null"),
        (("06:30", "2015-03-20T07:00:00"), None, "line 3, column time: .*allowed is .* all have a date, or none"),
        (("0630", "0700"), None, "line 2, column time: value '0630'; allowed is .* a time of day as 06:30"),
        (("23:59", "00:01"), None, "line 3, column time: value '00:01'; allowed is a time after"),
    ],
)
def test_times_that_could_mean_two_things_are_refused(tmp_path, rows, offset_h, message):
    with pytest.raises(UserError, match=message):
        series(tmp_path, *rows, offset_h=offset_h)


def test_a_parquet_file_is_read(tmp_path):
    start = datetime.datetime(2015, 3, 20, 6)
    columns = {
        "time": [start, start + datetime.timedelta(seconds=90)],
        "irradiance_w_m2": [1.0, 20.0],
        "ambient_c": [15, 16],
    }
    pq.write_table(pa.table(columns), tmp_path / "own.parquet")
    found = read(tmp_path / "own.parquet")
    assert found.clock_s.tolist() == [21600, 21690]
    assert found.ambient_c.tolist() == [15, 16]


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
    "a mark of nines": (
        GOOD.replace("12.5", "-999"),
        r"""value '-999'; allowed .* 2000 W/m2; where it means that nothing .*missing=\["-999"\]'""",
    ),
    "numbers as time": (
        GOOD.replace("time_s", "time"),
        r"allowed is a time as .*; a number has a unit, '.*units=\{time_s: s\}'",
    ),
    "in kelvin": (GOOD.replace(",15.2", ",288.4"), r"line 4, column ambient_c: value '288.4'; .* -60 to 60 degC"),
    "back in time": (
        GOOD.replace("21780", "21600"),
        r"line 4, column time_s: value '21600'; .* after .* value '21660'",
    ),
    "twice the same": (
        GOOD.replace("21780", "21660"),
        r"line 4, column time_s: value '21660'; allowed is a time after",
    ),
    "before midnight": (GOOD.replace("21600", "-1"), r"line 2, column time_s: value '-1'; .* from 0 to"),
    "after midnight": (GOOD.replace("21780", "86400"), r"line 4, column time_s: value '86400'; .* has dates"),
    "a cell too few": (GOOD.replace("21660,12.5,15.1", "21660,12.5"), "line 3: 2 values; allowed are 3"),
    "a cell too many": (GOOD.replace("12.5,", "12,5,"), "line 3: 4 values; allowed are 3"),
    "one row": ("\n".join(GOOD.split("\n")[:2]), "1 rows; allowed are 2 and more"),
    "no rows": (GOOD.split("\n")[0], "0 rows"),
    "empty": ("", "empty; allowed is a line of column names"),
    "no such day": (
        "time,irradiance_w_m2,ambient_c\n2015-02-30T00:00:00,1,1\n2015-03-01T00:00:00,1,1\n",
        r"line 2, column time: value '2015-02-30T00:00:00'; allowed is a time as 2015-03-20",
    ),
    "an hour twice": (
        "time,irradiance_w_m2,ambient_c\n2019-10-27T02:55:00,1,1\n2019-10-27T02:00:00,1,1\n",
        r"line 3, .* of the row before, .*; where clocks were put back, .*time_zone=Europe/Berlin",
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
    with pytest.raises(UserError, match=r"/none\.csv: no such file; best matches are: nine\.csv"):
        read(write(tmp_path, GOOD, "nine.csv").with_name("none.csv"))
    with pytest.raises(UserError, match="is a folder"):
        read(tmp_path)
    with pytest.raises(UserError, match="/dev/zero: is no ordinary file"):
        read("/dev/zero")
    with pytest.raises(UserError, match="cannot be opened"):
        read("a" * 5000)
    with pytest.raises(UserError, match="not a readable Parquet file"):
        read(write(tmp_path, GOOD, "own.parquet"))
    (tmp_path / "zeros.csv").write_bytes(b"\x00\x01\x02\x00" + bytes(range(256)))
    with pytest.raises(UserError, match="holds zero bytes"):
        read(tmp_path / "zeros.csv")
    (tmp_path / "own.nc").write_bytes(b"CDF\x01" + bytes(99))
    with pytest.raises(UserError, match="is a netCDF file, which is not read; save it as CSV"):
        read(tmp_path / "own.nc")


def test_a_parquet_row_is_named(tmp_path):
    columns = {"time_s": [0.0, 1.0], "irradiance_w_m2": [1.0, None], "ambient_c": [1.0, 1.0]}
    pq.write_table(pa.table(columns), tmp_path / "own.parquet")
    with pytest.raises(UserError, match="row 2, column irradiance_w_m2: empty"):
        read(tmp_path / "own.parquet")


def test_the_content_of_a_file_enters_the_key(tmp_path):
    path = write(tmp_path, GOOD)
    card = MeasuredWeather(title="own", file=str(path), wind_m_s=1.0, cell_temperature=NoctCells(noct_c=45.0))
    before = settings(card, "own")
    assert settings(card, "own") == before
    write(tmp_path, GOOD.replace("12.5", "12.6"))
    assert settings(card, "own")["file_sha256"] != before["file_sha256"]
    assert MeasuredWeather.model_validate(without_digest(before)) == card


DAYS = "time,irradiance_w_m2,ambient_c\n" + "".join(
    f"2015-03-{day}T{hour:02d}:00:00,{10 * hour},{day}\n" for day in (19, 20, 21) for hour in (6, 12, 18)
)


def test_a_weather_is_one_day_of_its_file(tmp_path):
    path = write(tmp_path, DAYS)
    found = weather_rows(card(path, date="2015-03-20"))
    assert found.clock_s.tolist() == [6 * 3600, 12 * 3600, 18 * 3600]
    assert found.ambient_c.tolist() == [20, 20, 20]
    assert date_of(card(path, date="2015-03-20")) == datetime.date(2015, 3, 20)
    with pytest.raises(
        UserError, match=r"from 2015-03-19 to 2015-03-21, and a weather is one day; .*weather\.date=2015-03-19"
    ):
        weather_rows(card(path))
    with pytest.raises(UserError, match=r"0 rows on date 2015-03-22; it has rows from 2015-03-19 to 2015-03-21"):
        weather_rows(card(path, date="2015-03-22"))


def test_a_file_is_read_once_until_it_changes(tmp_path, monkeypatch):
    path, read_it, asked = write(tmp_path, GOOD), weather_file.of_content, []
    monkeypatch.setattr(weather_file, "of_content", lambda *given: asked.append(given) or read_it(*given))
    first, again = weather_rows(card(path)), weather_rows(card(path))
    assert len(asked) == 1
    np.testing.assert_array_equal(first.ambient_c, again.ambient_c)
    write(tmp_path, GOOD.replace("15.1", "15.9"))
    assert weather_rows(card(path)).ambient_c[1] == 15.9
    assert len(asked) == 2


def test_a_day_is_that_of_local_time(tmp_path):
    """In Taiwan the day of the 20th begins on the 19th of universal time."""
    path = write(tmp_path, DAYS.replace(":00,", ":00Z,"))
    found = weather_rows(card(path, date="2015-03-20", utc_offset_h=8.0))
    assert found.clock_s.tolist() == [2 * 3600, 14 * 3600, 20 * 3600]
    assert found.ambient_c.tolist() == [19, 20, 20]


def test_a_file_of_times_of_day_takes_the_date_it_is_given(tmp_path):
    path = write(tmp_path, GOOD)
    assert date_of(card(path)) is None
    assert date_of(card(path, date="2015-03-20")) == datetime.date(2015, 3, 20)


def test_a_day_without_light_is_refused(tmp_path):
    """A clear day in kW/m2 reaches 1, which is no light in W/m2."""
    path = write(tmp_path, GOOD.replace("12.5", "0.9").replace(",30,", ",1.02,"))
    with pytest.raises(UserError, match=r"own\.csv: column irradiance_w_m2: at most 1\.02 W/m2 .* 10 W/m2\. .*kW/m2"):
        weather_rows(card(path))
    dark = DAYS.replace("2015-03-20T12:00:00,120", "2015-03-20T12:00:00,9").replace(",180,20", ",0,20")
    dark = dark.replace("2015-03-20T06:00:00,60", "2015-03-20T06:00:00,1")
    with pytest.raises(UserError, match="at most 9 W/m2"):
        weather_rows(card(write(tmp_path, dark), date="2015-03-20"))


def load_of(path, text, date=None, **more):
    path.write_text(text, encoding="utf-8")
    return load_rows(MeasuredLoad(title="own", file=str(path), **more), date)


def test_a_load_of_times_of_day_holds_every_day(tmp_path):
    for times in (("time_s", "0", "3600"), ("time", "00:00", "01:00")):
        text = f"{times[0]},power_w\n{times[1]},3\n{times[2]},5\n"
        for date in (None, datetime.date(2015, 3, 20)):
            found = load_of(tmp_path / "load.csv", text, date)
            assert (found.clock_s.tolist(), found.power_w.tolist(), found.repeats) == ([0, 3600], [3, 5], True)
    with pytest.raises(UserError, match="line 2, column power_w: value '-3'"):
        load_of(tmp_path / "load.csv", "time_s,power_w\n0,-3\n")
    with pytest.raises(UserError, match=r"load\.csv: begins 3600 s after midnight; .* must begin at 0 s"):
        load_of(tmp_path / "load.csv", "time_s,power_w\n3600,3\n")


def test_a_load_with_dates_is_that_of_the_weathers_day(tmp_path):
    rows = ("2015-03-19T20:00", "2015-03-20T09:00", "2015-03-20T17:00", "2015-03-21T09:00")
    text = "time,power_w\n" + "".join(f"{row},{number}\n" for number, row in enumerate(rows))
    found = load_of(tmp_path / "load.csv", text, datetime.date(2015, 3, 20))
    assert found.clock_s.tolist() == [-4 * 3600, 9 * 3600, 17 * 3600]
    assert (found.power_w.tolist(), found.repeats) == ([0, 1, 2], False)
    shifted = load_of(
        tmp_path / "load.csv", text.replace(":00,", ":00Z,"), datetime.date(2015, 3, 20), utc_offset_h=-10.0
    )
    assert shifted.clock_s.tolist() == [-14 * 3600, -1 * 3600, 7 * 3600, 23 * 3600][1:]


def test_a_load_of_another_day_is_refused(tmp_path):
    text = "time,power_w\n2015-03-20T00:00,1\n2015-03-21T00:00,2\n"
    with pytest.raises(UserError, match=r"no row on 2015-03-22, .* from 2015-03-20 to 2015-03-21; .*times of day"):
        load_of(tmp_path / "load.csv", text, datetime.date(2015, 3, 22))
    with pytest.raises(UserError, match=r"has dates, rows from 2015-03-20 .*, and the weather has none; date the wea"):
        load_of(tmp_path / "load.csv", text)


def test_a_gap_by_day_is_told_when_planning(tmp_path):
    rows = [
        f"{3600 * hour},{400 if 6 < hour < 19 else 0},15" for hour in range(24) if hour not in (3, 4, 5, 11, 12, 13)
    ]
    path = write(tmp_path, "\n".join(["time_s,irradiance_w_m2,ambient_c", *rows]))
    dark = [said for said in told(card(path), "day.weathers.clear") if "dark" in said]
    assert dark == [
        "no rows for 10800 s from 11:00 on, which count as dark; day.weathers.clear.longest_gap_s=10800 has them "
        "interpolated"
    ]
    assert not [said for said in told(card(path, longest_gap_s=10800.0), "x") if "dark" in said]
