"""The system from the panel to the battery as a label shows it to figures."""

from __future__ import annotations

from tests.cards import card

SYSTEM = {
    "panel": card("panel"),
    "converter": card("converter"),
    "load": card("load"),
    "battery": {"title": "Lead-acid 12 V 7 Ah", "capacity_in_use_ah": 7.0},
    "discharge_voltage_v": 13.5,
}
