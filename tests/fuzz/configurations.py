"""Wrong configurations, derived from the JSON schema: what stands at a key path, and what may not stand there."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from pipeline.config.choices import options
from pipeline.config.compose import CONF, Composed, compose_tree
from pipeline.config.schema import schema
from pipeline.kernel import registry

Schema = Mapping[str, Any]


@dataclass(frozen=True)
class Wrong:
    """A wrong word of a command line.

    Arguments
    ---------
    kind : what is wrong with it.
    study : the study that it is said of.
    word : the override.
    sure : whether the schema rules it out; the others may be taken, or refused in the same way.
    """

    kind: str
    study: str
    word: str
    sure: bool

    @property
    def words(self) -> list[str]:
        """Return the whole command line."""
        return [f"study={self.study}", self.word]


@cache
def whole() -> Schema:
    """Return the schema as `python -m pipeline schema` writes it."""
    return schema()


@cache
def composed(study: str) -> Composed:
    """Return a study as its files have it."""
    return compose_tree([f"study={study}"])


def studies() -> list[str]:
    """Return the studies."""
    return options("study", CONF)


def forms(part: Any) -> list[Schema]:
    """Return the forms that a part of the schema may take, without references and unions."""
    if not isinstance(part, Mapping):
        return []
    if "$ref" in part:
        return forms(whole()["$defs"][part["$ref"].split("/")[-1]])
    for union in ("anyOf", "oneOf", "allOf"):
        if union in part:
            return [form for one in part[union] for form in forms(one)]
    return [part]


def below(found: list[Schema], key: str) -> list[Schema]:
    """Return the forms of what stands under a key."""
    inner: list[Schema] = []
    for form in found:
        if key in form.get("properties", {}):
            inner += forms(form["properties"][key])
        elif isinstance(form.get("additionalProperties"), Mapping):
            inner += forms(form["additionalProperties"])
        elif "items" in form or "prefixItems" in form:
            inner += forms(form.get("items") or form["prefixItems"][0])
    return inner


def places(tree: Any, found: list[Schema], path: str = "") -> Iterator[tuple[str, Any, list[Schema]]]:
    """Yield every key path of a composed study that an override can name, its value and forms; absent fields too."""
    if path:
        yield path, tree, found
    if not isinstance(tree, Mapping):
        return
    for key, value in tree.items():
        name = str(key)
        if name != "sources" and name.isidentifier():
            yield from places(value, below(found, name), f"{path}.{name}" if path else name)
    known = {name for form in found for name in form.get("properties", {})} - {"sources", "defaults"}
    for name in sorted(known - set(map(str, tree))):
        if name.isidentifier():
            yield f"+{path}.{name}" if path else f"+{name}", None, below(found, name)


_KINDS: dict[str, Any] = {
    "a word": "nonesuch",
    "a number": 7.25,
    "a whole number": 3,
    "a truth value": True,
    "a list of numbers": [1, 2],
    "a list of words": ["a", "b"],
    "a mapping": {"nonesuch": 1},
    "a list of lists": [[1], [[2]]],
    "nothing": None,
    "an empty list": [],
    "an empty mapping": {},
    "a reference to nothing": {"from": "search", "value": "nonesuch"},
}
_WRITTEN = {
    "sexagesimal": "1:30",
    "a number in quotes": "'12'",
    "full-width digits": "１２",
    "underscores": "1_000",
    "a value to be given": "???",
    "the environment": "${oc.env:HOME}",
    "an unknown name": "${nonesuch.value}",
    "infinity": "inf",
    "no number": "nan",
    "a number beyond the largest": "1e400",
    "a sweep without end": "range(1,1000000000)",
    "an empty word": "''",
    "a very long word": "'" + "x" * 5000 + "'",
    "a text of other signs": "'<script>{{ 7*7 }} $(touch /tmp/x) ../../etc\\x00'",
}
_NUMBERS = (1e30, -1e30, 1e-30, -1, 0, 1e9, 2**63, -(2**63), 10**30, 0.5)


def takes(found: list[Schema], value: Any) -> bool:
    """Tell whether the schema lets a value stand somewhere, looking at it alone and not into it."""
    return not found or any(_takes(form, value) for form in found)


def _takes(form: Schema, value: Any) -> bool:
    kind = form.get("type")
    if isinstance(kind, list):
        return any(_takes(form | {"type": one}, value) for one in kind)
    if "const" in form or "enum" in form:
        return value in (form.get("enum") or [form["const"]])
    if value is None:
        return kind in (None, "null")
    if isinstance(value, bool):
        return kind in (None, "boolean")
    if isinstance(value, int | float):
        whole_number = float(value).is_integer()
        return kind is None or ((kind == "number" or (kind == "integer" and whole_number)) and _within(form, value))
    if isinstance(value, str):
        return kind is None or (kind == "string" and r"\$\{" not in form.get("pattern", ""))
    if isinstance(value, list):
        return kind is None or (kind == "array" and len(value) >= form.get("minItems", 0) and
                                all(takes(forms(form.get("items")), one) for one in value))  # fmt: skip
    if kind is None:
        return True
    return kind == "object" and _names_fit(form, value)


def _within(form: Schema, value: float) -> bool:
    return (
        value >= form.get("minimum", value)
        and value <= form.get("maximum", value)
        and value > form.get("exclusiveMinimum", value - max(1.0, abs(value)))
        and value < form.get("exclusiveMaximum", value + max(1.0, abs(value)))
    )


def _names_fit(form: Schema, value: Mapping[str, Any]) -> bool:
    if form.get("additionalProperties", True) is not False:
        return True
    return set(value) <= set(form.get("properties", {}))


def wrong(seed: int) -> Iterator[Wrong]:
    """Yield wrong words without end but each once, in an order that the seed gives.

    Arguments
    ---------
    seed : of the generator.
    """
    everything = [one for study in studies() for one in _of_study(study)]
    order = np.random.default_rng(seed).permutation(len(everything))
    for place in order:
        yield everything[place]


def _of_study(study: str) -> Iterator[Wrong]:
    root = forms(whole()["$defs"]["group:study"])
    for path, value, found in places(composed(study).tree, root):
        for kind, other in _KINDS.items():
            yield Wrong(kind, study, f"{path}={_spelled(other)}", not takes(found, other) and other != value)
        for kind, text in _WRITTEN.items():
            number = bool(found) and all(form.get("type") in ("number", "integer") for form in found)
            sure = kind in ("a value to be given", "the environment", "underscores", "an unknown name") or (
                kind in ("infinity", "no number", "sexagesimal", "full-width digits", "a number in quotes") and number
            )
            yield Wrong(kind, study, f"{path}={text}", sure)
        for number in _NUMBERS if any(form.get("type") in ("number", "integer") for form in found) else ():
            yield Wrong("a number out of bounds", study, f"{path}={number!r}", not takes(found, number))
        for form in found:
            if "enum" in form or "const" in form:
                yield Wrong("a choice that is none", study, f"{path}=nonesuch", not takes(found, "nonesuch"))
        if isinstance(value, Mapping):
            yield Wrong("an unknown key", study, f"+{path.lstrip('+')}.nonesuch=1", False)
            yield Wrong("a part taken out", study, f"~{path.lstrip('+')}", False)
        elif not path.startswith("+"):
            yield Wrong("a value taken out", study, f"~{path}", False)
    for group in sorted({path.name for path in CONF.iterdir() if path.is_dir()}):
        for kind, text in {
            "a file that is not there": "nonesuch",
            "a list in place of a file": "[1,2]",
            "a path in place of a file": "../study/solar_reflex",
            "a name of 5000 letters": "a" * 5000,
        }.items():
            yield Wrong(kind, study, f"{group}={text}", True)
    for step in sorted(registry.steps()):
        yield Wrong("an unknown root", study, f"+{step}_nonesuch=1", True)


def _spelled(value: Any) -> str:
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {_spelled(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_spelled, value)) + "]"
    return value if isinstance(value, str) else json.dumps(value)
