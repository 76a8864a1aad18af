"""Chaos, objective, tuning and search as their steps make them, small: few bins, few searches."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from shutil import copytree
from tempfile import mkdtemp
from typing import Any

import yaml

from pipeline.steps import chaos, objective, search, tuning

CONF = Path(__file__).parents[2] / "conf"
CHAOS = {
    "start": 0.7, "orbit_steps": 300, "r_low": 3.5, "r_points": 26, "transient": 50, "bifurcation_steps": 20,
    "disorder_steps": 400, "bins": [10, 20],
}  # fmt: skip
WAVEFORM = {"charge_a": 2.1, "charge_share": 0.9, "discharge_a": 0.5, "discharge_share": 0.05}
PAIRS = [[0.015, 0.02], [0.006, 0.6]]


def _card(path: str) -> dict[str, Any]:
    return {key: value for key, value in yaml.safe_load((CONF / path).read_text()).items() if key != "sources"}


ALGORITHM = _card("search/cpso.yaml") | {"c1": 1.0, "c2": 1.0, "w": 0.75, "variants": {}}
SYSTEM = {
    "panel": _card("panel/kc65t.yaml"),
    "converter": _card("converter/fixed_efficiency.yaml"),
    "load": _card("load/master_system.yaml"),
    "battery": {"title": "Lead-acid 12 V 7 Ah", "capacity_ah": 7.0},
    "discharge_voltage_v": 13.5,
}
SEARCHES = {
    "swarm": {}, "sweep": None, "swarm_published": {}, "published_protocol": {"replicates": 2},
    "uniform": {"rand": "uniform"}, "arcsine": {"rand": "arcsine"},
}  # fmt: skip


def search_half(root: Path) -> dict[str, Path]:
    """Put the artefacts of the four steps under a folder; return input name -> folder."""
    made = _made()
    for name in ("chaos", "objective", "tuning", "search"):
        copytree(made / name, root / name)
    return {name: root / name for name in ("chaos", "objective", "tuning", "search")}


@lru_cache(maxsize=1)
def _made() -> Path:
    root = Path(mkdtemp())
    card = _card("objective/reflex_frequency.yaml")
    problem = {"waveform": WAVEFORM, "pairs": PAIRS, "transistor": card["transistor"], "window_s": card["window_s"]}
    swarm = ALGORITHM | {"replicates": 6, "iterations": 12}
    design = _card("design/taguchi_l16.yaml") | {"replicates": 2, "factorial_replicates": 4}
    small_sweep = _card("search/sweep.yaml") | {"points": 500}
    listed = [
        {"name": name, "settings": small_sweep if change is None else swarm | change}
        for name, change in SEARCHES.items()
    ]
    settings = {
        "chaos": (chaos, {"chaos": CHAOS}),
        "objective": (
            objective,
            {"objective": card, "waveforms": {"cv_reflex": WAVEFORM}, "pairs": PAIRS, "series_resistance_ohm": 0.02},
        ),
        "tuning": (tuning, {"design": design, "swarm": swarm, "problem": problem, "seed": 1}),
        "search": (search, {"searches": listed, "problem": problem, "seed": 1}),
    }
    for name, (step, chosen) in settings.items():
        (root / name).mkdir()
        step.run(chosen, {}, root / name)
    return root
