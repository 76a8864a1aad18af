"""The engine against ngspice, where it is installed: a deck generated from the same parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.validation import ngspice_peer
from pipeline.validation.peers import compare
from pipeline.validation.records import Found, PeerSettings

BOUNDS = {"voltage": 1e-5, "SOC": 1e-8, "temperature": 1e-6}


def check(settings: Mapping[str, Any]) -> Found:
    """Return how far CC, CC-CV and pulses are apart; the deck has heat as it is here, v^2 / R of a pair."""
    return compare(PeerSettings.model_validate(settings), BOUNDS, ngspice_peer.charged)
