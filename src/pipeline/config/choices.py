"""Hydra at work: a choice of files merged once, values of the command line put on top for each run."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
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
from omegaconf import DictConfig, OmegaConf

from pipeline.config.files import DefaultsLists, Layer, Stamp
from pipeline.config.inheritance import merge


@dataclass(frozen=True)
class Choice:
    """What a choice of files comes to: the configuration, pickled, and the files in the order of their merging."""

    config: bytes
    layers: tuple[Layer, ...]

    def with_values(self, words: Sequence[Override]) -> dict[str, Any]:
        """Return the plain tree with some values overridden, as Hydra would do it."""
        config: DictConfig = pickle.loads(self.config)
        ConfigLoaderImpl._apply_overrides_to_config(list(words), config)
        OmegaConf.set_struct(config, False)
        tree: Any = OmegaConf.to_container(config, resolve=True, throw_on_missing=True)
        return tree  # type: ignore[no-any-return]


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
    merged = OmegaConf.create(merge(layers))
    OmegaConf.set_struct(merged, True)
    return Choice(pickle.dumps(merged), layers)


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
