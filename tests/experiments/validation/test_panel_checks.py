"""The checks of the panel against pvlib keep to their bounds, and break where a room goes wrong."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.experiments.validation import panel_checks
from pipeline.weather import clear_sky


@pytest.fixture(scope="module")
def theirs():
    return panel_checks.theirs_w()


def breaks(theirs) -> bool:
    """Tell whether the day is outside the bound."""
    ours = panel_checks.ours_w(*panel_checks._known(panel_checks.MODULE))
    return max(panel_checks.difference(ours, theirs)) > panel_checks.ENERGY_BOUND


def test_every_bound_holds() -> None:
    found = panel_checks.check({})
    assert [row.finding for row in found.rows] == ["holds"] * (3 + len(panel_checks.MISTAKES))
    assert [len(curve.x) for curve in found.curves] == [1000, 1440]


def test_a_wrong_panel_is_noticed(monkeypatch) -> None:
    """Another module in the place of the one that was drawn breaks both."""
    known = panel_checks._known
    monkeypatch.setattr(panel_checks, "_known", lambda name: known("Kyocera_Solar_KC200GT"))
    assert [row.finding for row in panel_checks.check({}).rows[:3]] == ["broken"] * 3


def test_the_day_is_the_same_within_rounding_of_pvlibs_tables(theirs) -> None:
    assert theirs.sum() / 60.0 > 700.0
    assert not breaks(theirs)


def horizontal(card, sun, found):
    return np.maximum(0.0, found.ghi)


MISTAKES_IN_ROOMS = {
    "light of the horizontal": (clear_sky, "on_panel", horizontal),
    "sun of the interval before": (
        clear_sky,
        "sun_at",
        lambda card, at, sun_at=clear_sky.sun_at: sun_at(card, at - 300),
    ),
    "cells as warm as the air": (clear_sky, "cell_temperature_c", lambda model, light, air, wind: air),
    "air of the night": (clear_sky, "air_c", lambda air, at, air_c=clear_sky.air_c: air_c(air, at + 43200.0)),
}


@pytest.mark.parametrize("mistake", MISTAKES_IN_ROOMS)
def test_a_mistake_in_a_room_is_noticed(theirs, monkeypatch, mistake) -> None:
    module, name, wrong = MISTAKES_IN_ROOMS[mistake]
    monkeypatch.setattr(module, name, wrong)
    assert breaks(theirs)
