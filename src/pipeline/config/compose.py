"""Hydra composition: groups and overrides in, one plain tree out, with the file behind every key path."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from hydra.core.override_parser.types import Override
from hydra.errors import ConfigCompositionException, HydraException, MissingConfigException
from omegaconf.errors import OmegaConfBaseException

from pipeline.config import adapter, interpolation
from pipeline.config.choices import Word, check_defaults, check_names, chooses, parse, told
from pipeline.config.choices import options as _options
from pipeline.config.inheritance import CONF, Layer, Stamp, content, file_of, is_group, merge, roots, stamp
from pipeline.config.yaml_file import shown, text
from pipeline.errors import UserError, best_matches

MOST_RUNS = 10_000
"""What a sweep may come to."""
_INTERPOLATED = re.compile(r"\$\{\s*([A-Za-z_]\w*)?")


@dataclass(frozen=True)
class Choice:
    """What a choice of files comes to: the plain tree, and the files in the order of their merging."""

    tree: dict[str, Any]
    layers: tuple[Layer, ...]

    def with_values(self, words: Sequence[Override]) -> dict[str, Any]:
        """Return the tree with some values overridden and interpolations resolved, as Hydra would do it."""
        moved = self._moved(words)
        open_ = {key: value for key, value in self.tree.items() if key in moved}
        done = adapter.overridden(open_, words, interpolation.check)
        kept = {key: deepcopy(value) for key, value in self.tree.items() if key not in moved}
        both: dict[str, Any] = kept | done
        return {key: both[key] for key in self.tree if key in both} | both

    def _moved(self, words: Sequence[Override]) -> set[str]:
        """Return the sections that overrides and interpolations touch; only they need OmegaConf, which is slow."""
        if any("${" in str(word.value()) for word in words):
            return set(self.tree)
        moved = {word.key_or_group.split(".")[0] for word in words}
        for key, value in self.tree.items():
            shown = repr(value)
            named = set(_INTERPOLATED.findall(shown)) | ({key} if interpolation.MISSING in shown else set())
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
    check_defaults(words, conf)
    with adapter.opened(roots(conf), content, text) as loader:
        files = adapter.files_of(loader, words)
    layers = tuple(
        Layer(tuple(filter(None, package.split("."))), file_of(conf, f"{path}.yaml"))
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
                if "=" in word and is_group(CONF, group) and path != key:
                    continue
                return word
        return None

    def touched(self, path: str) -> str | None:
        """Return the first override that sets something at a key path or below it, or None."""
        keys = [(word, word.split("=", 1)[0].lstrip("+~").partition("@")) for word in self.overrides]
        fitting = (word for word, (group, _, package) in keys if f"{package or group}.".startswith(f"{path}."))
        return next(fitting, None)

    def origin(self, path: str) -> str:
        """Return where a key path was set: an override, or a YAML file with the line."""
        word = self.overridden(path)
        if word is not None:
            return f"override {told(word)}"
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
    parse(words)
    return _compose([*surrounding(words, conf), *words], words, conf)


def surrounding(words: Sequence[str], conf: Path) -> list[str]:
    """Return the overrides that come before those of a person: every mode, and what a panel's name alone says."""
    return [*_mode_words(words, conf), *_panel_words(words)]


def _compose(words: Sequence[str], typed: tuple[str, ...], conf: Path) -> Composed:
    parsed = parse(words)
    sweep = next((word for word in parsed if word.is_sweep_override()), None)
    if sweep is not None:
        raise UserError(f"override {sweep.input_line}: several values make a sweep, not one run; give one of them")
    choosing = {word.input_line: chooses(word, conf) for word in parsed}
    choices = [str(word.input_line) for word in parsed if choosing[word.input_line]]
    values = [word for word in parsed if not choosing[word.input_line]]
    try:
        choice = choose(tuple(choices), conf, stamp(conf))
    except MissingConfigException as error:
        raise _missing_option(error, words, conf) from None
    except (HydraException, OmegaConfBaseException, ValueError, TypeError, RecursionError) as error:
        raise _refused(error, words, typed, conf) from None
    try:
        return Composed(choice.with_values(values), typed, choice.layers)
    except interpolation.Refused as refused:
        path, reason = refused.args
        where = Composed(choice.tree, typed, choice.layers).origin(path)
        raise UserError(f"{where}: {path}: {reason}") from None
    except (ConfigCompositionException, HydraException, OmegaConfBaseException, ValueError, TypeError) as error:
        raise _refused(error, words, typed, conf, choice.tree) from None


def expand(words: Sequence[str]) -> list[list[str]]:
    """Expand a sweep (`battery=a,b mode.x=range(1,4)`) to one list of overrides a run, as Hydra's basic sweeper.

    Raises
    ------
    UserError : a word that is no override, a sweep of none or of too many runs, counted before they are made.
    """
    parsed = parse(words)
    counted = [(word, adapter.runs_of(word)) for word in parsed]
    runs = math.prod(count for _, count in counted)
    swept = " ".join(str(word.input_line) for word, _ in counted if word.is_sweep_override())
    if not 1 <= runs <= MOST_RUNS:
        allowed = f"allowed are {MOST_RUNS} at most; give them in several commands" if runs else "give one or more"
        count = str(runs) if runs < adapter.UNCOUNTED else "uncounted"
        raise UserError(f"override {swept}: a sweep of {count} runs; {allowed}")
    without = next((word for word in parsed if word.is_sweep_override() and not word.is_discrete_sweep()), None)
    if without is not None:
        raise UserError(
            f"override {without.input_line}: an interval has no values to take in turn; Hydra's sweepers Optuna, Ax "
            "and Nevergrad draw from one, the basic one that runs here does not; give range(1,5,0.5)"
        )
    with adapter.opened(roots(CONF), content, text) as loader:
        try:
            made = adapter.expanded(loader, words)
        except (HydraException, ValueError, ArithmeticError) as error:
            raise UserError(f"override {swept}: {' '.join(str(error).split())}") from None
    by_key = {word.get_key_element(): str(word.input_line) for word in parsed if not word.is_sweep_override()}
    # The sweeper writes `~key` as `~key=null`.
    return [
        [_word(word.removesuffix("=null") if word.startswith("~") else word, by_key) for word in run] for run in made
    ]


def _word(written: str, by_key: Mapping[str, str]) -> Word:
    plain = re.sub(r"\\(.)", r"\1", written)
    return Word(written, by_key.get(written.split("=", 1)[0], plain))


def options(group: str, conf: Path = CONF) -> list[str]:
    """Return the names of the YAML files of a group."""
    return _options(group, conf)


def cards() -> dict[str, dict[str, Any]]:
    """Return the card of every study as its file has it, by name; nothing is composed.

    In a project that has studies of its own, the shipped ones stand apart.
    """
    files = {name: file_of(CONF, f"study/{name}.yaml") for name in options("study")}
    own = {name for name, file in files.items() if file.is_relative_to(CONF)}
    held = {name: content(file).get("study") for name, file in files.items()}
    found = {name: card if isinstance(card, dict) else {} for name, card in held.items()}
    return {name: card | ({"apart": True} if own and name not in own else {}) for name, card in found.items()}


def groups(conf: Path = CONF) -> list[str]:
    """Return the names of the configuration groups."""
    return sorted({path.name for root in roots(conf) for path in root.iterdir() if path.is_dir()})


def _mode_words(words: Iterable[str], conf: Path) -> list[str]:
    """Every YAML in conf/modes is a mode: adding one needs no list to be edited."""
    taken = {word.split("=")[0].lstrip("+") for word in words}
    names = check_names("modes", conf)
    return [f"+modes@modes.{name}={name}" for name in names if f"modes@modes.{name}" not in taken]


def _panel_words(words: Iterable[str]) -> list[str]:
    """A panel's name alone says that it stands in a database."""
    keys = {word.split("=")[0] for word in words}
    if "panel.database" in keys and not {"panel.name", "panel"} & keys:
        raise UserError("panel.database: which panel there? give its name beside it, panel.name=NAME")
    return ["panel=database"] if "panel.name" in keys and "panel" not in keys else []


def _missing_option(error: MissingConfigException, words: Iterable[str], conf: Path) -> UserError:
    missing = error.missing_cfg_file or ""
    group, _, option = missing.rpartition("/")
    if group and is_group(conf, group):
        chosen = f"{group}={option}"
        word = next((word for word in words if word.startswith(f"{group}@") and word.endswith(f"={option}")), chosen)
        file = None if word in words else _building_on(group, option, conf)
        where = f"override {told(word)}" if file is None else f"{shown(file)}: defaults"
        return UserError(f"{where}: no conf/{group}/{option}.yaml; {best_matches(option, options(group, conf))}")
    return UserError(f"no configuration {missing!r}: {str(error).splitlines()[0]}; groups: {', '.join(groups(conf))}")


def _building_on(group: str, option: str, conf: Path) -> Path | None:
    """Return the first file whose `defaults` name an option of a group."""
    for file in (path for root in roots(conf) for path in sorted(root.rglob("*.yaml"))):
        listed = content(file).get("defaults")
        for one in listed if isinstance(listed, list) else []:
            beside = one == option and file.parent.name == group
            if beside or (isinstance(one, dict) and one.get(f"/{group}", one.get(group)) == option):
                return file
    return None


def _group(word: str) -> str:
    """Return the group of an override: `weather` of weather@day.weathers.clear=measured."""
    return word.split("=")[0].lstrip("+").split("@")[0]


def _refused(
    error: Exception,
    words: Sequence[str],
    typed: Sequence[str],
    conf: Path,
    tree: Mapping[str, Any] | None = None,
) -> UserError:
    """Return what Hydra or OmegaConf refused as a person would say it; `tree` is what the files come to, if they do."""
    cause = error.__cause__ or error
    full = str(getattr(cause, "full_key", "") or "")
    for word, parsed in zip(typed, parse(typed), strict=True):
        key, name = parsed.key_or_group, told(word)
        if tree is None:
            if f"'{key}'" not in str(error):
                continue
            own = _mode_words((), conf)
            chosen = [other for other in words if _group(other) in groups(conf) and other not in (word, *own)]
            here: Mapping[str, Any] = _compose([*own, *chosen], (), conf).tree
        else:
            if full != key and not full.startswith((f"{key}.", f"{key}[")) and f"'{key}'" not in str(error):
                continue
            here = tree
        unknown = None if parsed.is_add() else _unknown(full if full.startswith(f"{key}.") else key, here, conf)
        return UserError(f"override {name}: {unknown or _first_line(cause)}")
    where = f"override {' '.join(map(told, typed))}" if typed else shown(conf / "config.yaml")
    return UserError(f"{where}: {_first_line(cause)}")


def _unknown(path: str, tree: Mapping[str, Any], conf: Path) -> str | None:
    """Say which key of a path is not there, and which are; nothing where all are."""
    here: Any = tree
    keys = path.split(".")
    for depth, key in enumerate(keys):
        if isinstance(here, list) and key.isdecimal() and int(key) < len(here):
            here = here[int(key)]
        elif not isinstance(here, dict) or key not in here:
            known = [name for name in here if name != "sources"] if isinstance(here, dict) else []
            if depth == 0 and key in groups(conf):
                return f"this study has no {key}; it has: {', '.join(sorted(here))}"
            return f"{'.'.join(keys[:depth]) or 'the configuration'} has no key {key!r}; {best_matches(key, known)}"
        else:
            here = here[key]
    return None


def _first_line(error: BaseException) -> str:
    if "Cannot merge" in str(error):
        return "a list and a mapping cannot be put together; give what stands there now, or take it out first with ~"
    return " ".join((str(error).splitlines() or [type(error).__name__])[0].split())[:300]
