"""The steps of a day one after the other, on files of one's own: what is written, and written again alike."""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.experiments.days.numbers import DAY_NUMBERS, WEATHER_NUMBERS
from pipeline.kernel import registry
from pipeline.kernel.digest import of_file
from pipeline.kernel.draft import drafts
from tests import making

SOURCES = {"weather": "weather/clear", "daylight": "daylight/clear", "day": "day/clear/cv_reflex"}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A short day of one's own, with two gaps and a load of one's own; made twice."""
    folder = tmp_path_factory.mktemp("day")
    rows = [f"{21600 + 60 * n},{500 + 5 * n},20" for n in range(30) if n != 1] + ["27000,700,21", "27060,700,21"]
    (folder / "sun.csv").write_text("\n".join(["time_s,irradiance_w_m2,ambient_c", *rows]))
    (folder / "load.csv").write_text("time_s,power_w\n0,4\n22800,8\n")
    words = [
        "weather@day.weathers.clear=measured", f"day.weathers.clear.file={folder / 'sun.csv'}",
        "load@day.load=measured", f"day.load.file={folder / 'load.csv'}", "~day.weathers.half_cloudy",
        "~day.weathers.overcast", "day.modes=[cv_reflex]", "modes.cv_reflex.frequency_hz=20",
        "battery=lead_acid_12v18ah",
    ]  # fmt: skip
    nodes = {node.name: node for node in drafts(study_from(compose_tree(words)))}
    found = []
    for turn in ("first", "again"):
        places = {"engine": folder}
        for name in ("panel", "weather/clear", "daylight/clear", "day/clear/cv_reflex"):
            places[name] = folder / turn / name.replace("/", "-")
            node = nodes[name]
            inputs = making.inputs({name: places[name] for name in node.inputs})
            step = import_module(registry.module(node.step))
            step.run(node.settings, inputs, making.output(node.step, places[name]))
        found.append(places)
    return found


def read(places, kind, table):
    return making.inputs(places).table(SOURCES[kind], table)


def test_every_artefact_is_written_and_the_same_again(made):
    first, again = made
    for kind, source in SOURCES.items():
        for table, declared in registry.steps()[kind].tables.items():
            read(first, kind, table)
            assert of_file(first[source] / declared.file) == of_file(again[source] / declared.file)


def test_the_gap_is_told_and_dark(made):
    found = read(made[0], "weather", "quantities")
    numbers = dict(zip(found["quantity"], found["value"], strict=True))
    assert (numbers["dark_gaps"], numbers["dark_gap_s"]) == (1, 27000 - (21600 + 30 * 60))
    told = read(made[0], "weather", "gaps")
    assert told["filled"].tolist() == ["interpolated", "dark"]
    assert told["clock_s"].tolist() == [21660, 23400]
    light = read(made[0], "daylight", "daylight")
    dark = light["irradiance_w_m2"] == 0
    assert light["interval_s"][dark].sum() == pytest.approx(numbers["dark_gap_s"])
    assert light["battery_w"][dark].max() == 0.0


def test_the_load_is_that_of_the_file(made):
    light = read(made[0], "daylight", "daylight")
    np.testing.assert_array_equal(light["load_w"], np.where(light["clock_s"] < 22800, 4.0, 8.0))


def test_the_tracker_draws_nearly_all_and_never_more(made):
    light = read(made[0], "daylight", "daylight")
    assert (light["tracked_w"] <= light["panel_w"]).all()
    assert np.sum(light["tracked_w"] * light["interval_s"]) > 0.98 * np.sum(light["panel_w"] * light["interval_s"])


def test_the_switches_tell_of_the_gap(made):
    found = read(made[0], "day", "switching")
    assert found["after"].tolist() == ["mode_1", "off", "mode_1"]
    assert found["clock_s"] == pytest.approx([21600, 21600 + 30 * 60, 27000])
    trace = read(made[0], "day", "trace")
    assert trace["soc"][-1] > 0.2
    assert trace["charge_w"][trace["state"] == "off"].max() < 1e-9


def test_the_vocabularies_cover_the_numbers(made):
    for kind, numbers in (("weather", WEATHER_NUMBERS), ("day", DAY_NUMBERS)):
        assert set(read(made[0], kind, "quantities")["quantity"]) == numbers.names({})
