"""One strict reader for every YAML file of a person: scalars of YAML 1.2, no tags, bounded in size, depth and aliases.

Scalars are those of the core schema, https://yaml.org/spec/1.2.2/#103-core-schema: `1:30`, `yes`, `1_000` are words.
"""

from __future__ import annotations

import re
import stat
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import yaml

from pipeline.errors import UserError
from pipeline.kernel.places import PROJECT

MOST_BYTES = 1 << 20
MOST_DEPTH = 64
MOST_VALUES = 100_000
"""What a file may hold when its aliases are written out."""
Place = tuple[str | int, ...]

_INTEGER = re.compile(r"[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+")
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WORDS = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **{sign + dot: float(sign + "inf") for sign in ("", "+", "-") for dot in (".inf", ".Inf", ".INF")},
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_MARKS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
_MOST_DIGITS = 400
_STRING = ("!", "tag:yaml.org,2002:str")
_KINDS = (
    (stat.S_ISDIR, "is a folder"),
    (stat.S_ISFIFO, "is a pipe"),
    (stat.S_ISCHR, "is a device"),
    (stat.S_ISBLK, "is a device"),
    (stat.S_ISSOCK, "is a socket"),
)


class Document(NamedTuple):
    """What a file holds, and the line of every key path in it."""

    tree: dict[str, Any]
    lines: dict[Place, int]


def shown(path: Path) -> str:
    """Return a file's name as messages have it."""
    name = path.relative_to(PROJECT).as_posix() if path.is_relative_to(PROJECT) else path.as_posix()
    return name if len(name) <= 200 else f"{name[:200]}..."


def document(path: Path) -> Document:
    """Return what a YAML file holds; read once until it changes, and shared by all who ask, so not to be changed.

    Raises
    ------
    UserError : no file, one that is no mapping in YAML 1.2, or one that would come to more than the bounds.
    """
    return _read(path, state(path))


def state(path: Path) -> tuple[int, int]:
    """Return what tells a file from what it was before an edit: its time and size.

    Raises
    ------
    UserError : nothing there, or no ordinary file.
    """
    try:
        status = path.stat()
    except FileNotFoundError:
        told = "is a link to a file that is not there" if path.is_symlink() else "no such file"
        raise UserError(f"{shown(path)}: {told}") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise UserError(f"{shown(path)}: cannot be read ({reason})") from None
    for is_kind, told in _KINDS:
        if is_kind(status.st_mode):
            raise UserError(f"{shown(path)}: {told}; allowed is a YAML file")
    if status.st_size > MOST_BYTES:
        raise UserError(
            f"{shown(path)}: {status.st_size} bytes; a file of the configuration has up to {MOST_BYTES >> 10} KiB"
        )
    return status.st_mtime_ns, status.st_size


def text(path: Path) -> str:
    """Return the text of a file: UTF-8, or UTF-16 where it begins with a mark of byte order; errors as `document`."""
    try:
        with path.open("rb") as file:
            data = file.read(MOST_BYTES + 1)
    except OSError as error:
        raise UserError(f"{shown(path)}: cannot be read ({error.strerror})") from None
    encoding = next((name for mark, name in _MARKS if data.startswith(mark)), "utf-8")
    try:
        return data.decode(encoding)
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise UserError(f"{shown(path)}:{line}: not {encoding.upper()} text; save the file as UTF-8") from None


@lru_cache(maxsize=512)
def _read(path: Path, _: tuple[int, int]) -> Document:
    reader = _Reader(path)
    try:
        return reader.document(text(path))
    except yaml.MarkedYAMLError as error:
        reader.refuse(error.problem_mark, f"not readable YAML: {error.problem}")
    except (yaml.YAMLError, ValueError) as error:
        raise UserError(f"{shown(path)}: not readable YAML: {' '.join(str(error).split())}") from None


class _Open(NamedTuple):
    """A collection that is being read: where it stands, its value, and the key that waits for a value."""

    place: Place
    value: Any
    key: list[str]
    anchor: str | None
    before: int


class _Reader:
    """Builds plain data from the parser's events, without recursion."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.lines: dict[Place, int] = {}
        self.anchors: dict[str, tuple[Any, int]] = {}
        self.stack: list[_Open] = []
        self.count = 0
        self.root: Any = None

    def document(self, written: str) -> Document:
        documents = 0
        for event in self._events(written):
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    self.refuse(event.start_mark, "a second document; a file of the configuration holds one")
            elif isinstance(event, yaml.ScalarEvent):
                self._scalar(event)
            elif isinstance(event, yaml.AliasEvent):
                value, size = self.anchors.get(str(event.anchor), (None, 0))
                if not size:
                    self.refuse(event.start_mark, f"*{event.anchor} stands for nothing above it")
                self._put(value, event, size)
            elif isinstance(event, yaml.CollectionStartEvent):
                self._open(event)
            elif isinstance(event, yaml.CollectionEndEvent):
                done = self.stack.pop()
                if done.anchor is not None:
                    self.anchors[done.anchor] = (done.value, self.count - done.before)
        if not isinstance(self.root, dict | None):
            kind = {list: "list", str: "word", bool: "truth value"}.get(type(self.root), "number")
            raise UserError(f"{shown(self.path)}: a file of conf/ is a mapping of names to values, not a {kind}")
        return Document(self.root or {}, self.lines)

    def _events(self, written: str) -> Iterator[yaml.Event]:
        yield from yaml.parse(written, Loader=yaml.CSafeLoader)

    def _open(self, event: yaml.CollectionStartEvent) -> None:
        if event.tag is not None:
            self.refuse(event.start_mark, f"{_tag(event.tag)} is a tag, which is not read")
        if len(self.stack) >= MOST_DEPTH:
            self.refuse(event.start_mark, f"nested deeper than {MOST_DEPTH} levels")
        before = self.count
        value: Any = {} if isinstance(event, yaml.MappingStartEvent) else []
        place = self._put(value, event, 1)
        self.stack.append(_Open(place, value, [], event.anchor, before))

    def _scalar(self, event: yaml.ScalarEvent) -> None:
        if self.stack and isinstance(self.stack[-1].value, dict) and not self.stack[-1].key:
            self._key(event)
            return
        if event.tag is not None and event.tag not in _STRING:
            self.refuse(event.start_mark, f"{_tag(event.tag)} is a tag, which is not read")
        plain = event.implicit[0] and event.tag is None
        value = scalar(event.value) if plain and len(event.value) <= _MOST_DIGITS else event.value
        self._put(value, event, 1)
        if event.anchor is not None:
            self.anchors[event.anchor] = (value, 1)

    def _key(self, event: yaml.ScalarEvent) -> None:
        """Take a key, which is a name as it is written, whatever it would be as a value."""
        here, key = self.stack[-1], event.value
        if key in here.value:
            first = self.lines[*here.place, key]
            self.refuse(event.start_mark, f"not readable YAML: found duplicate key {key}, first in line {first}")
        if key == "<<":
            self.refuse(event.start_mark, "<< merges mappings in YAML 1.1 only; write the values out")
        here.key.append(key)
        self.lines[*here.place, key] = _line(event.start_mark)

    def _put(self, value: Any, event: yaml.Event, size: int) -> Place:
        self.count += size
        if self.count > MOST_VALUES:
            self.refuse(event.start_mark, f"more than {MOST_VALUES} values, with aliases written out")
        if not self.stack:
            self.root = value
            return ()
        here = self.stack[-1]
        if isinstance(here.value, list):
            here.value.append(value)
            place: Place = (*here.place, len(here.value) - 1)
            self.lines[place] = _line(event.start_mark)
            return place
        if not here.key:
            self.refuse(event.start_mark, "a list or a mapping is no key; a key is a name")
        place = (*here.place, here.key.pop())
        here.value[place[-1]] = value
        return place

    def refuse(self, mark: Any, told: str) -> NoReturn:
        """Refuse the file for what stands at a mark."""
        line = "" if mark is None else f":{_line(mark)}"
        raise UserError(f"{shown(self.path)}{line}: {told}") from None


def _line(mark: Any) -> int:
    return int(mark.line) + 1


def scalar(written: str) -> Any:
    """Return what a plain scalar is in YAML 1.2: nothing, a truth value, a number, or the word itself."""
    if written in _WORDS:
        return _WORDS[written]
    if not written.isascii():
        return written
    if _INTEGER.fullmatch(written):
        return int(written, {"0o": 8, "0x": 16}.get(written[:2], 10))
    return float(written) if _NUMBER.fullmatch(written) else written


def _tag(tag: str) -> str:
    return tag.replace("tag:yaml.org,2002:", "!!")[:80]
