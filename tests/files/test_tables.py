"""Tables as people write them: delimiters, decimal commas, lines above, units, headings; and times."""

import datetime

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from pipeline.errors import UserError
from pipeline.files.cells import Stamp, number
from pipeline.files.clock import clock_of, placed
from pipeline.files.moments import MDY, moment
from pipeline.files.read import table
from pipeline.files.weather import weather_day, weather_rows
from pipeline.record import OwnFile
from pipeline.weather.records import MeasuredWeather, NoctCells

ROWS = [(f"{hour:02d}:00", 100.0 * hour + 0.5, 10.0 + 0.25 * hour) for hour in range(6, 18)]


def card(path, **more):
    return MeasuredWeather(title="own", file=str(path), wind_m_s=1.0, cell_temperature=NoctCells(noct_c=45.0), **more)


def write(folder, text, name="own.csv"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def text(delimiter=",", comma=False, head="time,irradiance_w_m2,ambient_c", above="", below="", rows=ROWS):
    lines = [head.replace(",", delimiter)]
    for time, light, air in rows:
        line = f"{time}\t{light}\t{air}"
        lines.append((line.replace(".", ",") if comma else line).replace("\t", delimiter))
    return above + "\n".join(lines) + "\n" + below


WRITTEN = {
    "commas": text(),
    "semicolons": text(";"),
    "tabs": text("\t"),
    "bars": text("|"),
    "decimal commas": text(";", comma=True),
    "decimal commas and tabs": text("\t", comma=True),
    "spaces": text(" "),
    "comments": text(above="# logger 3\n# on the roof, 2015\n"),
    "headings in a comment": text(head="# time,irradiance_w_m2,ambient_c"),
    "key and value": text(above="Site: roof\nLogger = 3\nSerial,77\n\n"),
    "a line of units": text(head="time,irradiance_w_m2,ambient_c\n[h],[W/m2],[degC]"),
    "units in headings": text(head="time,POA (W/m2),Temp [°C]"),
    "other units": text(
        head="time,POA [kW/m^2],Air temperature (F)",
        rows=[(time, light / 1000.0, air * 1.8 + 32.0) for time, light, air in ROWS],
    ),
    "kelvin": text(head="time,GTI (W/m²),T_amb (K)", rows=[(time, light, air + 273.15) for time, light, air in ROWS]),
    "below": text(below="\nSum,8000,\nWritten by a logger\n"),
    "quoted": text(head='"time","irradiance_w_m2","ambient_c"').replace("06:00", '"06:00"'),
    "windows": text().replace("\n", "\r\n"),
}


@pytest.mark.parametrize("how", WRITTEN)
def test_the_same_table_however_it_is_written(tmp_path, how):
    found = weather_rows(card(write(tmp_path, WRITTEN[how])))
    np.testing.assert_allclose(found.irradiance_w_m2, [row[1] for row in ROWS], rtol=1e-12)
    np.testing.assert_allclose(found.ambient_c, [row[2] for row in ROWS], rtol=1e-9)
    np.testing.assert_array_equal(found.clock_s, 3600.0 * np.arange(6, 18))


def test_an_excel_sheet_is_read(tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.active.title = "notes"
    book.active.append(["Measured on the roof"])
    sheet = book.create_sheet("data")
    sheet.append(["Logger", 3])
    sheet.append([])
    sheet.append(["Time", "POA (W/m2)", "Temp (C)"])
    for hour, (_, light, air) in zip(range(6, 18), ROWS, strict=True):
        sheet.append([datetime.datetime(2015, 3, 20, hour), light, air])
    path = tmp_path / "own.xlsx"
    book.save(path)
    found = weather_day(card(path))
    np.testing.assert_allclose(found.measured.irradiance_w_m2, [row[1] for row in ROWS])
    assert found.date == datetime.date(2015, 3, 20)
    assert "sheet 'data' of 2" in found.said
    with pytest.raises(UserError, match=r"no sheet 'dat'; best matches are: data"):
        weather_rows(card(path, sheet="dat"))
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(UserError, match=r"own\.xlsx: "):
        weather_rows(card(path))


MISTAKES = {
    "no headings": (text(head="")[1:], {}, r"line 1: no line of column names above the numbers"),
    "decimal commas between commas": (
        text(comma=True),
        {},
        r"line 2: 5 values; allowed are 3, one a column; decimal commas .* semicolons",
    ),
    "which plane": (
        text(head="time,Irradiance (W/m2),ambient_c"),
        {},
        r"'Irradiance \(W/m2\)' may be light on the panel or on the horizontal; say which, "
        r"'weather\.columns=\{irradiance_w_m2: \"Irradiance \(W/m2\)\"\}' or 'weather\.columns=\{ghi: ",
    ),
    "two airs": (
        text(head="time,POA,Temp,Air temperature", rows=[(one, two, f"{three},{three}") for one, two, three in ROWS]),
        {},
        r"the columns 'Temp', 'Air temperature' may all be the temperature of the air; say which, "
        r"'weather\.columns=\{ambient_c: \"Temp\"\}'",
    ),
    "fahrenheit": (
        text(rows=[(time, light, 1.8 * air + 32.0) for time, light, air in ROWS]).replace("57.65", "77.5"),
        {},
        r"line \d+, column ambient_c: value '.*'; .*Is it in degrees Fahrenheit\? 'weather\.units=\{ambient_c: F\}'",
    ),
    "fahrenheit in winter": (
        text(rows=[(time, light, 45.0 + hour) for hour, (time, light, _) in enumerate(ROWS)]),
        {},
        r"from 45 to 56 degC; no night is warmer than 43 degC\. Is it in degrees Fahrenheit\?",
    ),
    "kelvin": (
        text(rows=[(time, light, air + 273.15) for time, light, air in ROWS]),
        {},
        r"line 2, column ambient_c: .* Is it in kelvin\? 'weather\.units=\{ambient_c: K\}'",
    ),
    "kilowatts": (
        text(rows=[(time, light / 1000.0, air) for time, light, air in ROWS]),
        {},
        r"at most 1\.7005 W/m2 all day; .* kW/m2\? 'weather\.units=\{irradiance_w_m2: kW/m2\}'",
    ),
    "kilojoules": (
        text(rows=[(time, 3.6 * light, air) for time, light, air in ROWS]),
        {},
        r"line 2, .*Is it an amount in each interval, in kJ/m2 or J/cm2\? 'weather\.units=\{irradiance_w_m2: kJ/m2\}'",
    ),
    "minutes": (
        "time_s,irradiance_w_m2,ambient_c\n" + "".join(f"{10 * row},{row},15\n" for row in range(144)),
        {},
        r"144 rows within 1440 s after midnight; are they minutes\? 'weather\.units=\{time_s: min\}'",
    ),
    "an unknown unit": (text(head="time,POA (langley/h),Temp"), {}, r"unit 'langley/h'; allowed is one of .*w/m2"),
    "a unit that is none": (text(), {"units": {"ambient_c": "reaumur"}}, r"units\.ambient_c is 'reaumur'; .*celsius"),
    "a column that is none": (
        text(),
        {"columns": {"ghi": "GHI"}},
        r"no column 'GHI', which weather\.columns\.ghi names; known are: ambient_c, irradiance_w_m2, time",
    ),
    "underscores": (text().replace("700.5", "7_00"), {}, r"line 3, column irradiance_w_m2: value '7_00'"),
    "other digits": (text().replace("700.5", "７００"), {}, r"line 3, column irradiance_w_m2: value '７００'"),
    "nothing measured": (text().replace("700.5", "---"), {}, r"'weather\.missing=\[\"---\"\]'"),
    "day or month": (
        text(head="date,time,POA,Temp", rows=[(f"03/04/2015,{row[0]}", *row[1:]) for row in ROWS]),
        {},
        r"may begin with the day or the month; say which, '.*time_format=\"%d/%m/%Y %H:%M\"'",
    ),
    "24 o'clock": (
        text(rows=[*ROWS, ("24:00", 0.0, 10.0)]),
        {"label": "start"},
        r"line 14, column time: value '24:00'; .* where a time is the end of its interval, weather\.label=end",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told_with_what_mends_it(tmp_path, mistake):
    content, more, message = MISTAKES[mistake]
    with pytest.raises(UserError, match=message):
        weather_rows(card(write(tmp_path, content), **more))


TIMES = {
    "a date and a time of twelve hours": ("Date,Time", lambda at: f"{at:%m/%d/%Y},{at:%I:%M %p}"),
    "days first": ("Datum,Uhrzeit", lambda at: f"{at:%d.%m.%Y},{at:%H:%M:%S}"),
    "an index of pandas": ("", lambda at: f"{at:%Y-%m-%d %H:%M:%S}"),
    "year, month, day, hour": ("Year,Month,Day,Hour", lambda at: f"{at.year},{at.month},{at.day},{at.hour}"),
    "an hour beside a date": ("date,hour", lambda at: f"{at:%Y-%m-%d},{at.hour}:00"),
    "seconds since 1970": ("timestamp", lambda at: f"{(at - datetime.datetime(1970, 1, 1)).total_seconds():.0f}"),
    "milliseconds since 1970": (
        "timestamp",
        lambda at: f"{1000 * (at - datetime.datetime(1970, 1, 1)).total_seconds():.0f}",
    ),
    "without signs": ("MESS_DATUM", lambda at: f"{at:%Y%m%d%H%M}"),
    "universal": ("time (UTC)", lambda at: f"{at:%Y-%m-%d %H:%M}"),
}


@pytest.mark.parametrize("how", TIMES)
def test_the_same_times_however_they_are_written(tmp_path, how):
    heading, shown = TIMES[how]
    start = datetime.datetime(2015, 6, 20)
    rows = [f"{shown(start + datetime.timedelta(hours=hour))},{10 * (hour % 24)},15" for hour in range(48)]
    path = write(tmp_path, "\n".join([f"{heading},POA,Temp", *rows]))
    more = {"utc_offset_h": 0.0} if "1970" in how or how == "universal" else {}
    found = weather_day(card(path, date="2015-06-20", **more))
    assert found.measured.clock_s.tolist() == [3600.0 * hour for hour in range(24)]
    assert found.date == start.date()
    assert found.measured.irradiance_w_m2.tolist() == [10.0 * hour for hour in range(24)]


def test_hours_of_a_day(tmp_path):
    for first in (0, 1):
        rows = [f"{hour + first},{10 * hour},15" for hour in range(24)]
        found = weather_rows(card(write(tmp_path, "\n".join(["hour,POA,Temp", *rows]))))
        assert found.clock_s.tolist() == [3600.0 * hour for hour in range(24)]


def test_what_is_stated_is_not_guessed(tmp_path):
    minutes = MISTAKES["minutes"][0]
    found = weather_rows(card(write(tmp_path, minutes), units={"time_s": "min"}))
    assert found.clock_s[-1] == 1430 * 60.0
    assert weather_rows(card(write(tmp_path, minutes), units={"time_s": "s"})).clock_s[-1] == 1430.0
    kilowatts = write(tmp_path, MISTAKES["kilowatts"][0])
    assert weather_rows(card(kilowatts, units={"irradiance_w_m2": "kW/m2"})).irradiance_w_m2.max() == 1700.5


def test_what_means_nothing_is_a_gap(tmp_path):
    path = write(tmp_path, text().replace(",700.5", ",-999"))
    found = weather_rows(card(path, missing=[-999]))
    assert 7 * 3600.0 not in found.clock_s
    assert len(found.clock_s) == len(ROWS) - 1


DAYS = ("2015-06-20", "2015-06-21", "2015-06-22")


def days(change=lambda line: line, head="time,irradiance_w_m2,ambient_c"):
    lines = [f"{day}T{hour:02d}:00,{50 * hour},15" for day in DAYS for hour in range(24)]
    return "\n".join([head, *map(change, lines)]) + "\n"


def test_only_the_rows_of_the_day_are_judged(tmp_path):
    def spoilt(line):
        if line.startswith("2015-06-20T05"):
            return "2015-06-20T05:00,dim,999"
        if line.startswith("2015-06-20T07"):
            return "yesterday,1,2"
        return "1,2" if line.startswith("2015-06-20T09") else line

    path = write(tmp_path, days(spoilt))
    assert len(weather_rows(card(path, date="2015-06-21")).clock_s) == 24
    with pytest.raises(UserError, match=r"line 9, column time: value 'yesterday'; allowed is a time as"):
        weather_rows(card(path, date="2015-06-20"))


def test_ends_of_intervals(tmp_path):
    """The last row of a day is that of 24:00, which belongs to it."""
    lines = [f"2015-06-20 {hour:02d}:00,{10 * hour},15" for hour in range(1, 25)]
    path = write(tmp_path, "\n".join(["time,irradiance_w_m2,ambient_c", *lines]))
    found = weather_day(card(path))
    assert found.measured.clock_s.tolist() == [3600.0 * hour for hour in range(24)]
    assert "24:00 occurs: times are the ends of their intervals" in found.said
    assert found.date == datetime.date(2015, 6, 20)
    shifted = weather_rows(card(write(tmp_path, days()), date="2015-06-21", label="end"))
    assert shifted.irradiance_w_m2[-1] == 0.0  # the row of midnight
    middle = weather_rows(card(write(tmp_path, days()), date="2015-06-21", label="middle"))
    assert middle.clock_s[0] == 1800.0


def test_gaps_are_judged_by_the_files_own_step(tmp_path):
    from pipeline.weather.measured import DARK, INTERPOLATED, gaps, longest_gap_s

    def without(*missing):
        lines = days().splitlines(keepends=True)
        path = write(tmp_path, "".join(line for line in lines if not line.startswith(missing)))
        own = card(path, date="2015-06-21")
        found = weather_rows(own)
        return [gap.filled for gap in gaps(found, longest_gap_s(own, found))]

    noon = [f"2015-06-21T{hour}" for hour in (12, 13, 14)]
    assert without(noon[0]) == without(*noon[:2]) == [INTERPOLATED]
    assert without(*noon) == [DARK]


def test_a_typical_year_of_several_years(tmp_path):
    rows = []
    for month in range(1, 13):
        year = 1990 + (7 * month) % 11
        rows += [f"{year}-{month:02d}-{day:02d}T{hour:02d}:00,{50 * hour},15" for day in (20, 21) for hour in range(24)]
    path = write(tmp_path, "\n".join(["time,irradiance_w_m2,ambient_c", *rows]))
    for date in ("2015-06-21", "1999-06-21"):
        found = weather_day(card(path, date=date))
        assert len(found.measured.clock_s) == 24
        assert found.date == datetime.date.fromisoformat(date)
    with pytest.raises(UserError, match="0 rows on date 2015-06-22"):
        weather_rows(card(path, date="2015-06-22"))
    with pytest.raises(UserError, match=r"0 rows on date 2014-06-21; it has that day of 2015-06-21; choose it"):
        weather_rows(card(write(tmp_path, days()), date="2014-06-21"))


def test_a_typical_year_in_universal_time_has_stray_hours_at_the_ends_of_its_months(tmp_path):
    rows = []
    start = datetime.datetime(2015, 1, 1)
    for hour in range(8760):
        at = start + datetime.timedelta(hours=hour)
        rows.append(f"{1990 + (7 * at.month) % 11}{at:%m%d:%H%M},{50 * ((at.hour + 1) % 24)},15")
    path = write(tmp_path, "\n".join(["time(UTC),G(i),T2m", *rows]))
    for date in ("2015-06-21", "2015-06-01", "2015-02-28"):
        found = weather_day(card(path, date=date, utc_offset_h=1.0))
        assert len(found.measured.clock_s) >= 23
        assert any("a typical year" in one for one in found.said)


def test_a_download_of_a_day_by_the_ends_of_intervals(tmp_path):
    rows = [f"2015-06-20 {hour:02d}:00,{50 * hour},15" for hour in range(24)]
    found = weather_day(card(write(tmp_path, "\n".join(["period_end,POA,Temp", *rows]))))
    assert found.date == datetime.date(2015, 6, 20)
    assert found.measured.clock_s.tolist() == [3600.0 * hour for hour in range(23)]


def test_daylight_saving(tmp_path):
    """The clock of Berlin shows 02:00 twice on 25 October 2015 and never on 29 March."""
    hours = ["00:00", "01:00", "02:00", "02:00", "03:00", "04:00", "12:00"]
    path = write(tmp_path, "time,irradiance_w_m2,ambient_c\n" + "".join(f"2015-10-25 {one},50,15\n" for one in hours))
    found = weather_rows(card(path, time_zone="Europe/Berlin", date="2015-10-25"))
    # The day is that of the time that holds at its noon: it begins at one o'clock of summer time.
    assert found.clock_s.tolist() == [3600.0 * hour for hour in (0, 1, 2, 3, 4, 12)]
    own = OwnFile(file=str(path), time_zone="Europe/Berlin")
    clock = placed(clock_of(table(own), own), "Europe/Berlin")
    assert (clock.offset_s / 3600.0).tolist() == [2, 2, 2, 1, 1, 1, 1]
    spring = write(tmp_path, "time,irradiance_w_m2,ambient_c\n2015-03-29 01:00,50,15\n2015-03-29 02:30,50,15\n")
    with pytest.raises(UserError, match=r"line 3, column time: value '2015-03-29 02:30'"):
        weather_rows(card(spring, time_zone="Europe/Berlin"))


@pytest.mark.parametrize(
    ("written", "wall"),
    [
        ("2015-03-20T06:30:00", "2015-03-20T06:30:00"),
        ("2015-03-20 06:30", "2015-03-20T06:30:00"),
        ("2015/3/20 6:30", "2015-03-20T06:30:00"),
        ("20.03.2015 06:30", "2015-03-20T06:30:00"),
        ("20.3.2015, 06:30:15", "2015-03-20T06:30:15"),
        ("20150320:0630", "2015-03-20T06:30:00"),
        ("201503200630", "2015-03-20T06:30:00"),
        ("20150320T063015", "2015-03-20T06:30:15"),
        ("20/03/2015 06:30 PM", "2015-03-20T18:30:00"),
        ("2015-03-20 24:00", "2015-03-21T00:00:00"),
        ("2015-03-20", "2015-03-20T00:00:00"),
    ],
)
def test_times_as_people_write_them(written, wall):
    expected = (datetime.datetime.fromisoformat(wall) - datetime.datetime(1970, 1, 1)).total_seconds()
    assert moment(written).wall_s == expected


def test_times_that_are_none():
    for bad in (
        "2015-02-30",
        "25:00",
        "06:61",
        "0630",
        "spring",
        "",
        "1:30:61",
        "20.03.15",
        None,
        7,
        True,
        "99999-01-01",
    ):
        assert moment(bad) is None
    assert moment("03/20/2015", MDY).wall_s == moment("2015-03-20").wall_s
    assert moment("2015-03-20T06:30+02:00").offset_s == 7200.0
    assert moment("06:30").dated is False


def test_numbers_are_strict():
    assert number("1,5", ",") == 1.5
    assert number("1.234,5", ",") == 1234.5
    for bad in ("1_000", "١٢", "", "nan", "inf", "1:30", True, None, "0x10", "1,5"):
        assert number(bad) is None


def test_times_of_a_parquet_file_beyond_all_calendars(tmp_path):
    far = pa.array([6_000_000_000_000_000_000, 6_000_000_000_000_001_000], type=pa.timestamp("us", tz="UTC"))
    pq.write_table(
        pa.table({"time": far, "irradiance_w_m2": [1.0, 2.0], "ambient_c": [1.0, 1.0]}), tmp_path / "own.parquet"
    )
    with pytest.raises(UserError, match=r"row 1, column time: .*; allowed is a time as"):
        weather_rows(card(tmp_path / "own.parquet"))


@pytest.mark.parametrize(
    "value",
    [
        Stamp(-64_092_211_200.0, universal=True),  # the year -61, which no date has
        Stamp(-62_135_596_800.0, universal=False),
        Stamp(253_402_300_799.0, universal=True),
        datetime.datetime(1, 1, 1, tzinfo=datetime.UTC),
        datetime.datetime(9999, 12, 31, 23),
        datetime.date(1799, 12, 31),
        "1677-09-20 00:00",
        "9999-12-31T23:00+14:00",
    ],
)
def test_a_time_outside_the_years_that_dates_can_be_reckoned_in_is_none(value):
    assert moment(value) is None
    assert moment("0001-01-01", time_format="%Y-%m-%d") is None


@pytest.mark.parametrize("value", [datetime.date(1800, 1, 1), datetime.datetime(2200, 12, 31, 23, 59), "12:30"])
def test_a_time_within_is_one(value):
    assert moment(value) is not None


@pytest.mark.parametrize("year", [-9000, 1, 1677, 9999])
def test_a_parquet_file_of_an_impossible_year_is_refused(year, tmp_path):
    micro = int((year - 1970) * 365.2425 * 86400e6)
    times = pa.array([micro + hour * 3_600_000_000 for hour in range(24)], pa.int64()).cast(
        pa.timestamp("us", tz="UTC")
    )
    columns = {"time": times, "irradiance_w_m2": pa.array([100.0] * 24), "ambient_c": pa.array([20.0] * 24)}
    pq.write_table(pa.table(columns), tmp_path / "own.parquet")
    with pytest.raises(UserError, match=r"own\.parquet: row 1, column time: value '?-?\d+") as told:
        weather_day(card(tmp_path / "own.parquet", utc_offset_h=14.0))
    assert "Stamp" not in str(told.value)
