"""Studies of the runs of a sweep: validated and checked by section, with memory of those that did not change.

What is refused, and how it is told, is left to `study_from`: whatever fails here is looked at there again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from types import FunctionType, MethodType
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError, create_model

from pipeline.config.compose import Composed
from pipeline.config.many import Memory
from pipeline.config.sources import attribute, check_found, found_values, leaves, split
from pipeline.config.study import study_from, study_type, without_unnamed
from pipeline.errors import UserError
from pipeline.kernel import registry, scope
from pipeline.published.vocabulary import check_statements
from pipeline.record import Record

_OWN = ("overrides", "configuration", "sources")


class _Unlike(Exception):
    """Not as it was expected; `study_from` says what is wrong, if anything is."""


class Seen:
    """A record that notes which of its fields are read.

    Arguments
    ---------
    record : the record.
    seen : field -> its value, filled as they are read.
    """

    def __init__(self, record: Any, seen: dict[str, Any]) -> None:
        self._record, self._seen = record, seen

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        found = scope.member(type(self._record), name)
        if isinstance(found, property) and found.fget is not None:
            return found.fget(self)
        if isinstance(found, FunctionType):
            return MethodType(found, self)
        value = getattr(self._record, name)
        self._seen[name] = value
        return value


class Recalled:
    """A function of a study, worked out again only where a field that it reads is another one.

    Arguments
    ---------
    function : `(study) -> value`, of nothing but what it reads of the study.
    """

    def __init__(self, function: Callable[[Any], Any]) -> None:
        self._function = function
        # Names of the fields read -> their identities -> the fields, kept alive, and the result.
        self._known: dict[tuple[str, ...], dict[tuple[int, ...], tuple[Any, Any]]] = {}

    def __call__(self, study: Any) -> Any:
        """Return the value for a study; what the function raises is raised, and not kept."""
        for names, found in self._known.items():
            key = tuple(id(getattr(study, name)) for name in names)
            if key in found:
                return found[key][1]
        seen: dict[str, Any] = {}
        result = self._function(Seen(study, seen))
        key = tuple(id(value) for value in seen.values())
        self._known.setdefault(tuple(seen), {})[key] = tuple(seen.values()), result
        return result


class Studies:
    """Makes the study of run after run.

    Arguments
    ---------
    memory : the one that the configurations were composed with.
    """

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._made: dict[Any, tuple[Any, Any]] = {}
        checks = [check for one in registry.experiments().values() for check in one.checks]
        self._checks = [Recalled(check) for check in (*checks, check_statements)]
        self._finds = Recalled(found_values)
        self.whole = 0
        """How many studies were made by `study_from`."""

    def of(self, composed: Composed) -> Any:
        """Return the study of a composed configuration, without sources; errors are those of `study_from`.

        Its `overrides` are the keys alone.
        """
        try:
            return self._of(composed)
        except (_Unlike, UserError, ValidationError, AttributeError, TypeError, KeyError):
            self.whole += 1
            study = study_from(composed)
            return study.model_copy(update={"sources": {}})

    def _of(self, composed: Composed) -> Any:
        keys = tuple(word.split("=", 1)[0] for word in composed.overrides)
        if any("sources" in key.split(".") for key in keys) or not self._made:
            # A first one is looked at whole.
            study_from(composed)
        values, written = self._divided(composed)
        whole = values
        values, left_out = without_unnamed(values)
        touched = {path for path in left_out if composed.touched(path)}
        if touched:
            self._fields(self._memory.tree(without_unnamed(whole, touched)[0]))
        values = self._memory.tree(values)
        fields = self._fields(values)
        told = self._once(("keys", keys), keys, lambda: tuple(f"{key}=" for key in keys if key != "study"))
        configuration = {key: value for key, value in values.items() if key != "limits"}
        empty = self._once("no sources", None, dict)
        study = study_type().model_construct(**fields, overrides=told, configuration=configuration, sources=empty)
        by_section: dict[str, dict[str, Any]] = {}
        for path, source in written.items():
            by_section.setdefault(path.split(".", 1)[0], {})[path] = source
        asked = [
            one for path in study.parameter_sections() for one in self._attributed(composed, values, by_section, path)
        ]
        check_found(asked, self._finds(study), told)
        for check in self._checks:
            check(study)
        return study

    def _divided(self, composed: Composed) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the values and, by key path, the sources as written."""
        values: dict[str, Any] = {}
        written: dict[str, Any] = {}
        for key, section in composed.tree.items():
            own, said = self._split(key, section)
            values |= own
            written |= said
        if {*_OWN, "run"} & set(values) or any(path.split(".")[0] not in values for path in written):
            raise _Unlike
        for one in registry.experiments().values():
            if one.prepare is not None:
                values = one.prepare(composed, values, written)
        return values, written

    def _fields(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the validated fields of the root record that the values give."""
        if set(values) - set(study_type().model_fields):
            raise _Unlike
        return {name: self._field(name, value) for name, value in values.items()}

    def _field(self, name: str, value: Any) -> Any:
        if not _of_entries(name) or not isinstance(value, dict) or not value:
            return self._once((name, id(value)), value, lambda: _validated(name, value))
        entries = {key: self._entry(name, key, one) for key, one in value.items()}
        identity = (name, tuple((key, id(one)) for key, one in entries.items()))
        return self._once(identity, list(entries.values()), lambda: entries)

    def _entry(self, name: str, key: str, value: Any) -> Any:
        return self._once((name, key, id(value)), value, lambda: _validated(name, {key: value})[key])

    def _attributed(
        self, composed: Composed, values: Mapping[str, Any], written: Mapping[str, Any], path: str
    ) -> list[tuple[str, Any]]:
        """Return the references of a section, each with its key path; every number of it has a source."""
        here: Any = values
        for key in path.split("."):
            here = here.get(key, {}) if isinstance(here, Mapping) else {}
        words = tuple(word for word in composed.overrides if _touches(word.split("=", 1)[0], path))

        def look() -> list[tuple[str, Any]]:
            said = written.get(path.split(".")[0], {})
            related = (one for one in said if f"{one}.".startswith(f"{path}.") or path.startswith(f"{one}."))
            attribute(composed, values, {one: said[one] for one in related}, (path,))
            return [(one, value) for one, value in leaves(here, path) if isinstance(value, Mapping)]

        found: list[tuple[str, Any]] = self._once(("sources", path, id(here), words), here, look)
        return found

    def _split(self, key: str, section: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        found: tuple[dict[str, Any], dict[str, Any]]
        found = self._once(("split", key, id(section)), section, lambda: split({key: section}))
        return found

    def _once(self, key: Any, alive: Any, make: Callable[[], Any]) -> Any:
        """Return what is made under a key, made once; what the key identifies is kept alive."""
        if key not in self._made:
            self._made[key] = alive, make()
        return self._made[key][1]


@cache
def _touches(key: str, path: str) -> bool:
    """Tell whether an override of a key sets a section, a part of it, or what it is a part of."""
    group, _, package = key.lstrip("+~").partition("@")
    key = package or group
    return f"{key}.".startswith(f"{path}.") or f"{path}.".startswith(f"{key}.")


@cache
def _of_entries(name: str) -> bool:
    """Tell whether a field of the root record is a mapping whose entries are validated by themselves."""
    annotation = study_type().model_fields[name].annotation
    return get_origin(annotation) is dict and get_args(annotation)[0] is str


@cache
def _alone(name: str) -> type[BaseModel]:
    """Return a record with one field of the root record."""
    field = study_type().model_fields[name]
    fields: dict[str, Any] = {name: (field.annotation, field)}
    return create_model(f"Study_{name}", __base__=Record, **fields)


def _validated(name: str, value: Any) -> Any:
    return getattr(_alone(name)(**{name: value}), name)
