"""Every number of these groups has a source, every record takes its YAML, and its records import nothing heavy."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from pydantic import TypeAdapter

from pipeline.converter.records import ChainLosses, Load, PowerChain, SwitchedStage
from pipeline.panel.database import PanelEntry
from pipeline.panel.records import ConstantWeather, Panel
from pipeline.tracker.records import AnyTracker

CONF = Path(__file__).parents[2] / "conf"
GROUPS = {
    "panel": Panel | PanelEntry,
    "weather": ConstantWeather,
    "converter": PowerChain,
    "load": Load,
    "tracker": AnyTracker,
}
PARTS = {"switched": SwitchedStage, "losses": ChainLosses}
"""What the converters' files take from the group of their parts."""
# The other kinds of weather and load, and the trackers' skies, are composed with their defaults in tests/config.
PLAIN = {"weather": ("constant",), "load": ("master_system",)}
FILES = [
    path
    for group in GROUPS
    for path in sorted((CONF / group).glob("*.yaml"))
    if path.stem in PLAIN.get(group, (path.stem,))
]


@pytest.mark.parametrize("path", FILES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_every_number_has_a_source(path):
    settings = yaml.safe_load(path.read_text())
    sources = joined(settings)
    whole = settings
    if settings.pop("defaults", None):
        parts = yaml.safe_load((CONF / "converter_parts" / "usual.yaml").read_text())
        for part in parts.values():
            part.pop("sources")
        whole = settings | parts
    TypeAdapter(GROUPS[path.parent.name]).validate_python(whole)
    check(settings, sources)


@pytest.mark.parametrize("name", PARTS)
def test_every_number_of_the_parts_has_a_source(name):
    settings = yaml.safe_load((CONF / "converter_parts" / "usual.yaml").read_text())[name]
    sources = joined(settings)
    PARTS[name].model_validate(settings)
    check(settings, sources)


def joined(settings):
    """Take the sources out of settings, also those of a part that stand within it."""
    found = settings.pop("sources")
    parts = {key: joined(value) for key, value in settings.items() if isinstance(value, dict) and "sources" in value}
    return found | parts


def check(values, sources):
    assert set(sources) == {key for key, value in values.items() if numbers(value)}
    for name, source in sources.items():
        if "kind" not in source:
            check(values[name], source)
            continue
        assert source["kind"] in {"published", "data_sheet", "derived", "estimate", "calibrated"}
        assert source["ref"]
        if "range" in source and not isinstance(values[name], dict):
            assert source["range"][0] <= values[name] <= source["range"][1]


def numbers(value):
    """Tell whether there is a number in a value."""
    if isinstance(value, dict | list):
        return any(numbers(part) for part in (value.values() if isinstance(value, dict) else value))
    return not isinstance(value, str | bool)


def test_records_import_nothing_heavy():
    code = (
        "import sys, pipeline.panel.records, pipeline.converter.records, pipeline.converter.records\n"
        "import pipeline.panel.database, pipeline.tracker.records, pipeline.experiments.tracking.records\n"
        "print([m for m in ('numba', 'scipy', 'pvlib', 'matplotlib', 'pandas', 'numpy') if m in sys.modules])"
    )
    environment = {**os.environ, "PYTHONPATH": str(CONF.parent / "src")}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
