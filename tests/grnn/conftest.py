from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from pipeline.config.sources import split
from pipeline.experiments.network.records import NetworkStudy
from pipeline.experiments.network.sources import every_surface

CONF = Path(__file__).parents[2] / "conf"


@pytest.fixture(scope="session")
def study() -> NetworkStudy:
    """Return the network of the Ni-Cd study as it is shipped."""
    values, _ = split(yaml.safe_load((CONF / "study" / "nicd_grnn.yaml").read_text())["network"])
    return NetworkStudy(**values)


@pytest.fixture(scope="session")
def surfaces(study):
    return every_surface(study.data)
