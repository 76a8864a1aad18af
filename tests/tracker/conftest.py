from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from pydantic import TypeAdapter

from pipeline.converter.records import SwitchedBoost
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import fit
from pipeline.tracker.records import AnyTracker
from pipeline.tracker.source import Source

CONF = Path(__file__).parents[2] / "conf"
NAMES = sorted(path.stem for path in (CONF / "tracker").glob("*.yaml"))
HONEST = [name for name in NAMES if name != "constant_voltage"]
"""Every tracker but the one that does not look at the power."""


def settings(path: str) -> dict:
    found = yaml.safe_load((CONF / path).read_text())
    found.pop("sources", None)
    return found


def tracker(name: str, **changes: float) -> AnyTracker:
    adapter: TypeAdapter[AnyTracker] = TypeAdapter(AnyTracker)
    return adapter.validate_python(settings(f"tracker/{name}.yaml") | changes)


@pytest.fixture(scope="session")
def source() -> Source:
    panel = Panel(**settings("panel/kc65t.yaml"))
    boost = SwitchedBoost(**settings("converter_parts/usual.yaml")["switched"]["boost"])
    return Source(panel, fit(panel), boost, 24.0)
