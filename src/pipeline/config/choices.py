"""Hydra at work: a choice of files merged once, values of the command line put on top for each run."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from hydra import version
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.hydra import Hydra
from hydra._internal.utils import create_config_search_path
from hydra.core.config_loader import ConfigLoader
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.types import Override
from hydra.core.plugins import Plugins
from hydra.types import RunMode
from omegaconf import OmegaConf

from pipeline.config.files import DefaultsLists, Layer, Stamp
from pipeline.config.inheritance import merge

_INTERPOLATED = re.compile(r"\$\{\s*([A-Za-z_]\w*)?")


@dataclass(frozen=True)
class Choice:
    """What a choice of files comes to: the plain tree, and the files in the order of their merging."""

    tree: dict[str, Any]
    layers: tuple[Layer, ...]

    def with_values(self, words: Sequence[Override]) -> dict[str, Any]:
        """Return the tree with some values overridden and interpolations resolved, as Hydra would do it."""
        moved = self._moved(words)
        config = OmegaConf.create({key: value for key, value in self.tree.items() if key in moved})
        OmegaConf.set_struct(config, True)
        ConfigLoaderImpl._apply_overrides_to_config(list(words), config)
        OmegaConf.set_struct(config, False)
        done: Any = OmegaConf.to_container(config, resolve=True, throw_on_missing=True)
        kept = {key: deepcopy(value) for key, value in self.tree.items() if key not in moved}
        both: dict[str, Any] = kept | done
        return {key: both[key] for key in self.tree if key in both} | both

    def _moved(self, words: Sequence[Override]) -> set[str]:
        """Return the sections that overrides and interpolations touch; only they need OmegaConf, which is slow."""
        if any("${" in str(word.input_line) for word in words):
            return set(self.tree)
        moved = {word.key_or_group.split(".")[0] for word in words}
        for key, value in self.tree.items():
            named = set(_INTERPOLATED.findall(repr(value)))
            moved |= {key, *named} if named else set()
        return moved


@lru_cache(maxsize=64)
def choose(words: tuple[str, ...], conf: Path, state: Stamp) -> Choice:
    """Merge files as a person chose them; most of the time of a composition, so kept for the runs of a sweep.

    Hydra says which files in which order; they are merged here, since its own merging makes every number an object.

    Arguments
    ---------
    words : overrides that choose files.
    conf : folder of the groups.
    state : of its files, with which a kept choice ends.
    """
    with opened(conf) as loader, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        defaults = loader.compute_defaults_list("config", list(words), RunMode.RUN).defaults
    layers = tuple(
        Layer(tuple(filter(None, (default.package or "").split("."))), conf / f"{default.config_path}.yaml")
        for default in defaults
        if default.config_path is not None and not default.config_path.startswith("hydra/")
    )
    return Choice(merge(layers), layers)


@contextmanager
def opened(conf: Path) -> Iterator[ConfigLoader]:
    """Open Hydra's global state for a folder of groups, and leave it as it was found."""
    GlobalHydra.instance().clear()
    version.setbase("1.3")
    Plugins.instance().register(DefaultsLists)
    Hydra.create_main_hydra2("pipeline", create_config_search_path(f"defaults://{conf}"))
    try:
        yield GlobalHydra.instance().config_loader()
    finally:
        GlobalHydra.instance().clear()
