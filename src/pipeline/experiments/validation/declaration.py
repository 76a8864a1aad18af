"""The engine held against closed forms, state functions and independent codes: the step and a node for each check."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import Field

from pipeline.experiments.validation.records import Validation
from pipeline.experiments.validation.registry import CHECKS, VALIDATION, installed, module_name
from pipeline.kernel.draft import plain, untitled
from pipeline.kernel.experiment import Experiment, Node, Step
from pipeline.record import Record

_COMPARED = ("battery", "charge.initial_soc", "charge.ambient_c")
"""What a check against another code reads beside its own part."""


class ValidationPart(Record):
    """What the engine is held against."""

    validation: Validation | None = Field(default=None, description="what the engine is held against, and nothing else")


def _settings(config: Any, check: str, part: str | None, compared: tuple[str, ...]) -> Mapping[str, Any]:
    settings = {} if part is None else plain(getattr(config.validation, part))
    peer = CHECKS[check].peer
    if peer is not None:
        settings |= {
            "initial_soc": config.charge.initial_soc,
            "ambient_c": config.charge.ambient_c,
            # Titles are for readers, and changing one must compute nothing.
            "battery": untitled(config.battery, config.battery.name),
            "version": installed(peer),
        }
    return {"check": check, "settings": settings}


VALIDATION_STEP = Step(
    "validation",
    rule="check_engine",
    message="Validation: {chunk}",
    settings=_settings,
    reads=("validation.{part}", "{compared}"),
    tables=VALIDATION,
    usual_table="rows",
)


def nodes(study: Any) -> Iterator[Node]:
    """Yield a node for each check; those of another code depend on the version of it that is installed here."""
    if study.validation is None:
        return
    for name, check in CHECKS.items():
        yield Node(
            VALIDATION_STEP,
            f"validation/{name}",
            name,
            {"check": name, "part": check.settings, "compared": () if check.peer is None else _COMPARED},
            shown={one.file: f"{name}.{one.file}" for one in VALIDATION.values()},
            modules=(module_name(name),),
        )


EXPERIMENT = Experiment(
    title="the engine against closed forms, the first law and independent codes",
    steps=(VALIDATION_STEP,),
    nodes=nodes,
    part=ValidationPart,
    parameters=("validation",),
    inputs=lambda study: () if study.validation is None else [f"validation/{name}" for name in CHECKS],
    alone=lambda study: study.validation is not None,
)
