"""The nodes that hold the engine against closed forms, state functions and independent codes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.config.study import Study
from pipeline.draft import Draft, plain
from pipeline.validation.registry import CHECKS, Check, installed, module_name


def validation(study: Study) -> Iterator[Draft]:
    """Yield a node for each check; those of another code depend on the version of it that is installed here."""
    if study.validation is None:
        return
    for name, check in CHECKS.items():
        yield Draft(
            "validation",
            f"validation/{name}",
            name,
            {"check": name, "settings": _settings(study, check)},
            sections=("validation", "battery", "charge"),
            shown={f"{part}.parquet": f"{name}.{part}.parquet" for part in ("rows", "curves")},
            modules=(module_name(name),),
        )


def _settings(study: Study, check: Check) -> dict[str, Any]:
    part = {} if check.settings is None else plain(getattr(study.validation, check.settings))
    if check.peer is None:
        return dict(part)
    battery = study.battery.model_copy(update={"title": study.battery.name})
    start = {"initial_soc": study.charge.initial_soc, "ambient_c": study.charge.ambient_c}
    return {**part, **start, "battery": plain(battery), "version": installed(check.peer)}


def headings(study: Study) -> dict[str, Any]:
    """Return what the page says of each check, where the study has them."""
    if study.validation is None:
        return {}
    return {"checks": [{"name": name, "title": check.title, "text": check.text} for name, check in CHECKS.items()]}
