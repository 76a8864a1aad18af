from __future__ import annotations

import pytest

from pipeline.search.algorithms import swarm


@pytest.fixture(scope="session")
def swarm_settings():
    """Return swarm settings on the square from -5 to 5, with changes."""

    def settings(**changes):
        values = {
            "title": "swarm", "rand": "uniform", "particles": 8, "iterations": 20, "replicates": 5, "c1": 1.0,
            "c2": 1.0, "w": 0.75, "velocity_limit": 0.5, "position_limit": "clamp",
            "variables": {"x": {"low": -5.0, "high": 5.0}, "y": {"low": -5.0, "high": 5.0}},
        }  # fmt: skip
        return swarm.Settings(**{**values, **changes})

    return settings
