"""The one place that reaches into Hydra and OmegaConf: members that they keep to themselves, pinned by the lock file.

`tests/config/test_adapter.py` compares what is composed through it with Hydra's own composition.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from hydra import version
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra._internal.core_plugins.file_config_source import FileConfigSource
from hydra._internal.hydra import Hydra
from hydra._internal.utils import create_config_search_path
from hydra.core.config_loader import ConfigLoader
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import ChoiceSweep, Override, OverrideType, RangeSweep
from hydra.core.plugins import Plugins
from hydra.grammar.gen.OverrideLexer import InputStream, OverrideLexer  # type: ignore[attr-defined]
from hydra.plugins.config_source import ConfigResult, ConfigSource
from hydra.types import RunMode
from omegaconf import OmegaConf
from omegaconf.basecontainer import BaseContainer

UNCOUNTED = 10**18


class DefaultsLists(FileConfigSource):
    """A source of configuration files from which Hydra reads their defaults lists, and nothing else."""

    content: Callable[[Path], Mapping[str, Any]]
    text: Callable[[Path], str]

    @staticmethod
    def scheme() -> str:
        """Return what stands before `://` in a search path of these files."""
        return "defaults"

    def load_config(self, config_path: str) -> ConfigResult:
        """Return a file's defaults list, with the header that names its package."""
        path = Path(self.path, self._normalize_file_name(config_path))
        defaults = {key: value for key, value in type(self).content(path).items() if key == "defaults"}
        header = ConfigSource._get_header_dict(type(self).text(path)[:512])
        return ConfigResult(
            config=OmegaConf.create(defaults), path=self.full_path(), provider=self.provider, header=header
        )


@contextmanager
def opened(
    confs: Sequence[Path], content: Callable[[Path], Mapping[str, Any]], text: Callable[[Path], str]
) -> Iterator[ConfigLoader]:
    """Open Hydra's global state for folders of groups, and leave it as it was found.

    Arguments
    ---------
    confs : Hydra's search path: the folders, the first one that has a file counts.
    content, text : read a YAML file.
    """
    GlobalHydra.instance().clear()
    version.setbase("1.3")
    DefaultsLists.content = staticmethod(content)
    DefaultsLists.text = staticmethod(text)
    Plugins.instance().register(DefaultsLists)
    path = create_config_search_path(f"defaults://{confs[0]}")
    for conf in confs[1:]:
        path.append("shipped", f"defaults://{conf}")
    Hydra.create_main_hydra2("pipeline", path)
    try:
        with _without_resolvers():
            yield GlobalHydra.instance().config_loader()
    finally:
        GlobalHydra.instance().clear()


@contextmanager
def _without_resolvers() -> Iterator[None]:
    """Take away all that `${name:...}` may call: the environment, the clock, Hydra's own state."""
    kept = BaseContainer._resolvers
    BaseContainer._resolvers = {}
    try:
        yield
    finally:
        BaseContainer._resolvers = kept


def files_of(loader: ConfigLoader, words: Sequence[str]) -> list[tuple[str, str]]:
    """Return the files that a choice stands for, in the order in which Hydra merges them: package and path."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        defaults = loader.compute_defaults_list("config", list(words), RunMode.RUN).defaults
    return [(one.package or "", one.config_path) for one in defaults if one.config_path is not None]


def overridden(
    tree: Mapping[str, Any], words: Sequence[Override], check: Callable[[dict[str, Any]], None]
) -> dict[str, Any]:
    """Return a plain tree with some values overridden and its interpolations resolved, as Hydra would do it.

    Arguments
    ---------
    check : sees the tree with its interpolations as they are written; raises where they are not to be resolved.
    """
    config = OmegaConf.create(dict(tree))
    OmegaConf.set_struct(config, True)
    with _without_resolvers():
        ConfigLoaderImpl._apply_overrides_to_config(list(words), config)
        OmegaConf.set_struct(config, False)
        written: Any = OmegaConf.to_container(config, resolve=False)
        check(dict(written))
        done: Any = OmegaConf.to_container(config, resolve=True, throw_on_missing=True)
    return dict(done)


def applied(tree: Mapping[str, Any], words: Sequence[Override]) -> dict[str, Any]:
    """Return a plain tree with some values overridden as Hydra would do it, its interpolations as they are written."""
    config = OmegaConf.create(dict(tree))
    OmegaConf.set_struct(config, True)
    with _without_resolvers():
        ConfigLoaderImpl._apply_overrides_to_config(list(words), config)
        written: Any = OmegaConf.to_container(config, resolve=False)
    return dict(written)


def changes(word: Override) -> bool:
    """Tell whether an override changes a value that is there, and neither adds nor takes one out."""
    return word.type is OverrideType.CHANGE and word.package is None


_SCALARS = {OverrideLexer.FLOAT, OverrideLexer.INT, OverrideLexer.BOOL}
_OPENING = {OverrideLexer.EQUAL, OverrideLexer.POPEN, OverrideLexer.BRACKET_OPEN, OverrideLexer.BRACE_OPEN}
_CLOSING = {OverrideLexer.PCLOSE, OverrideLexer.BRACKET_CLOSE, OverrideLexer.BRACE_CLOSE}


def spelled(word: str) -> Iterator[str]:
    """Yield the numbers and truth values of an override as they are written in it, those within a word left out."""
    lexer = OverrideLexer(InputStream(word.rstrip()))
    lexer.removeErrorListeners()
    tokens = lexer.getAllTokens()
    kinds = [token.type for token in tokens]
    equal = kinds.index(OverrideLexer.EQUAL) if OverrideLexer.EQUAL in kinds else len(kinds)
    braces = 0
    for before, token, after in zip(
        kinds[equal:], tokens[equal + 1 :], [*kinds[equal + 2 :], OverrideLexer.COMMA], strict=False
    ):
        braces += (token.type == OverrideLexer.BRACE_OPEN) - (token.type == OverrideLexer.BRACE_CLOSE)
        beside = {OverrideLexer.COMMA} | ({OverrideLexer.COLON} if braces else set())
        if token.type in _SCALARS and before in _OPENING | beside and after in _CLOSING | beside:
            yield token.text


def runs_of(word: Override) -> int:
    """Return how many runs an override makes, counted without making them."""
    swept = word.value()
    if isinstance(swept, RangeSweep):
        start, stop, step = (float(part or 0) for part in (swept.start, swept.stop, swept.step))
        count = (stop - start) / step if step else math.inf
        return max(0, math.ceil(count)) if abs(count) < UNCOUNTED else UNCOUNTED
    return len(swept.list) if isinstance(swept, ChoiceSweep) else 1


def expanded(loader: ConfigLoader, words: Sequence[str]) -> list[list[str]]:
    """Return one list of overrides for each run of a sweep, as Hydra's basic sweeper has them."""
    parsed = OverridesParser.create(config_loader=loader).parse_overrides(overrides=list(words))
    return [list(run) for batch in BasicSweeper.split_arguments(parsed, max_batch_size=None) for run in batch]
