from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode, fit

CONF = Path(__file__).parents[2] / "conf"


@pytest.fixture(scope="session")
def kc65t() -> Panel:
    settings = yaml.safe_load((CONF / "panel" / "kc65t.yaml").read_text())
    settings.pop("sources")
    return Panel(**settings)


@pytest.fixture(scope="session")
def diode(kc65t: Panel) -> SingleDiode:
    return fit(kc65t)
