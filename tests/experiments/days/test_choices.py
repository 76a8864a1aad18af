"""Weather, loads and days in the configuration: every option composes, every mistake is told before anything runs."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

import pytest

from pipeline.config.compose import compose_tree, options
from pipeline.config.study import study_from
from pipeline.errors import UserError
from pipeline.kernel.draft import drafts
from pipeline.kernel.places import PROJECT

WEATHERS = ("clear", "half_cloudy", "overcast")
OWN = "weather@day.weathers.clear=measured"


@cache
def study(*words):
    return study_from(compose_tree(words))


def nodes(*words):
    return drafted(study(*words))


def drafted(made):
    return {node.name: node for node in drafts(made)}


@pytest.mark.parametrize("name", [name for name in options("weather") if name != "measured"])
def test_every_weather_has_its_sources(name):
    made = study(f"weather={name}")
    of_weather = {path: source for path, source in made.sources.items() if path.startswith("weather.")}
    assert of_weather
    assert all(source.ref for source in of_weather.values())


@pytest.mark.parametrize("name", options("cell_temperature"))
def test_every_model_of_the_cells_goes_with_a_day(name):
    made = study(f"cell_temperature@day.weathers.clear.cell_temperature={name}")
    assert made.day.weathers["clear"].cell_temperature.kind == name
    assert made.day.weathers["overcast"].cell_temperature.kind == "faiman"


@pytest.mark.parametrize("name", [name for name in options("load") if name != "measured"])
def test_every_load_goes_with_a_day(name):
    assert study(f"load@day.load={name}").day.load.title


def test_the_nodes_of_the_days():
    made = nodes()
    assert {name for name in made if name.startswith("weather/")} == {
        f"weather/{one}" for one in ("clear", "half_cloudy", "overcast")
    }
    assert made["daylight/clear"].inputs == {"panel": "panel", "weather/clear": "weather/clear"}
    assert made["day/clear/cc_cv"].inputs == {"engine": "engine", "daylight/clear": "daylight/clear"}
    assert made["day/clear/cv_reflex"].inputs["search"] == "search"
    assert "day/overcast/cv_pulse" in made


def test_modes_and_weathers_can_be_chosen():
    made = nodes("day.modes=[cc_cv]", "~day.weathers.overcast")
    assert {name for name in made if name.startswith("day/")} == {"day/clear/cc_cv", "day/half_cloudy/cc_cv"}


def test_a_nickel_battery_can_have_a_day():
    parts = ("+panel=kc65t", "+weather=constant", "+converter=fixed_efficiency", "+load=master_system", "+day=taichung")
    made = nodes("study=nicd_grnn", *parts, "modes.run=[constant_4c,plain_rule]")
    assert {name for name in made if name.startswith("day/clear")} == {"day/clear/constant_4c", "day/clear/plain_rule"}


def test_a_study_without_days_draws_none():
    made = nodes("~day")
    assert not {"weather", "daylight", "day"} & {node.step for node in made.values()}
    assert "figure/days_energy" not in made


@pytest.mark.parametrize(
    ("word", "changed"),
    [
        ("day.weathers.clear.linke_turbidity=3.0", {"weather/clear"}),
        ("day.weathers.clear.title=bright", set()),
        ("day.load.hours=[{from_h: 0, power_w: 2}]", {f"daylight/{one}" for one in WEATHERS}),
        (
            "battery.thermal.heat_capacity_j_k=2200",
            {f"day/{one}/{mode}" for one in WEATHERS for mode in ("cc_cv", "cv_pulse", "cv_reflex")},
        ),
        ("modes.cv_pulse.charge_share=0.8", {f"day/{one}/cv_pulse" for one in WEATHERS}),
        ("weather.cell_temperature_c=45", set()),
    ],
)
def test_what_a_change_touches(word, changed):
    before, after = nodes(), nodes(word)
    own = {name for name in before if before[name].step in ("weather", "daylight", "day")}
    assert {name for name in own if before[name].settings != after[name].settings} == changed


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["day.weathers.clear.linke_turbidity=0.5"], r"linke_turbidity: .*allowed is 1 or more"),
        (["day.weathers.clear.date=2015-02-30"], r"date is '2015-02-30'; it must be a day as YYYY-MM-DD"),
        (["day.weathers.clear.date=2015-W12-5"], r"date is '2015-W12-5'; it must be a day as YYYY-MM-DD"),
        (
            ["day.weathers.clear.place.longitude_deg=-100"],
            r"utc_offset_h is 8 h at longitude_deg -100, .* allowed are 4 h",
        ),
        (["day.weathers.clear.place.latitude_deg=95"], r"place\.latitude_deg: .*allowed is 90 or less"),
        (["day.weathers.clear.interval_s=7"], r"interval_s is 7 s; it must divide a day"),
        (["day.weathers.half_cloudy.clouds.transmittance=0.9"], r"transmittance x \(1 \+ spread\) is 1.26"),
        (["day.weathers.clear.air.highest_c=10"], r"highest_c is 10 degC; it must not lie below lowest_c, 16"),
        (["day.weathers.clear.cell_temperature.kind=nocct"], r"cell_temperature.*nocct"),
        (["day.modes=[cc_cv,cv_reflx]"], r"day\.modes: no mode 'cv_reflx' among those that are run; .*cv_reflex"),
        (["day.initial_soc=1.2"], r"day\.initial_soc: .*less than 1"),
        (["day.initial_soc=0.995"], r"day\.initial_soc: 0\.995 does not go with modes\.cc_cv\..*soc"),
        (["day.switching.stop_power_w=5"], r"stop_power_w is 5 W; it must not lie above start_power_w, 2 W"),
        (["day.load.hours=[{from_h: 3, power_w: 1}]"], r"hours begin at 3 h; the first row must begin at 0"),
        (["load@day.load=mastersystem"], r"no conf/load/mastersystem\.yaml; .*master_system"),
        (["day.longest_hours=3"], r"day has no key 'longest_hours'; .*longest_h"),
    ],
)
def test_a_mistake_is_named(words, message):
    with pytest.raises(UserError, match=message):
        study(*words)


def test_a_file_is_looked_at_before_anything_runs(tmp_path):
    file = tmp_path / "own.csv"
    words = [OWN, f"day.weathers.clear.file={file}"]
    with pytest.raises(UserError, match=r"day\.weathers\.clear\.file: .*own\.csv: no such file"):
        study_from(compose_tree(words))
    file.write_text("time_s,irradiance_w_m2,ambient_c\n0,1,1\n60,5000,1\n")
    with pytest.raises(UserError, match=r"clear\.file: .*line 3, column irradiance_w_m2: value '5000'; .*to 2000 W/m2"):
        study_from(compose_tree(words))
    file.write_text("time_s,irradiance_w_m2,ambient_c\n0,1,1\n60,500,1\n")
    made = study_from(compose_tree(words))
    before = drafted(made)["weather/clear"].settings
    file.write_text("time_s,irradiance_w_m2,ambient_c\n0,1,1\n60,600,1\n")
    assert drafted(made)["weather/clear"].settings != before


def test_a_load_with_dates_must_be_that_of_every_day(tmp_path):
    sun, load = tmp_path / "sun.csv", tmp_path / "load.csv"
    sun.write_text("time,irradiance_w_m2,ambient_c\n2015-03-21T06:00,1,1\n2015-03-21T06:01,500,1\n")
    load.write_text("time,power_w\n2015-03-20T00:00,3\n2015-03-20T09:00,5\n")
    words = ["load@day.load=measured", f"day.load.file={load}"]
    found = {name: node.settings["date"] for name, node in nodes(*words).items() if node.step == "daylight"}
    assert found == {f"daylight/{name}": "2015-03-20" for name in WEATHERS}
    assert nodes()["daylight/clear"].settings["date"] is None
    with pytest.raises(UserError, match=r"day\.load\.file: .*load\.csv: no row on 2015-03-21, the day of the weather"):
        study(*words, OWN, f"day.weathers.clear.file={sun}")
    with pytest.raises(UserError, match=r"day\.weathers\.clear\.file: .*0 rows on date 2015-03-22"):
        study(OWN, f"day.weathers.clear.file={sun}", "day.weathers.clear.date=2015-03-22")


@pytest.mark.parametrize(
    ("words", "path"),
    [([OWN], "day.weathers.clear"), (["load@day.load=measured"], "day.load"), (["weather=measured"], "weather")],
)
def test_a_file_must_be_named(words, path):
    with pytest.raises(UserError, match=rf"{path}\.file: no file is named; .* {path}\.file=FILE"):
        study_from(compose_tree(words))


def test_the_charges_of_a_study_can_have_any_weather_too():
    settings = nodes("weather=half_cloudy_taichung")["supply"].settings["weather"]
    assert settings["kind"] == "cloudy_sky"
    assert nodes()["supply"].settings["weather"] == {
        "kind": "constant",
        "title": "constant 1000 W/m2, 25 degC",
        "irradiance_w_m2": 1000.0,
        "cell_temperature_c": 25.0,
    }


def test_records_import_nothing_heavy():
    code = (
        "import sys, pipeline.weather.records, pipeline.bus.records, pipeline.day.records\n"
        "print([m for m in ('numba', 'scipy', 'pvlib', 'matplotlib', 'pandas', 'numpy') if m in sys.modules])"
    )
    environment = {**os.environ, "PYTHONPATH": str(PROJECT / "src")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
