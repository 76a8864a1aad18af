"""Chaos, objective, tuning and search as their steps make them, small: few bins, few searches."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from shutil import copytree
from tempfile import mkdtemp

from pipeline.experiments.frequency import chaos, objective, search, tuning
from tests import making
from tests.cards import card

CHAOS = {
    "start": 0.7, "orbit_steps": 300, "r_low": 3.5, "r_points": 26, "transient": 50, "bifurcation_steps": 20,
    "disorder_steps": 400, "bins": [10, 20],
}  # fmt: skip
WAVEFORM = {"charge_a": 2.1, "charge_share": 0.9, "discharge_a": 0.5, "discharge_share": 0.05}
PAIRS = [[0.015, 0.02], [0.006, 0.6]]


ALGORITHM = card("search") | {"c1": 1.0, "c2": 1.0, "w": 0.75, "variants": {}}
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
    minimised = card("objective")
    problem = {"waveform": WAVEFORM, "pairs": PAIRS} | {key: minimised[key] for key in ("transistor", "window_s")}
    swarm = ALGORITHM | {"replicates": 6, "iterations": 12}
    design = card("design") | {"replicates": 2, "factorial_replicates": 4}
    small_sweep = card("oracle") | {"points": 500}
    listed = [
        {"name": name, "settings": small_sweep if change is None else swarm | change}
        for name, change in SEARCHES.items()
    ]
    settings = {
        "chaos": (chaos, {"chaos": CHAOS}),
        "objective": (
            objective,
            {
                "objective": minimised,
                "waveforms": {"cv_reflex": WAVEFORM},
                "pairs": PAIRS,
                "series_resistance_ohm": 0.02,
                "thermal_resistance_k_w": 1.9,
            },
        ),
        "tuning": (tuning, {"design": design, "swarm": swarm, "problem": problem, "seed": 1}),
        "search": (search, {"searches": listed, "problem": problem, "seed": 1}),
    }
    for name, (step, chosen) in settings.items():
        step.run(chosen, making.inputs({}), making.output(name, root / name))
    return root
