"""The YAML files of `conf/`: parsed by libyaml, once for as long as they stay as they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import yaml
from hydra._internal.core_plugins.file_config_source import FileConfigSource
from hydra.plugins.config_source import ConfigLoadError, ConfigResult, ConfigSource
from omegaconf import OmegaConf
from omegaconf._utils import get_yaml_loader

from pipeline.digest import PROJECT
from pipeline.errors import UserError

CONF = PROJECT / "conf"
Stamp = tuple[tuple[str, int, int], ...]


@dataclass(frozen=True)
class Layer:
    """A file that takes part in a configuration, and the key path under which its content stands."""

    place: tuple[str, ...]
    file: Path

    @property
    def tree(self) -> dict[str, Any]:
        """Return what the file holds, at its place."""
        tree: dict[str, Any] = {key: value for key, value in content(self.file).items() if key != "defaults"}
        for key in reversed(self.place):
            tree = {key: tree}
        return tree

    def depth(self, keys: Sequence[str]) -> int:
        """Return how many of some keys, from the first, the file sets."""
        here: Any = self.tree
        for count, key in enumerate(keys):
            if not isinstance(here, Mapping) or key not in here:
                return count
            here = here[key]
        return len(keys)

    def line(self, keys: Sequence[str]) -> str:
        """Return the file, and the line that sets the last of some keys."""
        return f"{shown(self.file)}:{locate(self.file, keys[len(self.place) :])}"


class _Loader(yaml.CSafeLoader, get_yaml_loader()):  # type: ignore[misc]
    """OmegaConf's reading of YAML on libyaml's parser, ten times as fast as Python's."""


class DefaultsLists(FileConfigSource):
    """A source of configuration files from which Hydra reads their defaults lists, and nothing else."""

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
        config = OmegaConf.create({key: value for key, value in content(path).items() if key == "defaults"})
        return ConfigResult(config=config, path=self.full_path(), provider=self.provider, header=header)


def content(path: Path) -> dict[str, Any]:
    """Return what a YAML file holds; shared by all who ask, so not to be changed."""
    return _parsed(path, _state(path))


def stamp(folder: Path) -> Stamp:
    """Return the state of every YAML file below a folder: another one after an edit."""
    return tuple((path.as_posix(), *_state(path)) for path in sorted(folder.rglob("*.yaml")))


def locate(path: Path, keys: Sequence[str]) -> int:
    """Return the line of the last of some keys, from the first, that a YAML file has."""
    node = yaml.compose(path.read_text(encoding="utf-8"), Loader=yaml.CSafeLoader)
    line = 1
    for key in keys:
        found = [(k, v) for k, v in node.value if k.value == key] if isinstance(node, yaml.MappingNode) else []
        if not found:
            break
        line = found[0][0].start_mark.line + 1
        node = found[0][1]
    return line


def shown(path: Path) -> str:
    """Return a file's name as messages have it."""
    return path.relative_to(PROJECT).as_posix() if path.is_relative_to(PROJECT) else path.as_posix()


def _state(path: Path) -> tuple[int, int]:
    status = path.stat()
    return status.st_mtime_ns, status.st_size


@lru_cache(maxsize=512)
def _parsed(path: Path, state: tuple[int, int]) -> dict[str, Any]:
    try:
        read = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)
    except yaml.MarkedYAMLError as error:
        line = "" if error.problem_mark is None else f":{error.problem_mark.line + 1}"
        raise UserError(f"{shown(path)}{line}: not readable YAML: {error.problem}") from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UserError(f"{shown(path)}: not readable YAML: {error}") from None
    if not isinstance(read, dict | None):
        raise UserError(f"{shown(path)}: a file of conf/ is a mapping of names to values, not a {type(read).__name__}")
    return read or {}
