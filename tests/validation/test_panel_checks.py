"""The checks of the panel against pvlib keep to their bounds."""

from __future__ import annotations

from pipeline.validation import panel_checks


def test_every_bound_holds():
    found = panel_checks.rows()
    assert len(found) == 2
    for quantity, value, bound in found:
        assert 0.0 <= value <= bound, quantity


def test_a_wrong_panel_is_noticed(monkeypatch):
    """Another module in the place of the one that was drawn breaks both."""
    known = panel_checks._known
    monkeypatch.setattr(panel_checks, "_known", lambda name: known("Kyocera_Solar_KC200GT"))
    for quantity, value, bound in panel_checks.rows():
        assert value > bound, quantity
