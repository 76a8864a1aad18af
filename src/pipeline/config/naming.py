"""Names of runs that are good names of folders: no brackets, commas, spaces, quotes."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from pipeline.kernel import digest

LONGEST = 100
_FOLDERS = re.compile(r"(?<=[=,\[])\s*['\"]?[/~][^,\]]*/")
_UNUSUAL = re.compile(r"[^A-Za-z0-9_.+=~@-]+")


def run_name(overrides: Sequence[str]) -> str:
    """Return the folder name of a run: its overrides, or `default` where it has none."""
    words = sorted(overrides)
    return joined(words, words) if words else "default"


def joined(parts: Sequence[str], identity: Sequence[str]) -> str:
    """Return parts of a name in one, cut and with a digest where that would be no good name of a folder.

    Arguments
    ---------
    identity : words that tell it from others.
    """
    plain = [_plain(part) for part in parts]
    name = "__".join(text for text, _ in plain)
    if len(name) <= LONGEST and all(exact for _, exact in plain):
        return name
    return f"{name[: LONGEST - 9]}-{digest.of_value(list(identity))[:8]}"


def _plain(part: str) -> tuple[str, bool]:
    """Return a part of a name without letters that a shell takes for its own, and whether it tells as much.

    Of a file that is named from the root the last word stands for the whole.
    """
    bare = part.lstrip("+")
    near = _FOLDERS.sub("", bare)
    text = near.replace("/", ".").replace("'", "").replace('"', "").replace(" ", "")
    key, sign, value = text.partition("=")
    if value[:1] == "[" and value[-1:] == "]" and not set("[]+{}") & set(value[1:-1]):
        # A list without lists in it.
        text = f"{key}{sign}{value[1:-1].replace(',', '+')}"
    found = _UNUSUAL.sub("-", text)
    return found, found == text and near == bare


def short(keys: Iterable[str], tree: Mapping[str, Any]) -> dict[str, str]:
    """Return each key path -> the shortest end of it that no other path of a configuration has.

    Arguments
    ---------
    keys : key paths, or groups with their place, as `battery@second_battery`.
    tree : the configuration.
    """
    ends = Counter(end for path in _paths(tree) for end in _ends(path))
    found: dict[str, str] = {}
    for key in keys:
        path = key.partition("@")[2] or key
        fitting = (end for end in _ends(path) if ends[end] <= 1 and end not in found.values())
        found[key] = next(fitting, path)
    return found


def _paths(tree: Any, path: str = "") -> Iterator[str]:
    for key, value in tree.items():
        if key != "sources":
            here = f"{path}.{key}" if path else str(key)
            yield here
            if isinstance(value, Mapping):
                yield from _paths(value, here)


def _ends(path: str) -> Iterator[str]:
    """Yield the ends of a key path, the shortest first."""
    keys = path.split(".")
    return (".".join(keys[start:]) for start in range(len(keys) - 1, -1, -1))
