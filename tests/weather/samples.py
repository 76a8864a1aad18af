"""Weather for tests: that of the configuration, with what a test changes."""

from pathlib import Path

import yaml
from pydantic import TypeAdapter

from pipeline.weather.records import Weather

CONF = Path(__file__).parents[2] / "conf"


def merged(below, above):
    """Return a mapping over another, key by key, as Hydra joins them."""
    return below | {
        key: merged(below[key], value) if isinstance(value, dict) and isinstance(below.get(key), dict) else value
        for key, value in above.items()
    }


def load(group, name):
    """Return a file of the configuration with its defaults, without sources."""
    own = yaml.safe_load((CONF / group / f"{name}.yaml").read_text())
    found = {}
    for base in own.pop("defaults", ()):
        if isinstance(base, dict):
            for key, value in base.items():
                below = load(key.strip("/").split("@")[0], value)
                for part in reversed(key.split("@")[1].split(".")):
                    below = {part: below}
                found = merged(found, below)
        elif base != "_self_":
            found = merged(found, load(group, base))
    own.pop("sources", None)
    return merged(found, own)


def weather(name, **more):
    return TypeAdapter(Weather).validate_python(merged(load("weather", name), more))
