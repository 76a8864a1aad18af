"""The report's tables of the converters over their load."""

from __future__ import annotations

import numpy as np

from pipeline.report.data import ReportData
from pipeline.report.tables import Cell, ReportTable, plain


def converter_table(data: ReportData) -> ReportTable:
    """Return efficiency and losses of both converters at a few loads."""
    found = data.table("converters", "converters_efficiency")
    names = ("efficiency", "duty", "switch_w", "rectifier_w", "winding_w", "capacitor_w", "switching_w", "core_w")
    rows: list[tuple[Cell, ...]] = []
    for which, name in (("boost", "source_v"), ("buck", "sink_v")):
        own = np.flatnonzero(found["converter"] == which)
        for voltage in np.unique(found[name][own]):
            at = own[found[name][own] == voltage]
            for place in at[:: max(1, (len(at) - 1) // 4)]:
                volts = f"{which}, {found['source_v'][place]:.1f} V to {found['sink_v'][place]:.1f} V"
                numbers = (plain(found[key][place]) for key in (*names, "control_w"))
                rows.append((volts, plain(found["power_w"][place]), *numbers))
    return ReportTable(
        "converters",
        "The converters by load",
        "From their parts: conduction in every resistance and forward voltage, edges and capacitance of the switches, "
        "the inductor's core, the controller. The parts are estimates.",
        (
            *("converter", "input / W", "efficiency", "duty", "switch / W", "rectifier / W", "winding / W"),
            *("capacitor / W", "switching / W", "core / W", "control / W"),
        ),
        tuple(rows),
        grouped=True,
    )


def converter_check(data: ReportData) -> ReportTable:
    """Return the conduction losses of the averaged converters beside those switch by switch."""
    found = data.table("converters", "converters_check")
    rows: list[tuple[Cell, ...]] = []
    for row in zip(*(found[name] for name in found), strict=True):
        which, *numbers = map(plain, row)
        rows.append((which, *numbers, 1e6 * (float(row[-2]) - float(row[-1]))))
    return ReportTable(
        "converters_check",
        "The averaged converters against the switches",
        "Efficiency with conduction losses alone: of the averaged model, and of the same parts run switch by switch.",
        ("converter", "input / V", "output / V", "input / W", "averaged", "switched", "difference / ppm"),
        tuple(rows),
        grouped=True,
    )


def converter_text(data: ReportData) -> str:
    """Return what the parts come to, as sentences, every number of which was computed."""
    found = data.numbers("converters")
    supply = data.table("supply", "supply")
    text = []
    for which in ("boost", "buck"):
        if f"{which}_full_efficiency" not in found:
            continue
        used = 100.0 * float(supply[f"{which}_efficiency"][0])
        full, best, at_w = (found[f"{which}_{name}"] for name in ("full_efficiency", "best_efficiency", "best_w"))
        text.append(
            f"The {which} converter's parts give {100.0 * full:.1f} % at the panel's maximum power and at best "
            f"{100.0 * best:.1f} %, at {at_w:.0f} W; the charges of this run take {used:.1f} %."
        )
    off = max((found[name] for name in found if name.endswith("_off_switched")), default=None)
    if off is not None:
        text.append(f"Their conduction losses agree with the switches to {1e6 * off:.0f} ppm of the input power.")
    return " ".join(text)
