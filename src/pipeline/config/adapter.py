"""The one place that reaches into Hydra and OmegaConf: members that they keep to themselves, pinned by the lock file.

`tests/config/test_adapter.py` compares what is composed through it with Hydra's own composition.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml
from hydra import version
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra._internal.core_plugins.file_config_source import FileConfigSource
from hydra._internal.hydra import Hydra
from hydra._internal.utils import create_config_search_path
from hydra.core.config_loader import ConfigLoader
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.core.plugins import Plugins
from hydra.plugins.config_source import ConfigLoadError, ConfigResult, ConfigSource
from hydra.types import RunMode
from omegaconf import OmegaConf
from omegaconf._utils import get_yaml_loader


class YamlLoader(yaml.CSafeLoader, get_yaml_loader()):  # type: ignore[misc]
    """OmegaConf's reading of YAML on libyaml's parser, ten times as fast as Python's."""


class DefaultsLists(FileConfigSource):
    """A source of configuration files from which Hydra reads their defaults lists, and nothing else."""

    content: Callable[[Path], Mapping[str, Any]]

    @staticmethod
    def scheme() -> str:
        """Return what stands before `://` in a search path of these files."""
        return "defaults"

    def load_config(self, config_path: str) -> ConfigResult:
        """Return a file's defaults list, with the header that names its package."""
        path = Path(self.path, self._normalize_file_name(config_path))
        if not path.is_file():
            raise ConfigLoadError(f"Config not found : {path}")
        header = ConfigSource._get_header_dict(path.read_text(encoding="utf-8")[:512])
        defaults = {key: value for key, value in type(self).content(path).items() if key == "defaults"}
        return ConfigResult(
            config=OmegaConf.create(defaults), path=self.full_path(), provider=self.provider, header=header
        )


@contextmanager
def opened(conf: Path, content: Callable[[Path], Mapping[str, Any]]) -> Iterator[ConfigLoader]:
    """Open Hydra's global state for a folder of groups, and leave it as it was found.

    Arguments
    ---------
    conf : the folder.
    content : reads a YAML file.
    """
    GlobalHydra.instance().clear()
    version.setbase("1.3")
    DefaultsLists.content = staticmethod(content)
    Plugins.instance().register(DefaultsLists)
    Hydra.create_main_hydra2("pipeline", create_config_search_path(f"defaults://{conf}"))
    try:
        yield GlobalHydra.instance().config_loader()
    finally:
        GlobalHydra.instance().clear()


def files_of(loader: ConfigLoader, words: Sequence[str]) -> list[tuple[str, str]]:
    """Return the files that a choice stands for, in the order in which Hydra merges them: package and path."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        defaults = loader.compute_defaults_list("config", list(words), RunMode.RUN).defaults
    return [(one.package or "", one.config_path) for one in defaults if one.config_path is not None]


def overridden(tree: Mapping[str, Any], words: Sequence[Override]) -> dict[str, Any]:
    """Return a plain tree with some values overridden and its interpolations resolved, as Hydra would do it."""
    config = OmegaConf.create(dict(tree))
    OmegaConf.set_struct(config, True)
    ConfigLoaderImpl._apply_overrides_to_config(list(words), config)
    OmegaConf.set_struct(config, False)
    done: Any = OmegaConf.to_container(config, resolve=True, throw_on_missing=True)
    return dict(done)


def expanded(loader: ConfigLoader, words: Sequence[str]) -> list[list[str]]:
    """Return one list of overrides for each run of a sweep, as Hydra's basic sweeper has them."""
    parsed = OverridesParser.create(config_loader=loader).parse_overrides(overrides=list(words))
    return [list(run) for batch in BasicSweeper.split_arguments(parsed, max_batch_size=None) for run in batch]
