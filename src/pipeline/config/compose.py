"""Hydra composition: groups and overrides in, one plain tree out, with the file behind every key path."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from hydra import compose, initialize_config_dir
from hydra.core.config_loader import ConfigLoader
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import ConfigCompositionException, HydraException, MissingConfigException
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from pipeline.digest import PROJECT
from pipeline.errors import UserError, best_matches

CONF = PROJECT / "conf"


@dataclass(frozen=True)
class Composed:
    """A composed configuration.

    `tree` is the plain nested mapping, `overrides` the command line's words, `files` the YAML files that took part
    with the key path under which each one's content stands.
    """

    tree: dict[str, Any]
    overrides: tuple[str, ...]
    files: tuple[tuple[str, Path], ...]

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
        best: tuple[int, str] = (-1, "conf/config.yaml")
        for package, file in self.files:
            if package and path != package and not path.startswith(package + "."):
                continue
            keys = path[len(package) :].strip(".").split(".") if path != package else []
            depth, line = _locate(file, keys)
            depth += len(package.split(".")) if package else 0
            if depth >= best[0]:
                best = (depth, f"{_shown(file)}:{line}")
        return best[1]


def compose_tree(overrides: Sequence[str]) -> Composed:
    """Compose the configuration with Hydra.

    Arguments
    ---------
    overrides : words as on Hydra's command line, e.g. `battery=lead_acid_12v18ah`, `modes.cv_reflex.charge_a=2.0`.

    Raises
    ------
    UserError : unknown group, option or key, or YAML that cannot be read.
    """
    words = tuple(overrides)
    _check_syntax(words)
    with _hydra():
        config = _compose([*_mode_words(words), *_panel_words(words), *words])
        hydra_config = config.pop("hydra")
        choices = dict(hydra_config["runtime"]["choices"])
        files = tuple(_files(choices))
        return Composed(config, words, files)


def expand(words: Sequence[str]) -> list[list[str]]:
    """Expand a sweep (`battery=a,b mode.x=range(1,4)`) to one list of overrides a run, as Hydra's basic sweeper."""
    from hydra._internal.core_plugins.basic_sweeper import BasicSweeper

    _check_syntax(words)
    with _hydra() as loader:
        parsed = OverridesParser.create(config_loader=loader).parse_overrides(overrides=list(words))
        batches = BasicSweeper.split_arguments(parsed, max_batch_size=None)
        return [list(run) for batch in batches for run in batch]


def options(group: str) -> list[str]:
    """Return the names of the YAML files of a group."""
    return sorted(path.stem for path in (CONF / group).glob("*.yaml"))


def cards() -> dict[str, dict[str, Any]]:
    """Return the card of every study as its file has it, by name; nothing is composed."""
    read = {name: yaml.safe_load((CONF / "study" / f"{name}.yaml").read_text("utf-8")) for name in options("study")}
    return {name: (content or {}).get("study", {}) for name, content in read.items()}


def groups() -> list[str]:
    """Return the names of the configuration groups."""
    return sorted(path.name for path in CONF.iterdir() if path.is_dir())


class _hydra:
    """Hydra's global state, opened for one composition and left as it was found."""

    def __enter__(self) -> ConfigLoader:
        GlobalHydra.instance().clear()
        self._context = initialize_config_dir(config_dir=str(CONF), version_base="1.3", job_name="pipeline")
        self._context.__enter__()
        return GlobalHydra.instance().config_loader()

    def __exit__(self, *error: object) -> None:
        GlobalHydra.instance().clear()


def _compose(words: list[str]) -> dict[str, Any]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            config = compose("config", overrides=words, return_hydra_config=True)
        hydra_part = OmegaConf.to_container(config.hydra, resolve=False)
        OmegaConf.set_readonly(config.hydra, False)
        OmegaConf.set_struct(config, False)
        del config["hydra"]
        tree: Any = OmegaConf.to_container(config, resolve=True, throw_on_missing=True)
        tree["hydra"] = hydra_part
        return tree  # type: ignore[no-any-return]
    except MissingConfigException as error:
        raise _missing_option(error, words) from None
    except (ConfigCompositionException, HydraException, OmegaConfBaseException, ValueError) as error:
        raise _refused(error, words) from None
    except yaml.YAMLError as error:
        raise UserError(f"conf/: not readable YAML: {error}") from None


def _mode_words(words: Iterable[str]) -> list[str]:
    """Every YAML in conf/modes is a mode: adding one needs no list to be edited."""
    taken = {word.split("=")[0].lstrip("+") for word in words}
    names = options("modes")
    return [f"+modes@modes.{name}={name}" for name in names if f"modes@modes.{name}" not in taken]


def _panel_words(words: Iterable[str]) -> list[str]:
    """A panel's name alone says that it stands in a database."""
    keys = {word.split("=")[0] for word in words}
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


def _missing_option(error: MissingConfigException, words: Iterable[str]) -> UserError:
    missing = error.missing_cfg_file or ""
    group, _, option = missing.rpartition("/")
    if group and (CONF / group).is_dir():
        chosen = f"{group}={option}"
        word = next((word for word in words if word.startswith(f"{group}@") and word.endswith(f"={option}")), chosen)
        return UserError(f"override {word}: no conf/{group}/{option}.yaml; {best_matches(option, options(group))}")
    return UserError(f"no configuration {missing!r}: {str(error).splitlines()[0]}; groups: {', '.join(groups())}")


def _refused(error: Exception, words: Iterable[str]) -> UserError:
    cause = error.__cause__ or error
    parser = OverridesParser.create()
    for word in words:
        parsed = parser.parse_override(word)
        if parsed.is_add() or parsed.is_delete() or f"'{parsed.key_or_group}'" not in str(error):
            continue
        chosen = [other for other in words if other.split("=")[0] in groups() and other != word]
        tree = _compose([*_mode_words(()), *chosen])
        keys = parsed.key_or_group.split(".")
        here: Any = tree
        for depth, key in enumerate(keys):
            if not isinstance(here, dict) or key not in here:
                known = [name for name in here if name not in ("sources", "hydra")] if isinstance(here, dict) else []
                if depth == 0 and key in groups():
                    return UserError(f"override {word}: this study has no {key}; it has: {', '.join(sorted(here))}")
                parent = ".".join(keys[:depth]) or "the configuration"
                return UserError(f"override {word}: {parent} has no key {key!r}; {best_matches(key, known)}")
            here = here[key]
        return UserError(f"override {word}: {cause}")
    return UserError(f"configuration: {' '.join(str(cause).split())}")


def _files(choices: dict[str, str | None]) -> Iterable[tuple[str, Path]]:
    yield "", CONF / "config.yaml"
    for key, option in choices.items():
        group, _, package = key.partition("@")
        path = CONF / group / f"{option}.yaml"
        if option is None or not path.is_file():
            continue
        named = _package(path)
        yield (named if named is not None else package or group.replace("/", ".")), path
        for base in _bases(path):
            yield package or group.replace("/", "."), base


def _package(path: Path) -> str | None:
    for line in path.read_text(encoding="utf-8").splitlines()[:5]:
        if line.startswith("# @package"):
            name = line.split()[2]
            return "" if name == "_global_" else name
    return None


def _bases(path: Path) -> Iterable[Path]:
    """Files of the same group that a file builds on through its own defaults list."""
    for entry in (yaml.safe_load(path.read_text(encoding="utf-8")) or {}).get("defaults", ()):
        if isinstance(entry, str) and entry != "_self_" and not entry.startswith("/"):
            base = path.parent / f"{entry}.yaml"
            if base.is_file():
                yield base
                yield from _bases(base)


def _locate(file: Path, keys: list[str]) -> tuple[int, int]:
    """Return how many of the keys a YAML file has, from the first, and the line of the last one found."""
    node = yaml.compose(file.read_text(encoding="utf-8"))
    depth, line = 0, 1
    for key in keys:
        if not isinstance(node, yaml.MappingNode):
            break
        found = [(k, v) for k, v in node.value if k.value == key]
        if not found:
            break
        line = found[0][0].start_mark.line + 1
        node = found[0][1]
        depth += 1
    return depth, line


def _shown(file: Path) -> str:
    return file.relative_to(PROJECT).as_posix()
