"""The node that looks at the converters switch by switch."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.config.study import Study
from pipeline.draft import Draft, plain


def switched(study: Study) -> Iterator[Draft]:
    """Yield the node, where the study's converters are given switch by switch."""
    if study.converter is None or study.converter.switched is None or study.panel is None:
        return
    charges = [(comparison, mode) for comparison in study.comparisons for mode in study.run]
    names = [f"charge/{comparison}/{mode}" for comparison, mode in charges]
    panel = study.panel
    yield Draft(
        "switched",
        "switched",
        study.study.name,
        plain(
            {
                "battery": study.battery.model_copy(update={"title": study.battery.name}),
                "switched": study.converter.switched,
                "bus_voltage_v": study.converter.bus_voltage_v,
                "panel_voltage_v": panel.string_voltage_v,
                "panel_current_a": panel.max_power_current_a * panel.panels_in_parallel,
                "charges": charges,
            }
        ),
        inputs={name: name for name in names},
        sections=("battery", "converter", "panel"),
        shown={f"{part}.parquet": f"switched/{part}.parquet" for part in ("periods", "waveform", "edges", "modes")}
        | {"quantities.parquet": "switched/quantities.parquet"},
    )
