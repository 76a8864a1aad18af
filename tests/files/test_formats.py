"""Weather files as they are downloaded: what they are taken for, and the same light from every one of them."""

import bz2
import gzip
import lzma
import zipfile

import pytest

from pipeline.errors import UserError
from pipeline.files.pvlib_files import FORMATS, taken_for
from pipeline.files.weather import told, weather_day
from pipeline.weather.records import MeasuredWeather, NoctCells
from tests.files import makers

SURFACE = {"tilt_deg": 30.0, "azimuth_deg": 180.0, "albedo": 0.2}
PLACE = {
    "latitude_deg": makers.LATITUDE,
    "longitude_deg": makers.LONGITUDE,
    "altitude_m": makers.ALTITUDE,
    "utc_offset_h": makers.OFFSET_H,
}
DAY = "2015-06-20"
HORIZONTAL = [name for name in makers.MADE if name != "pvgis_hourly"]


def card(path, **more):
    given = {"date": DAY, "surface": SURFACE, "ambient_c": 20.5, **more}
    return MeasuredWeather(title="own", file=str(path), wind_m_s=2.5, cell_temperature=NoctCells(noct_c=45.0), **given)


def written(folder, name):
    make, file = makers.MADE[name]
    path = folder / file
    path.write_text(make(), encoding="utf-8")
    return path


def energy_wh_m2(path, **more):
    found = weather_day(card(path, **more)).measured
    return float(found.irradiance_w_m2.sum()) * found.step_s / 3600.0


@pytest.mark.parametrize("name", HORIZONTAL)
def test_every_format_gives_the_days_light(tmp_path, name):
    """By the hour, by five minutes, by the minute; universal and local times; starts, middles and ends of intervals."""
    path = written(tmp_path, name)
    assert energy_wh_m2(path, place=PLACE) == pytest.approx(6660.0, rel=0.01)
    assert any(one.startswith("taken for ") for one in told(card(path, place=PLACE)))
    found = weather_day(card(path, place=PLACE)).measured
    assert found.ambient_c == pytest.approx(20.5)
    # Noon is where the light is highest, wherever the labels stand.
    noon = found.clock_s[found.irradiance_w_m2 > 0.98 * found.irradiance_w_m2.max()] + found.step_s / 2
    assert noon.mean() == pytest.approx(12 * 3600.0, abs=1800.0)


@pytest.mark.parametrize("name", ["epw", "psm4"])
def test_a_format_that_says_its_place_needs_none(tmp_path, name):
    path = written(tmp_path, name)
    assert energy_wh_m2(path) == pytest.approx(energy_wh_m2(path, place=PLACE), rel=1e-9)


@pytest.mark.parametrize("name", makers.MADE)
def test_the_reader_can_be_named(tmp_path, name):
    path = written(tmp_path, name)
    assert energy_wh_m2(path, format=name, place=PLACE) == energy_wh_m2(path, place=PLACE)


def test_the_named_reader_refuses_another_format(tmp_path):
    path = written(tmp_path, "epw")
    with pytest.raises(UserError, match=r"own\.epw: format is tmy3, and pvlib's reader refuses it .* format=csv"):
        weather_day(card(path, format="tmy3"))
    path.write_text(makers.epw()[:300])
    with pytest.raises(UserError, match=r"was taken for EPW, but pvlib's reader refuses it .*cut short"):
        weather_day(card(path))
    with pytest.raises(UserError, match=r"is EPW, which says itself how it is written; leave time_format out"):
        weather_day(card(path, time_format="%d"))


def test_light_on_the_tilted_plane_is_taken_as_it_is(tmp_path):
    path = written(tmp_path, "pvgis_hourly")
    found = weather_day(card(path, utc_offset_h=-7.0, surface=None))
    assert found.measured.irradiance_w_m2.max() == pytest.approx(makers.light(11.5)[0], abs=0.01)
    assert found.said[-1] == "light on the panel as the file has it"


def test_the_same_typical_year_as_json(tmp_path):
    path = tmp_path / "tmy.json"
    path.write_text(makers.pvgis_tmy_json())
    other = written(tmp_path, "pvgis_tmy")
    assert energy_wh_m2(path, place=PLACE) == energy_wh_m2(other, place=PLACE)
    assert "a typical year: 20 June stands there as 2012-06-20" in told(card(path, place=PLACE))


def test_all_that_is_missing_is_asked_for_in_one_message(tmp_path):
    path = written(tmp_path, "cams")
    with pytest.raises(UserError) as refused:
        weather_day(card(path, surface=None, date=None, ambient_c=None), "day.weathers.clear")
    for word in (
        "'day.weathers.clear.surface={tilt_deg: 30, azimuth_deg: 180, albedo: 0.2}'",
        "utc_offset_h=-7",
        "day.weathers.clear.ambient_c=20",
        "day.weathers.clear.date=2015-06-21",
    ):
        assert word in str(refused.value)


PACKINGS = {
    "gz": gzip.compress,
    "bz2": bz2.compress,
    "xz": lzma.compress,
}


@pytest.mark.parametrize("packing", PACKINGS)
def test_a_packed_file_is_read(tmp_path, packing):
    path = tmp_path / f"own.epw.{packing}"
    path.write_bytes(PACKINGS[packing](makers.epw().encode()))
    assert energy_wh_m2(path) == energy_wh_m2(written(tmp_path, "epw"))
    path.write_bytes(PACKINGS[packing](makers.epw().encode())[:300])
    with pytest.raises(UserError, match=r"cannot be unpacked .*; was it copied whole\?"):
        weather_day(card(path))


def test_a_zip_archive_holds_one_file_or_says_which(tmp_path):
    path = tmp_path / "own.zip"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("one.epw", makers.epw())
    assert energy_wh_m2(path) == energy_wh_m2(written(tmp_path, "epw"))
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("readme.txt", "words")
    with pytest.raises(UserError, match=r"holds 2 files, one\.epw, readme\.txt; choose one, sheet=NAME"):
        weather_day(card(path))
    assert energy_wh_m2(path, sheet="one.epw") > 0.0
    with pytest.raises(UserError, match=r"holds no 'two\.epw'; best matches are: one\.epw"):
        weather_day(card(path, sheet="two.epw"))


def test_every_encoding_is_read(tmp_path):
    text = makers.open_meteo()
    path = tmp_path / "own.csv"
    found = set()
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"):
        path.write_bytes(text.encode(encoding))
        found.add(energy_wh_m2(path))
    assert len(found) == 1


OF_OTHER_PROGRAMS = {
    "MATLAB file": b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + bytes(90),
    "BioLogic .mpr file": b"BIO-LOGIC MODULAR FILE\x1a" + bytes(40),
    "Neware .nda file": b"NEWARE" + bytes(40),
    "Access database": b"\x00\x01\x00\x00Standard Jet DB\x00" + bytes(40),
    "SQLite database": b"SQLite format 3\x00" + bytes(40),
    "netCDF or HDF5 file": b"\x89HDF\r\n\x1a\n" + bytes(40),
    "holds zero bytes": bytes(range(256)) * 4,
    "holds control characters": bytes(range(1, 32)) * 9,
}


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("kind", OF_OTHER_PROGRAMS)
def test_files_of_other_programs_are_told_by_what_they_are(tmp_path, kind, packed):
    path = tmp_path / "own.csv"
    data = OF_OTHER_PROGRAMS[kind]
    path.write_bytes(gzip.compress(data) if packed else data)
    with pytest.raises(UserError, match=kind):
        weather_day(card(path))


def test_a_table_may_begin_with_the_name_of_what_wrote_it(tmp_path):
    path = tmp_path / "own.csv"
    path.write_text("MATLAB export of 2024\n" + makers.open_meteo())
    plain = tmp_path / "plain.csv"
    plain.write_text(makers.open_meteo())
    assert energy_wh_m2(path) == energy_wh_m2(plain)


TABLES = {
    "pvwatts": {"place": PLACE},
    "open_meteo": {},
    "solargis": {"place": PLACE},
    "solcast": {"place": PLACE},
    "nasa_power": {"place": PLACE},
    "dwd": {
        "place": PLACE,
        "time_zone": "UTC",
        "columns": {"ghi": "GS_10", "dhi": "DS_10"},
        "units": {"ghi": "J/cm2", "dhi": "J/cm2"},
    },
}


@pytest.mark.parametrize("name", TABLES)
def test_tables_of_other_services_are_read(tmp_path, name):
    path = tmp_path / f"{name}.csv"
    path.write_text(getattr(makers, name)(), encoding="utf-8")
    assert weather_day(card(path, **{**TABLES[name], "date": "2015-06-21"})).measured.irradiance_w_m2.max() > 780.0
    assert energy_wh_m2(path, **{**TABLES[name], "date": "2015-06-21"}) == pytest.approx(6300.0, rel=0.1)


def test_times_that_are_taken_for_local_and_are_not_are_refused(tmp_path):
    path = tmp_path / "dwd.csv"
    path.write_text(makers.dwd())
    more = {key: value for key, value in TABLES["dwd"].items() if key != "time_zone"}
    with pytest.raises(UserError, match=r"\d+ % of the day's light comes while the sun is down; .*time_zone"):
        weather_day(card(path, **more))


def test_no_file_is_taken_for_two_formats():
    for make, _ in makers.MADE.values():
        lines = make().splitlines()[:120]
        assert sum(known.tells(lines) for known in FORMATS) == 1
    assert taken_for(["time,ghi", "2015-06-20,1"]) is None
    assert taken_for([]) is None
