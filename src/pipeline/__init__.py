"""Declarative battery charging studies: configuration in, charge traces, figures and verdicts out.

In a notebook, `charge`, `compare`, `sweep`, `battery` and `mode` are words of this package; nothing is imported before
they are used.

>>> import pipeline as cp
>>> charge = cp.charge(battery="lead_acid_12v7ah", mode="cc_cv", initial_soc=0.8)
>>> charge.summary.units["end_time_s"]
's'
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

_WORDS = {
    **dict.fromkeys(("charge", "compare", "sweep"), "pipeline.notebook.charges"),
    **dict.fromkeys(("battery", "mode"), "pipeline.notebook.named"),
}


class _Room(ModuleType):
    """A room whose name is a word of the notebook too: `pipeline.charge` holds the engine, and charges when called."""

    def __call__(self, *given: Any, **choices: Any) -> Any:
        return _word(self.__name__.rpartition(".")[2])(*given, **choices)


class _Package(ModuleType):
    def __setattr__(self, name: str, value: Any) -> None:
        if name in _WORDS and isinstance(value, ModuleType):
            value.__class__ = _Room
        super().__setattr__(name, value)


def _word(name: str) -> Any:
    return getattr(import_module(_WORDS[name]), name)


def __getattr__(name: str) -> Any:
    if name == "charge":
        return import_module("pipeline.charge")
    if name in _WORDS:
        return _word(name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *_WORDS})


sys.modules[__name__].__class__ = _Package
