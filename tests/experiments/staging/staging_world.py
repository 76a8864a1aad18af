"""The study of staged charges with small searches, made by its own steps."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.kernel import registry
from pipeline.kernel.draft import drafts
from pipeline.kernel.experiment import Draft
from pipeline.kernel.run import resolve
from tests.making import inputs, output

LEFT_OUT = ("inertia", "differential_evolution", "genetic", "particle_swarm")
SMALL = (
    "study=lfp_cuckoo",
    "staging.replicates=3",
    "staging.evaluations=500",
    "staging.starts=2",
    "staging.chords=50",
    "staging.front.population=12",
    "staging.front.generations=5",
    "staging.front.weights=4",
    *(f"~staging.{part}searches.{name}" for name in LEFT_OUT for part in ("", "sources.")),
    *(f"staging.searches.{name}.{key}" for name in ("plain", "integral") for key in ("nests=10", "generations=24")),
    *("staging.searches.swarm.particles=10", "staging.searches.swarm.iterations=49"),
)
SEARCHED = ("staging_search", "staging", "front")


@cache
def small() -> Any:
    """Return the study."""
    return study_from(compose_tree(SMALL))


@cache
def nodes() -> tuple[Draft, ...]:
    """Return its nodes, inputs before those that read them."""
    return tuple(drafts(small()))


def make(folder: Path, steps: tuple[str, ...]) -> None:
    """Run the nodes of some steps, each into the folder of its name; inputs that are not made are left out."""
    for node in nodes():
        if node.step in steps:
            folders = {name: folder / name for name in node.inputs if (folder / name).is_dir()}
            step = import_module(registry.module(node.step))
            step.run(resolve(node.settings, folders), inputs(folders), output(node.step, folder / node.name))
