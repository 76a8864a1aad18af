"""One message a person can act on, from a record that refused its data."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from pipeline.errors import UserError, best_matches

Origin = Callable[[str], str] | str
_LONGEST = 1200
_PLAIN = ("float", "int", "str", "bool", "list", "dict", "constrained-float", "constrained-int", "constrained-str")


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
    for mistake in _told(error.errors(include_url=False), tree):
        path, parent = _key_path(mistake["loc"], tree)
        named = _named_key(mistake, path, tree)
        full = ".".join(part for part in (prefix, *path) if part)
        where = origin if isinstance(origin, str) else origin(f"{full}.{named}" if named else full)
        line = f"{where}: {full}: {_sentence(mistake, path, parent, model)}"[:_LONGEST]
        if line not in lines:
            lines.append(line)
    return UserError("\n".join(lines))


def _told(mistakes: Sequence[Any], tree: Any) -> Iterator[Any]:
    """Leave out what the other forms of a value say where its keys are those of one, and join it where of none."""
    forms: dict[tuple[str, ...], dict[int | str, list[Any]]] = {}
    for mistake in mistakes:
        path, form = _form(mistake["loc"], tree)
        if form is not None:
            forms.setdefault(path, {}).setdefault(form, []).append(mistake)
    for mistake in mistakes:
        path, form = _form(mistake["loc"], tree)
        members = forms.get(path, {})
        if form is None or len(members) < 2:
            yield mistake
            continue
        fitting = [name for name, said in members.items() if not any(_of_another_form(one) for one in said)]
        if form in fitting:
            yield mistake
        elif not fitting:
            yield {"type": "no_form", "loc": path, "input": _at(tree, path), "msg": ""}


def _form(location: tuple[int | str, ...], tree: Any) -> tuple[tuple[str, ...], int | str | None]:
    """Return the key path of a value that has several forms and the one a mistake is about, if it is such."""
    here = tree
    for place, part in enumerate(location):
        if _holds(here, part):
            here = here[part]
        elif isinstance(part, str) and (part in _PLAIN or part[:1].isupper() or "[" in part):
            return tuple(str(key) for key in location[:place]), part
        else:
            break
    return tuple(str(key) for key in location), None


def _holds(here: Any, part: int | str) -> bool:
    listed = isinstance(here, list | tuple) and isinstance(part, int) and part < len(here)
    return listed or (isinstance(here, Mapping) and part in here)


def _of_another_form(mistake: Any) -> bool:
    return mistake["type"] in ("missing", "extra_forbidden", "model_type", "float_type", "float_parsing", "dict_type")


def _key_path(location: tuple[int | str, ...], tree: Any) -> tuple[list[str], Any]:
    """Drop what pydantic adds to a location (names of union members); return the path and the last mapping."""
    path: list[str] = []
    here = parent = tree
    for position, part in enumerate(location):
        last = position == len(location) - 1
        if _holds(here, part):
            parent, here = here, here[part]
            path.append(str(part))
        elif last and isinstance(here, Mapping) and _is_key(part):
            parent = here
            path.append(str(part))
    return path, parent


def _is_key(part: int | str) -> bool:
    """Tell a missing key from the name of a union's member, which pydantic puts at the same place."""
    words = isinstance(part, str) and part.replace("_", "").isalnum() and part[:1].islower()
    return words and part not in _PLAIN


def _named_key(mistake: Any, path: list[str], tree: Any) -> str | None:
    """Return the key a record's own message begins with, where it is one of the record's: the one to blame."""
    if mistake["type"] == "union_tag_invalid":
        return _bare(mistake["ctx"]["discriminator"])
    here = _at(tree, path)
    word = str(mistake["msg"]).removeprefix("Value error, ").split(" ")[0]
    for key in word.split("."):
        if not isinstance(here, Mapping) or key not in here:
            return None
        here = here[key]
    return word


def _at(tree: Any, path: Sequence[str]) -> Any:
    for key in path:
        tree = tree[int(key)] if isinstance(tree, list | tuple) else tree.get(key, {})
    return tree


def _sentence(mistake: Any, path: list[str], parent: Any, model: type[BaseModel] | None) -> str:
    kind, value, message = mistake["type"], mistake["input"], str(mistake["msg"])
    if kind == "extra_forbidden":
        known = _known_names(model, path[:-1])
        return f"unknown key; {best_matches(path[-1], known)}" if known else "unknown key"
    if kind == "missing":
        meant = {field.description for field in _fields(model, path) if field.description}
        return f"missing; {meant.pop()}" if len(meant) == 1 else "missing"
    if kind == "no_form":
        shown = (
            f"the keys {', '.join(map(str, value))} make" if isinstance(value, Mapping) else f"value {short(value)} is"
        )
        return f"{shown} none of its forms; allowed is {' or '.join(['a number', *_forms(model, path)])}"
    if kind == "model_type":
        return f"value {short(value)}; allowed is a mapping, {' or '.join(_forms(model, path))}"
    if kind == "union_tag_invalid":
        key, tag, tags = (str(mistake["ctx"][name]) for name in ("discriminator", "tag", "expected_tags"))
        return f"{_bare(key)} is {tag!r}; {best_matches(tag, map(_bare, tags.split(',')))}"
    allowed = _allowed(kind, mistake.get("ctx", {}))
    if allowed is not None:
        return f"value {short(value)}; allowed is {allowed}"
    message = message.removeprefix("Value error, ")
    shown = f" (value {short(value)})" if not isinstance(value, Mapping | list | BaseModel) else ""
    if kind == "literal_error" and isinstance(value, str):
        allowed = mistake["ctx"]["expected"].replace(" or ", ",").split(",")
        return f"{message}{shown}; {best_matches(value, map(_bare, allowed))}"
    return f"{message}{shown}"


def _allowed(kind: str, bounds: Mapping[str, Any]) -> str | None:
    """Return what is allowed where pydantic refused by a kind of its own, in words; None where a record says it."""
    words = {
        "greater_than": "more than {gt:.12g}",
        "greater_than_equal": "{ge:.12g} or more",
        "less_than": "less than {lt:.12g}",
        "less_than_equal": "{le:.12g} or less",
        "finite_number": "a finite number",
        "multiple_of": "a multiple of {multiple_of:.12g}",
        "string_too_short": "a text of {min_length} letters or more",
        "string_too_long": "a text of {max_length} letters at most",
        "too_short": "a list of {min_length} or more",
        "too_long": "a list of {max_length} at most",
        **dict.fromkeys(("float_type", "float_parsing"), "a number"),
        **dict.fromkeys(("int_type", "int_parsing", "int_from_float", "int_parsing_size"), "a whole number"),
        **dict.fromkeys(("string_type",), "a text"),
        **dict.fromkeys(("bool_type", "bool_parsing"), "true or false"),
        **dict.fromkeys(("list_type", "tuple_type"), "a list"),
        **dict.fromkeys(("dict_type", "mapping_type"), "a mapping of names to values"),
    }
    try:
        return words[kind].format(**bounds) if kind in words else None
    except (ValueError, TypeError):  # a bound that is no number
        return None


def short(value: Any) -> str:
    """Return a value as a message shows it, cut where it is long."""
    text = repr(value)
    return text if len(text) <= 120 else f"{text[:120]}..."


def _bare(name: str) -> str:
    return name.strip("' ")


def _known_names(model: type[BaseModel] | None, path: list[str]) -> list[str]:
    """Walk the record's fields along a key path to the names allowed there."""
    return [field.alias or name for one in _records(model, path) for name, field in one.model_fields.items()]


def _records(model: type[BaseModel] | None, path: Sequence[str]) -> list[type[BaseModel]]:
    """Return the records that may stand at a key path."""
    candidates = [model] if model is not None else []
    names = iter(path)
    for key in names:
        if key.isdigit():
            continue
        fields = [candidate.model_fields.get(key) for candidate in candidates]
        types = [
            field.annotation if field is not None else _extra_type(candidate)
            for field, candidate in zip(fields, candidates, strict=True)
        ]
        candidates = [found for annotation in types for found in _models(annotation)] or candidates
        if any(_maps(annotation) for annotation in types):
            next(names, None)  # the name of an entry
    return candidates


def _fields(model: type[BaseModel] | None, path: Sequence[str]) -> list[FieldInfo]:
    """Return the fields that may stand at a key path."""
    found = (record.model_fields.get(path[-1]) for record in _records(model, path[:-1])) if path else ()
    return [field for field in found if field is not None]


def _forms(model: type[BaseModel] | None, path: Sequence[str]) -> list[str]:
    """Return the keys that each of the records at a key path must have."""
    return [
        "{" + ", ".join(field.alias or name for name, field in record.model_fields.items() if field.is_required()) + "}"
        for record in _records(model, path)
    ]


def _extra_type(model: type[BaseModel]) -> Any:
    """Return the type of the keys beside a record's fields, where it takes any."""
    return get_args(get_type_hints(model)["__pydantic_extra__"])[1] if model.model_config["extra"] == "allow" else None


def _maps(annotation: Any) -> bool:
    return get_origin(annotation) is dict or any(_maps(part) for part in get_args(annotation))


def _models(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if isinstance(annotation, UnionType) or get_args(annotation):
        return [model for part in get_args(annotation) for model in _models(part)]
    return []
