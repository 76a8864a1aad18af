"""The node that tries the trackers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.config.study import Study
from pipeline.draft import Draft, plain

_TABLES = ("ramps", "course", "day", "shading_curves", "shading_ends", "quantities")


def tracking(study: Study) -> Iterator[Draft]:
    """Yield the node, where trackers are to be tried and the boost converter is given by its parts."""
    chain = study.converter
    if study.panel is None or study.tracking is None or not study.trackers or chain is None or chain.switched is None:
        return
    yield Draft(
        "tracking",
        "tracking",
        study.study.name,
        plain(
            {
                "panel": study.panel.model_copy(update={"title": "panel"}),
                "boost": chain.switched.boost,
                "bus_voltage_v": chain.bus_voltage_v,
                "trackers": {name: card.model_copy(update={"title": name}) for name, card in study.trackers.items()},
                "tracking": study.tracking,
                "seed": study.seed,
            }
        ),
        inputs={"panel": "panel"},
        sections=("panel", "converter", "trackers", "tracking"),
        shown={f"{part}.parquet": f"tracking/{part}.parquet" for part in _TABLES},
    )


def tracking_titles(study: Study) -> dict[str, Any]:
    """Return what readers of the trials need to name trackers and days."""
    skies = {} if study.tracking is None else study.tracking.skies
    return {
        "trackers": {name: card.title for name, card in study.trackers.items()},
        "skies": {name: sky.title for name, sky in skies.items()},
    }
