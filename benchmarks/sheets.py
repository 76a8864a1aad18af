"""Sheets of `conf/` as the benchmarks take them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from pipeline.cell.records import Battery
from pipeline.charge.records import Mode

CONF = Path(__file__).parents[1] / "conf"
FREQUENCY_HZ = 90.0


def load(path: str) -> dict[str, Any]:
    """Return a sheet without its sources; the frequency that the study's search finds is 90 Hz here."""
    data: dict[str, Any] = yaml.safe_load((CONF / path).read_text())
    data.pop("sources", None)
    return data | ({"frequency_hz": FREQUENCY_HZ} if "frequency_hz" in data else {})


def battery(name: str) -> Battery:
    """Return a battery of `conf/battery`."""
    return Battery(**load(f"battery/{name}.yaml"))


def reflex(seconds: float, frequency_hz: float = FREQUENCY_HZ, limit_v: float | None = None, scale: float = 1) -> Mode:
    """Return the shipped Reflex mode from its first pulse on, without the hour of constant voltage before it.

    Arguments
    ---------
    limit_v : voltage limit of the battery in place of the sheet's [V].
    scale : factor of its currents, for a battery of another capacity.
    """
    sheet = load("modes/cv_reflex.yaml")
    sheet.pop("max_current_a")
    sheet |= {"frequency_hz": frequency_hz, "phases": {"reflex": sheet["phases"]["reflex"]}}
    sheet |= {"charge_a": scale * sheet["charge_a"], "discharge_a": scale * sheet["discharge_a"]}
    sheet["stop"] = {"elapsed_s": seconds}
    return Mode(**(sheet | ({} if limit_v is None else {"voltage_v": limit_v})))
