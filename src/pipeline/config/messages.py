"""One message a person can act on, from a record that refused its data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import UnionType
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from pipeline.errors import UserError, best_matches

Origin = Callable[[str], str] | str


def explain(
    error: ValidationError, tree: Any, prefix: str, origin: Origin, model: type[BaseModel] | None = None
) -> UserError:
    """Turn a refusal into file, key path, value, what is allowed, and the closest known name.

    Arguments
    ---------
    tree : the data that was refused.
    prefix : key path under which the data stands, may be empty.
    origin : key path -> the file (or override) that set it, or that file's name.
    model : the record that refused, for the names it knows.
    """
    lines: list[str] = []
    for mistake in error.errors(include_url=False):
        path, parent = _key_path(mistake["loc"], tree)
        named = _named_key(mistake, path, tree)
        full = ".".join(part for part in (prefix, *path) if part)
        where = origin if isinstance(origin, str) else origin(f"{full}.{named}" if named else full)
        line = f"{where}: {full}: {_sentence(mistake, path, parent, model)}"
        if line not in lines:
            lines.append(line)
    return UserError("\n".join(lines))


def _key_path(location: tuple[int | str, ...], tree: Any) -> tuple[list[str], Any]:
    """Drop what pydantic adds to a location (names of union members); return the path and the last mapping."""
    path: list[str] = []
    here = parent = tree
    for position, part in enumerate(location):
        last = position == len(location) - 1
        inside = (isinstance(here, Mapping) and part in here) or (
            isinstance(here, list | tuple) and isinstance(part, int) and part < len(here)
        )
        if inside:
            parent, here = here, here[part]
            path.append(str(part))
        elif last and isinstance(here, Mapping) and _is_key(part):
            parent = here
            path.append(str(part))
    return path, parent


def _is_key(part: int | str) -> bool:
    """Tell a missing key from the name of a union's member, which pydantic puts at the same place."""
    words = isinstance(part, str) and part.replace("_", "").isalnum() and part[:1].islower()
    return words and part not in ("float", "int", "str", "bool", "list", "dict")


def _named_key(mistake: Any, path: list[str], tree: Any) -> str | None:
    """Return the key a record's own message begins with, where it is one of the record's: the one to blame."""
    here = tree
    for key in path:
        here = here[int(key)] if isinstance(here, list | tuple) else here.get(key, {})
    word = str(mistake["msg"]).removeprefix("Value error, ").split(" ")[0]
    for key in word.split("."):
        if not isinstance(here, Mapping) or key not in here:
            return None
        here = here[key]
    return word


def _sentence(mistake: Any, path: list[str], parent: Any, model: type[BaseModel] | None) -> str:
    kind, value, message = mistake["type"], mistake["input"], str(mistake["msg"])
    if kind == "extra_forbidden":
        known = _known_names(model, path[:-1])
        return f"unknown key; {best_matches(path[-1], known)}" if known else "unknown key"
    if kind == "missing":
        return "missing"
    message = message.removeprefix("Value error, ")
    shown = f" (value {value!r})" if not isinstance(value, Mapping | list | BaseModel) else ""
    if kind == "literal_error" and isinstance(value, str):
        allowed = [name.strip("' ") for name in mistake["ctx"]["expected"].replace(" or ", ",").split(",")]
        return f"{message}{shown}; {best_matches(value, allowed)}"
    return f"{message}{shown}"


def _known_names(model: type[BaseModel] | None, path: list[str]) -> list[str]:
    """Walk the record's fields along a key path to the names allowed there."""
    candidates = [model] if model is not None else []
    for key in path:
        following: list[type[BaseModel]] = []
        for candidate in candidates:
            field = candidate.model_fields.get(key)
            annotation = field.annotation if field is not None else _extra_type(candidate)
            following.extend(_models(annotation))
        candidates = following or candidates if not key.isdigit() else candidates
    names: list[str] = []
    for candidate in candidates:
        names.extend(field.alias or name for name, field in candidate.model_fields.items())
    return names


def _extra_type(model: type[BaseModel]) -> Any:
    return getattr(model, "__pydantic_extra_type__", None)


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if isinstance(annotation, UnionType) or get_args(annotation):
        return [model for part in get_args(annotation) for model in _models(part)]
    return []
