"""The artefacts of a charger's network as its steps make them, small: few widths, few generations."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

from pipeline.config.compose import compose_tree
from pipeline.config.study import study_from
from pipeline.experiments.network import EXPERIMENT
from pipeline.kernel import registry
from pipeline.kernel.draft import drafted
from pipeline.kernel.experiment import Draft
from tests import making

SMALL = (
    "study=nicd_grnn",
    "network.form.widths.temperature=[0.05,0.1]",
    "network.form.widths.gradient=[10.0]",
    "network.form.widths.trial_generations=5",
    "network.selection.replicates=3",
    "network.selection.generations=20",
    "network.selection.long_generations=30",
    "network.anfis.epochs=4",
    "network.size={smallest:2,largest:4,generations:10,replicates:2}",
    "network.kernels={generations:10,replicates:2}",
)


def small_study(words: Iterable[str] = ()) -> Any:
    """Return the Ni-Cd study with a network that is found in a moment."""
    return study_from(compose_tree((*SMALL, *words)))


def nodes(words: Iterable[str] = ()) -> dict[str, Draft]:
    """Return name -> node of the network of the small study."""
    study = small_study(words)
    return {node.name: drafted(node, study) for node in EXPERIMENT.nodes(study)}


def made(folder: Path, words: Iterable[str] = ()) -> dict[str, Path]:
    """Run the steps of the network into a folder; return input name -> folder."""
    found: dict[str, Path] = {}
    for name, node in nodes(words).items():
        inputs = making.inputs({key: found[maker] for key, maker in node.inputs.items()})
        import_module(registry.module(node.step)).run(node.settings, inputs, making.output(node.step, folder / name))
        found[name] = folder / name
    return found


@lru_cache(maxsize=1)
def network_half() -> dict[str, Path]:
    """Return the artefacts of the small study, made once."""
    return made(Path(mkdtemp()))
