from __future__ import annotations

import pytest

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.experiments.tracking.records import Tracking
from tests.tracker.conftest import source

__all__ = ["source", "tracking"]


@pytest.fixture(scope="session")
def tracking() -> Tracking:
    """Return what the trackers are tried on in the study that tries them."""
    found: Tracking = study_from(compose_tree([])).tracking
    return found
