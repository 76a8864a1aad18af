from __future__ import annotations

import pytest

from pipeline.objective.records import Pairs, ReflexFrequency, Waveform
from tests.cards import card


@pytest.fixture(scope="session")
def reflex():
    return Waveform(charge_a=2.1, charge_share=0.90, discharge_a=0.5, discharge_share=0.05)


@pytest.fixture(scope="session")
def pairs():
    """The whole lead-acid battery: 15 mOhm // 0.4 F and 30 mOhm // 20 F."""
    return Pairs((0.015, 0.030), (0.006, 0.6))


@pytest.fixture(scope="session")
def settings():
    return ReflexFrequency(**card("objective"))
