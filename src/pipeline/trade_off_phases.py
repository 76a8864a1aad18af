"""The node that sets charge time against peak temperature."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.config.study import Study
from pipeline.draft import Draft, plain


def trade_offs(study: Study) -> Iterator[Draft]:
    """Yield the node of a study's trade-off, if it has one."""
    if study.trade_off is None:
        return
    modes = [name for name in study.run if name in (study.trade_off.candidate, study.trade_off.rule)]
    yield Draft(
        "trade_off",
        "trade_off",
        study.study.name,
        {
            "trade_off": _without_titles(plain(study.trade_off)),
            "battery": {**plain(study.battery), "title": study.battery.name},
            "modes": {name: {**plain(study.modes[name]), "title": name} for name in modes},
            "charge": plain(study.charge.model_copy(update={"windows": [], "soc_marks": []})),
            "engine": plain(study.engine),
        },
        inputs={"engine": "engine"},
        sections=("battery", "trade_off", *(f"modes.{name}" for name in modes)),
        shown={f"{part}.parquet": f"trade_off/{part}.parquet" for part in ("trade_off", "quantities")},
    )


def _without_titles(chosen: dict[str, Any]) -> dict[str, Any]:
    """Return the settings with names for titles: changing what only readers see must compute nothing."""
    named = {
        part: {name: one | {"title": name} for name, one in chosen[part].items()} for part in ("conditions", "sensors")
    }
    return chosen | named
