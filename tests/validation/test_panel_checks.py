"""The checks of the panel against pvlib keep to their bounds."""

from __future__ import annotations

from pipeline.validation import panel_checks


def test_every_bound_holds() -> None:
    found = panel_checks.check({})
    assert [row.finding for row in found.rows] == ["holds", "holds"]
    assert [len(curve.x) for curve in found.curves] == [1000, 1440]


def test_a_wrong_panel_is_noticed(monkeypatch) -> None:
    """Another module in the place of the one that was drawn breaks both."""
    known = panel_checks._known
    monkeypatch.setattr(panel_checks, "_known", lambda name: known("Kyocera_Solar_KC200GT"))
    assert [row.finding for row in panel_checks.check({}).rows] == ["broken", "broken"]
