"""The words of a command line and the defaults lists of files, judged before Hydra takes them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override
from hydra.errors import HydraException

from pipeline.config import adapter
from pipeline.config.inheritance import content, file_of, is_group, roots, within
from pipeline.config.yaml_file import MOST_DEPTH, document, shown
from pipeline.errors import UserError, best_matches

MOST_LETTERS = 20_000
"""What one override may have; a longer list stands better in a file."""
_TRUTH = ("true", "True", "TRUE", "false", "False", "FALSE")
_OPTION = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.+-]{0,99}")
_OWN = ("hydra", "_self_")
_INSTEAD = (
    "of Hydra's own settings none is used; a run lies in results/<study>/<run>, a sweep in "
    "results/<study>/sweeps/<name> (sweep.name=NAME), and Snakemake starts the jobs (--cores N, or a profile)"
)


class Word(str):
    """An override as Hydra writes it, and as it was typed."""

    __slots__ = ("typed",)
    typed: str

    def __new__(cls, written: str, typed: str) -> Word:
        """Return the word."""
        word = super().__new__(cls, written)
        word.typed = typed
        return word


def typed(word: str) -> str:
    """Return an override as a person typed it."""
    return getattr(word, "typed", word)


def told(word: str) -> str:
    """Return an override as messages name it, cut where it is very long."""
    text = typed(word)
    return text if len(text) <= 300 else f"{text[:300]}..."


def parse(words: Iterable[str]) -> list[Override]:
    """Return overrides as Hydra understands them.

    Raises
    ------
    UserError : no override, one that is too long or nested too deep, a number that YAML 1.2 does not have.
    """
    return [_parsed(word) for word in words]


def _parsed(word: str) -> Override:
    _refuse_deep(word)
    try:
        found = OverridesParser.create().parse_override(word)
        understood = bool(found.key_or_group)
    except (HydraException, RecursionError, ValueError, ArithmeticError, TypeError):
        understood = False
    if not understood:
        raise UserError(
            f"override {told(word)}: not understood; allowed is key=value or group=option, "
            "e.g. battery=lead_acid_12v18ah or modes.cv_reflex.frequency_hz=50"
        )
    if found.key_or_group.split("/")[0].split(".")[0] in _OWN:
        raise UserError(f"override {told(word)}: {found.key_or_group}: {_INSTEAD}")
    for written in adapter.spelled(word):
        if "_" in written or (written.isalpha() and written.lower() in ("true", "false") and written not in _TRUTH):
            raise UserError(
                f"override {told(word)}: {written} is no number or truth value of YAML 1.2; write {_plain(written)}, "
                f"or '{written}' in quotes for a word"
            )
    return found


def _plain(written: str) -> str:
    return written.replace("_", "").lower()


def _refuse_deep(word: str) -> None:
    if len(word) > MOST_LETTERS:
        raise UserError(f"override {told(word)}: {len(word)} letters; allowed are {MOST_LETTERS}; write them to a file")
    depth = 0
    for letter in word:
        depth += (letter in "[{(") - (letter in "]})")
        if depth > MOST_DEPTH:
            raise UserError(f"override {told(word)}: nested deeper than {MOST_DEPTH} levels")


def chooses(word: Override, conf: Path) -> bool:
    """Tell whether an override chooses a file.

    Raises
    ------
    UserError : it chooses what is no name of a file.
    """
    if not is_group(conf, word.key_or_group) or isinstance(word.value(), dict):
        return False
    if word.is_delete():
        return True
    value, line = word.value(), getattr(word, "input_line", "")
    if value is None:
        raise UserError(f"override {told(line)}: a group is left out with ~{word.get_key_element()}")
    for one in value if isinstance(value, list) else [value]:
        name = str(getattr(one, "text", one))
        if isinstance(one, bool | dict | list) or not _OPTION.fullmatch(name) or isinstance(one, float | int):
            known = options(word.key_or_group, conf)
            raise UserError(
                f"override {told(line)}: {name[:80]!r} is no name of a file in conf/{word.key_or_group}; "
                f"{best_matches(name[:80], known)}"
            )
    return True


def options(group: str, conf: Path) -> list[str]:
    """Return the names of the YAML files of a group."""
    files = (path for root in roots(conf) for path in (root / group).glob("*.yaml"))
    return sorted({path.stem for path in files if not path.name.startswith(".")})


def check_names(group: str, conf: Path) -> list[str]:
    """Return the names of the files of a group whose files are all taken.

    Raises
    ------
    UserError : a file whose name is none that an override could have.
    """
    names = options(group, conf)
    for name in names:
        if not name.isascii() or not name.isidentifier():
            raise UserError(
                f"{shown(conf / group / name)}.yaml: its name is also that of its key; allowed are letters, digits "
                "and _, and no digit first"
            )
    return names


def check_defaults(words: Sequence[str], conf: Path) -> None:
    """Refuse files whose defaults lists are none, name nothing, or come back to themselves.

    Arguments
    ---------
    words : overrides that choose files.
    conf : folder of the groups.

    Raises
    ------
    UserError : with the file and the line of the list.
    """
    chosen: dict[str, list[str]] = {}
    for word in words:
        override = OverridesParser.create().parse_override(word)
        value = override.value()
        names = [] if override.is_delete() else value if isinstance(value, list) else [value]
        chosen[override.get_key_element().lstrip("+~")] = [str(getattr(one, "text", one)) for one in names]
    walk = _Walk(conf, chosen)
    walk.into(file_of(conf, "config.yaml"), ())
    for key, files in chosen.items():
        for name in files:
            walk.into(file_of(conf, f"{key.split('@')[0]}/{name}.yaml"), ())


class _Walk:
    """Goes through the files that defaults lists name, each once, as the command line's choices replace them."""

    def __init__(self, conf: Path, chosen: Mapping[str, list[str]]) -> None:
        self.conf, self.chosen = conf, chosen
        self.seen: set[Path] = set()

    def into(self, file: Path, above: tuple[Path, ...]) -> None:
        """Go through what a file names, directly and through others."""
        if file in above:
            circle = " -> ".join(shown(one) for one in (*above[above.index(file) :], file))
            raise UserError(f"{_listed(above[-1], 0)}: defaults come back to where they began: {circle}")
        # What is not there is told by Hydra, with what is.
        if file not in self.seen and (file.exists() or file.is_symlink()):
            for named in self._named(file):
                self.into(named, (*above, file))
        self.seen.add(file)

    def _named(self, file: Path) -> Iterator[Path]:
        listed = content(file).get("defaults", [])
        allowed = "allowed is a list of names of files and of `group: name`"
        if not isinstance(listed, list):
            raise UserError(f"{_listed(file, 0)}: defaults: value {str(listed)[:80]!r}; {allowed}")
        for place, entry in enumerate(listed):
            pairs = list(entry.items()) if isinstance(entry, Mapping) else [("", entry)]
            ((key, value),) = pairs if len(pairs) == 1 else (("", 0),)
            names = value if isinstance(value, list) and key else [value]
            if not _fits(str(key), names):
                raise UserError(f"{_listed(file, place)}: defaults: entry {str(entry)[:80]!r}; {allowed}")
            yield from self._files(file, str(key).split(" ")[-1], names)

    def _files(self, file: Path, key: str, names: Sequence[Any]) -> Iterator[Path]:
        group, _, package = key.partition("@")
        beside = within(self.conf, file).parent / group
        inside = group.strip("/") if group.startswith("/") else beside.as_posix()
        taken = self.chosen.get(f"{inside}@{package}" if package else inside, names) if key else names
        for name in taken:
            text = str(name).split("@")[0].removeprefix("optional ").strip()
            if name is not None and text != "_self_":
                folder = "" if text.startswith("/") else f"{inside}/"
                yield file_of(self.conf, f"{folder}{text.strip('/')}.yaml")


def _fits(key: str, names: Sequence[Any]) -> bool:
    if key and not re.fullmatch(r"(override +|optional +)*/?[\w/-]{1,200}(@[\w.:]+)?", key):
        return False
    form = re.compile(r"(optional +)?/?[\w+-][\w.+-]{0,99}(/[\w+-][\w.+-]{0,99})*(@[\w.:]+)?")
    return all((name is None and key != "") or (isinstance(name, str) and form.fullmatch(name)) for name in names)


def _listed(file: Path, place: int) -> str:
    lines = document(file).lines
    return f"{shown(file)}:{lines.get(('defaults', place), lines.get(('defaults',), 1))}"
