"""Hydra composition: groups and overrides in, one plain tree out, with the file behind every key path."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.errors import ConfigCompositionException, HydraException, MissingConfigException
from omegaconf.errors import OmegaConfBaseException

from pipeline.config import adapter
from pipeline.config.inheritance import CONF, Layer, Stamp, content, merge, stamp
from pipeline.errors import UserError, best_matches

_INTERPOLATED = re.compile(r"\$\{\s*([A-Za-z_]\w*)?")


@dataclass(frozen=True)
class Choice:
    """What a choice of files comes to: the plain tree, and the files in the order of their merging."""

    tree: dict[str, Any]
    layers: tuple[Layer, ...]

    def with_values(self, words: Sequence[Override]) -> dict[str, Any]:
        """Return the tree with some values overridden and interpolations resolved, as Hydra would do it."""
        moved = self._moved(words)
        done = adapter.overridden({key: value for key, value in self.tree.items() if key in moved}, words)
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
    with adapter.opened(conf, content) as loader:
        files = adapter.files_of(loader, words)
    layers = tuple(
        Layer(tuple(filter(None, package.split("."))), conf / f"{path}.yaml")
        for package, path in files
        if not path.startswith("hydra/")
    )
    return Choice(merge(layers), layers)


@dataclass(frozen=True)
class Composed:
    """A composed configuration.

    `tree` is the plain nested mapping, `overrides` the command line's words, `layers` the YAML files that took part,
    in the order in which they were merged.
    """

    tree: dict[str, Any]
    overrides: tuple[str, ...]
    layers: tuple[Layer, ...]

    def overridden(self, path: str) -> str | None:
        """Return the override that set a key path or one of its ancestors, or None."""
        for word in self.overrides:
            group, _, package = word.split("=", 1)[0].lstrip("+~").partition("@")
            key = package or group
            if path == key or path.startswith(key + "."):
                if "=" in word and (CONF / group).is_dir() and path != key:
                    continue
                return word
        return None

    def origin(self, path: str) -> str:
        """Return where a key path was set: an override, or a YAML file with the line."""
        word = self.overridden(path)
        if word is not None:
            return f"override {word}"
        return self.setters(path)[-1].line(path.split("."))

    def setters(self, path: str) -> list[Layer]:
        """Return the files that set a key path, or the most of it that any does; the last one won.

        What no file has anything of is missing in the study's, the first at the root.
        """
        keys = tuple(path.split("."))
        depths = {layer: layer.depth(keys) for layer in self.layers if layer.place == keys[: len(layer.place)]}
        most = max(depths.values())
        files = [layer for layer, depth in depths.items() if depth == most]
        return files if most else files[:1]


def compose_tree(overrides: Sequence[str], conf: Path = CONF) -> Composed:
    """Compose the configuration with Hydra.

    Arguments
    ---------
    overrides : words as on Hydra's command line, e.g. `battery=lead_acid_12v18ah`, `modes.cv_reflex.charge_a=2.0`.
    conf : folder of the groups.

    Raises
    ------
    UserError : unknown group, option or key, or YAML that cannot be read.
    """
    words = tuple(overrides)
    _check_syntax(words)
    return _compose([*_mode_words(words, conf), *_panel_words(words), *words], words, conf)


def _compose(words: Sequence[str], told: tuple[str, ...], conf: Path) -> Composed:
    parsed = OverridesParser.create().parse_overrides(list(words))
    sweep = next((word for word in parsed if word.is_sweep_override()), None)
    if sweep is not None:
        raise UserError(f"override {sweep.input_line}: several values make a sweep, not one run; give one of them")
    empty = next((word for word in parsed if _chooses(word, conf) and word.value() is None), None)
    if empty is not None and not empty.is_delete():
        raise UserError(f"override {empty.input_line}: a group is left out with ~{empty.get_key_element()}")
    choices = [str(word.input_line) for word in parsed if _chooses(word, conf)]
    values = [word for word in parsed if not _chooses(word, conf)]
    try:
        choice = choose(tuple(choices), conf, stamp(conf))
        return Composed(choice.with_values(values), told, choice.layers)
    except MissingConfigException as error:
        raise _missing_option(error, words, conf) from None
    except (ConfigCompositionException, HydraException, OmegaConfBaseException, ValueError) as error:
        raise _refused(error, words, conf) from None


def _chooses(word: Override, conf: Path) -> bool:
    """Tell whether an override chooses a file."""
    return (conf / word.key_or_group).is_dir() and not isinstance(word.value(), dict)


def expand(words: Sequence[str]) -> list[list[str]]:
    """Expand a sweep (`battery=a,b mode.x=range(1,4)`) to one list of overrides a run, as Hydra's basic sweeper."""
    _check_syntax(words)
    with adapter.opened(CONF, content) as loader:
        runs = adapter.expanded(loader, words)
    # The sweeper writes `~key` as `~key=null`.
    return [[word.removesuffix("=null") if word.startswith("~") else word for word in run] for run in runs]


def options(group: str, conf: Path = CONF) -> list[str]:
    """Return the names of the YAML files of a group."""
    return sorted(path.stem for path in (conf / group).glob("*.yaml"))


def cards() -> dict[str, dict[str, Any]]:
    """Return the card of every study as its file has it, by name; nothing is composed."""
    return {name: content(CONF / "study" / f"{name}.yaml").get("study", {}) for name in options("study")}


def groups(conf: Path = CONF) -> list[str]:
    """Return the names of the configuration groups."""
    return sorted(path.name for path in conf.iterdir() if path.is_dir())


def _mode_words(words: Iterable[str], conf: Path) -> list[str]:
    """Every YAML in conf/modes is a mode: adding one needs no list to be edited."""
    taken = {word.split("=")[0].lstrip("+") for word in words}
    names = options("modes", conf)
    return [f"+modes@modes.{name}={name}" for name in names if f"modes@modes.{name}" not in taken]


def _panel_words(words: Iterable[str]) -> list[str]:
    """A panel's name alone says that it stands in a database."""
    keys = {word.split("=")[0] for word in words}
    if "panel.database" in keys and not {"panel.name", "panel"} & keys:
        raise UserError("panel.database: which panel there? give its name beside it, panel.name=NAME")
    return ["panel=database"] if "panel.name" in keys and "panel" not in keys else []


def _check_syntax(words: Iterable[str]) -> None:
    parser = OverridesParser.create()
    for word in words:
        try:
            understood = bool(parser.parse_override(word).key_or_group)
        except HydraException:
            understood = False
        if not understood:
            raise UserError(
                f"override {word!r}: not understood; allowed is key=value or group=option, "
                "e.g. battery=lead_acid_12v18ah or modes.cv_reflex.frequency_hz=50"
            )


def _missing_option(error: MissingConfigException, words: Iterable[str], conf: Path) -> UserError:
    missing = error.missing_cfg_file or ""
    group, _, option = missing.rpartition("/")
    if group and (conf / group).is_dir():
        chosen = f"{group}={option}"
        word = next((word for word in words if word.startswith(f"{group}@") and word.endswith(f"={option}")), chosen)
        return UserError(
            f"override {word}: no conf/{group}/{option}.yaml; {best_matches(option, options(group, conf))}"
        )
    return UserError(f"no configuration {missing!r}: {str(error).splitlines()[0]}; groups: {', '.join(groups(conf))}")


def _refused(error: Exception, words: Iterable[str], conf: Path) -> UserError:
    cause = error.__cause__ or error
    parser = OverridesParser.create()
    for word in words:
        parsed = parser.parse_override(word)
        if parsed.is_add() or f"'{parsed.key_or_group}'" not in str(error):
            continue
        chosen = [other for other in words if other.split("=")[0] in groups(conf) and other != word]
        keys = parsed.key_or_group.split(".")
        here: Any = _compose([*_mode_words((), conf), *chosen], (), conf).tree
        for depth, key in enumerate(keys):
            if not isinstance(here, dict) or key not in here:
                known = [name for name in here if name not in ("sources",)] if isinstance(here, dict) else []
                if depth == 0 and key in groups(conf):
                    return UserError(f"override {word}: this study has no {key}; it has: {', '.join(sorted(here))}")
                parent = ".".join(keys[:depth]) or "the configuration"
                return UserError(f"override {word}: {parent} has no key {key!r}; {best_matches(key, known)}")
            here = here[key]
        return UserError(f"override {word}: {cause}")
    return UserError(f"configuration: {' '.join(str(cause).split())}")
