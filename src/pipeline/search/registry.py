"""Search algorithms by name: every module in `pipeline/search/algorithms` is one.

A step that runs a search must carry the digest of `module_name(kind)` in its key: the module is imported by name, which
no look at the sources can see.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Mapping, Sequence
from functools import cache
from importlib import import_module
from typing import Annotated, Any, Protocol, cast

import numpy as np
from pydantic import BeforeValidator, GetJsonSchemaHandler, SerializeAsAny

from pipeline.errors import best_matches
from pipeline.search import algorithms
from pipeline.search.box import Box, History, Objective, SearchSettings, joined
from pipeline.search.streams import generators


class Algorithm(Protocol):
    """What a module of a search algorithm holds; `replicate` and `replicate_alike` are optional."""

    Settings: type[SearchSettings]

    def minimise(self, objective: Objective, box: Box, settings: Any, rng: np.random.Generator) -> History:
        """Run one search."""


@cache
def names() -> tuple[str, ...]:
    """Return the names of all algorithms."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(algorithms.__path__)))


def module_name(kind: str) -> str:
    """Return the dotted name of an algorithm's module.

    Raises
    ------
    ValueError : there is no such algorithm.
    """
    known = names()
    if kind not in known:
        raise ValueError(f"no search algorithm {kind!r}; {best_matches(kind, known)}")
    return f"{algorithms.__name__}.{kind}"


def algorithm(kind: str) -> Algorithm:
    """Return an algorithm by name."""
    return cast(Algorithm, import_module(module_name(kind)))


def settings_from(values: Any) -> Any:
    """Return the settings record that a mapping's `kind` names; anything else as it is."""
    if not isinstance(values, Mapping):
        return values
    kind = values.get("kind")
    if not isinstance(kind, str):
        raise ValueError(f"kind is {kind!r}; it names a search algorithm, {best_matches('', names())}")
    return algorithm(kind).Settings.model_validate(dict(values))


class _OfEveryAlgorithm:
    """The JSON schema of settings: those of any algorithm, which validation finds by their `kind`."""

    def __get_pydantic_json_schema__(self, schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the schemas of all algorithms as alternatives."""
        return {"anyOf": [handler(algorithm(name).Settings.__pydantic_core_schema__) for name in names()]}


AnySettings = Annotated[SerializeAsAny[SearchSettings], BeforeValidator(settings_from), _OfEveryAlgorithm()]
"""A field that takes the settings of whichever algorithm its `kind` names."""


def replicated(objective: Objective, settings: SearchSettings, seed: int) -> History:
    """Run a search with all its replicates; number i draws from SeedSequence([seed, i]).

    Arguments
    ---------
    objective : positions (n, d) to values (n,).
    settings : of any algorithm; they hold the box and the number of replicates.
    seed : root of the random streams.

    Returns
    -------
    History of all replicates.
    """
    module, box = algorithm(settings.kind), settings.box()
    together = getattr(module, "replicate", None)
    if together is not None:
        return cast(History, together(objective, box, settings, seed))
    random = generators(seed, 0, settings.replicates)
    return joined([module.minimise(objective, box, settings, rng) for rng in random])


def replicated_alike(tasks: Sequence[tuple[Objective, Box, SearchSettings]], seed: int) -> list[History]:
    """Run several searches with all their replicates, side by side where their algorithm can; the results are the same.

    Arguments
    ---------
    tasks : objective, box and settings of each search.
    seed : root of the random streams.
    """
    module = algorithm(tasks[0][2].kind)
    together = getattr(module, "replicate_alike", None)
    if together is not None and len({(one.kind, one.replicates) for _, _, one in tasks}) == 1:
        return cast(list[History], together(tasks, seed))
    return [replicated(objective, settings, seed) for objective, _, settings in tasks]
