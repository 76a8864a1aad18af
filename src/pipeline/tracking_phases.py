"""The nodes that try the trackers, and that look at the converters by their parts."""

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
            }
        ),
        inputs={"panel": "panel"},
        sections=("panel", "converter", "trackers", "tracking"),
        shown={f"{part}.parquet": f"tracking/{part}.parquet" for part in _TABLES},
    )


def converters(study: Study) -> Iterator[Draft]:
    """Yield the node, where the converters are given by their parts and losses."""
    panel, chain = study.panel, study.converter
    if panel is None or chain is None or chain.switched is None or chain.losses is None:
        return
    panels = panel.panels_in_series * panel.panels_in_parallel
    yield Draft(
        "converters",
        "converters",
        study.study.name,
        plain(
            {
                "converter": chain.model_copy(update={"title": "converters"}),
                "panel_voltage_v": panel.string_voltage_v,
                "panel_power_w": panel.max_power_voltage_v * panel.max_power_current_a * panels,
            }
        ),
        sections=("panel", "converter"),
        shown={f"{part}.parquet": f"converters/{part}.parquet" for part in ("efficiency", "check", "quantities")},
    )


def tracking_titles(study: Study) -> dict[str, Any]:
    """Return what readers of the trials need to name trackers and days."""
    skies = {} if study.tracking is None else study.tracking.skies
    return {
        "trackers": {name: card.title for name, card in study.trackers.items()},
        "skies": {name: sky.title for name, sky in skies.items()},
    }
