from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from pydantic import ValidationError

from pipeline.objective.records import ReflexFrequency, Waveform
from pipeline.search.registry import settings_from
from pipeline.taguchi.arrays import Design
from tests.cards import with_sources

CONF = Path(__file__).parents[2] / "conf"
READERS = {
    "objective": lambda values: ReflexFrequency(**values),
    "search": settings_from,
    "design": lambda values: Design(**values),
}
SECTIONS = {f"solar_reflex/{name}": (name, with_sources(name)) for name in ("objective", "design")} | {
    f"search/{path.stem}": ("search", yaml.safe_load(path.read_text()))
    for path in sorted((CONF / "search").glob("*.yaml"))
}


def numbers(values, path=()):
    if isinstance(values, dict):
        if set(values) == {"from", "value"}:
            return
        for key, value in values.items():
            yield from numbers(value, (*path, key))
    elif isinstance(values, list) or (isinstance(values, int | float) and not isinstance(values, bool)):
        yield path, values


def source_of(sources, path):
    for key in path:
        sources = sources[key]
        if "kind" in sources:
            return sources
    raise KeyError(path)


def range_of(sources, path):
    for key in path:
        sources = sources.get(key, {})
    return sources.get("range")


@pytest.mark.parametrize("name", SECTIONS)
def test_every_number_has_a_source(name):
    kind, values = SECTIONS[name][0], dict(SECTIONS[name][1])
    sources = values.pop("sources")
    READERS[kind](values)
    for key, value in numbers(values):
        source = source_of(sources, key)
        assert source["kind"] in {"published", "data_sheet", "derived", "estimate", "calibrated"}
        assert source["ref"]
        assert (source["kind"] == "calibrated") == ("to" in source)
        limits = range_of(sources, key)
        assert limits is None or limits[0] <= value <= limits[1], key


def test_two_values_are_calibrated_and_say_to_what():
    sources = with_sources("objective")["sources"]
    assert sources["transistor"]["fall_time_s"]["to"] == "solar_reflex.frequency_converges_at_90_hz"
    assert sources["window_s"]["to"] == "solar_reflex.ise_converges_at_0_2"


def test_a_period_holds_no_more_than_itself():
    with pytest.raises(ValidationError, match=r"charge_share \+ discharge_share is 1.1; a period holds at most 1"):
        Waveform(charge_a=1.0, charge_share=0.9, discharge_a=1.0, discharge_share=0.2)


def test_records_import_nothing_heavy():
    code = (
        "import sys, pipeline.objective.records, pipeline.taguchi.arrays, pipeline.search.registry\n"
        "import pipeline.search.algorithms.swarm, pipeline.search.algorithms.sweep\n"
        "print([m for m in ('numba', 'scipy', 'pvlib', 'matplotlib', 'pandas', 'pydoe') if m in sys.modules])"
    )
    environment = {**os.environ, "PYTHONPATH": str(CONF.parent / "src")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
