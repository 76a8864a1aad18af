"""The trackers and the converters on the page: what they come to, as sentences and tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from pipeline.experiments.tracking.figures._titles import titles
from pipeline.report.pages import PageFigure, PageSection
from pipeline.report.tables import Cell, ReportData, ReportTable, plain, sentence
from pipeline.report.text import prose

LABELS = ("tracking",)
_STEADY = (
    ("steady_efficiency", "steady / %", 100.0),
    ("ripple_v", "ripple / V", 1.0),
    ("ripple_w", "ripple / W", 1.0),
    ("start_s", "start / s", 1.0),
    ("step_s", "step / s", 1.0),
    ("ramps_efficiency", "ramps / %", 100.0),
    ("worst_ramp", "worst ramp / %", 100.0),
)


def sections(data: ReportData, figures: Sequence[PageFigure]) -> list[PageSection]:
    """Return the sections on trackers and converters; none of what the run did not try.

    Arguments
    ---------
    figures : those of this experiment that the paper does not have.
    """
    found = []
    trackers = [figure for figure in figures if figure.draws != "efficiency_map"]
    if "tracking" in data.inputs:
        text = prose(tracking_text(data))
        found.append(PageSection("trackers-tried", "The trackers", text, tracking_tables(data), trackers))
    if "converters" in data.inputs:
        shown, drawn = [converter_table(data), converter_check(data)], [one for one in figures if one not in trackers]
        found.append(PageSection("converters-by-load", "The converters", converter_text(data), shown, drawn))
    return found


def tracking_tables(data: ReportData) -> list[ReportTable]:
    """Return what the trackers come to in steady light, over days and in shadow; none where none are tried."""
    return [_steady(data), _ramps(data), _days(data), _shadows(data)] if "tracking" in data.inputs else []


def _steady(data: ReportData) -> ReportTable:
    found = data.numbers("tracking")
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (title, *(scale * found[f"{name}_{key}"] for key, _, scale in _STEADY)) for name, title in titles(data).items()
    )
    return ReportTable(
        "trackers",
        "The trackers in steady light and over ramps",
        "Energy captured over energy available. Ripple of the panel's voltage, and of the power from a period of the "
        "tracker to the next, at 1000 W/m². Settling times from near open circuit and after a step to 1000 W/m². "
        "Ramps: mean and least over all ramps of the irradiance.",
        ("tracker", *(title for _, title, _ in _STEADY)),
        rows,
    )


def _ramps(data: ReportData) -> ReportTable:
    found = data.table("tracking", "ramps")
    names = titles(data)
    by_ramp: dict[tuple[str, str, float], dict[str, float]] = {}
    for place, tracker in enumerate(found["tracker"]):
        low, high = found["low_w_m2"][place], found["high_w_m2"][place]
        key = (f"{low:g} to {high:g} W/m²", str(found["group"][place]), float(found["slope_w_m2_s"][place]))
        by_ramp.setdefault(key, {})[str(tracker)] = 100.0 * float(found["efficiency"][place])
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (span, slope, *(own[name] for name in names)) for (span, _, slope), own in by_ramp.items()
    )
    return ReportTable(
        "tracker_ramps",
        "Efficiency of the trackers on each ramp",
        "Energy captured over energy available, in per cent, over all repetitions of a ramp with the dwells between.",
        ("irradiance", "slope / W/m²/s", *names.values()),
        rows,
        grouped=True,
    )


def _days(data: ReportData) -> ReportTable:
    found = data.table("tracking", "day")
    names, skies = titles(data), titles(data, "skies")
    rows: list[tuple[Cell, ...]] = [
        (
            *(skies.get(str(sky), str(sky)), names.get(str(tracker), str(tracker))),
            *(plain(found[key][place]) for key in ("available_wh", "captured_wh")),
            100.0 * float(found["efficiency"][place]),
        )
        for place, (sky, tracker) in enumerate(zip(found["sky"], found["tracker"], strict=True))
    ]
    return ReportTable(
        "tracker_days",
        "The trackers over a day",
        "Energy from the panel between sunrise and sunset.",
        ("day", "tracker", "available / Wh", "captured / Wh", "captured / %"),
        tuple(rows),
        grouped=True,
    )


def _shadows(data: ReportData) -> ReportTable:
    found = data.table("tracking", "shading_ends")
    names = titles(data)
    rows: list[tuple[Cell, ...]] = [
        (
            *(str(scene).replace("_", " "), names.get(str(tracker), str(tracker))),
            *(plain(found[key][place]) for key in ("voltage_v", "power_w", "best_w")),
            100.0 * float(found["share"][place]),
            plain(found["searched_s"][place]),
        )
        for place, (scene, tracker) in enumerate(zip(found["scene"], found["tracker"], strict=True))
    ]
    return ReportTable(
        "tracker_shadows",
        "Where the trackers end in shadow",
        "Each tracker finds the maximum in full light, then the shadow falls at once. What lies below 100 % on a curve "
        "of two maxima is a local one.",
        ("scene", "tracker", "voltage / V", "power / W", "highest / W", "share / %", "settling / s"),
        tuple(rows),
        grouped=True,
    )


def _taken(data: ReportData, steady: Mapping[str, float]) -> str:
    """Say what share of the maximum power the charges take, beside what the trackers reach."""
    supply = data.table("supply", "supply")
    bright = int(np.argmax(supply["panel_power_w"]))
    drawn = float(supply["bus_power_w"][bright]) / float(supply["boost_efficiency"][bright])
    taken = 100.0 * drawn / float(supply["panel_power_w"][bright])
    least, most = min(steady.values()), max(steady.values())
    return (
        f"The charges in the study's own weather take {taken:.2f} % of it as configured, whatever the light; the "
        f"trackers reach {least:.2f} to {most:.2f} % in steady light. The days in the sun run a tracker instead."
    )


def tracking_text(data: ReportData) -> str:
    """Return what the trials of the trackers show, as sentences, every number of which was computed."""
    found, names = data.numbers("tracking"), titles(data)
    steady = {name: 100.0 * found[f"{name}_steady_efficiency"] for name in names}
    worst = {name: 100.0 * found[f"{name}_worst_ramp"] for name in names}
    low, fast, slow = (
        min(steady, key=lambda name: steady[name]),
        max(worst, key=lambda name: worst[name]),
        min(worst, key=lambda name: worst[name]),
    )
    text = [
        f"At 1000 W/m2 in steady light all trackers take at least {steady[low]:.2f} % of what the panel can give "
        f"({names[low]} the least). The worst ramp leaves {names[slow]} {worst[slow]:.1f} %, {names[fast]} "
        f"{worst[fast]:.1f} %; on all of them the cells keep one temperature."
    ]
    if data.holds("supply", "supply"):
        text.append(_taken(data, steady))
    days = data.table("tracking", "day")
    if len(days["tracker"]):
        least, most = int(np.argmin(days["efficiency"])), int(np.argmax(days["efficiency"]))
        text.append(
            f"Over a day, with cells that grow warm, {names[str(days['tracker'][least])]} takes as little as "
            f"{100.0 * days['efficiency'][least]:.1f} %, {names[str(days['tracker'][most])]} up to "
            f"{100.0 * days['efficiency'][most]:.2f} %."
        )
    ends = data.table("tracking", "shading_ends")
    share = {name: 100.0 * float(np.min(ends["share"][ends["tracker"] == name])) for name in names}
    caught = [names[name] for name in names if share[name] < 95.0]
    free = [names[name] for name in names if share[name] >= 95.0]
    if caught:
        text.append(
            f"In partial shadow a curve has several maxima: on some scene {', '.join(caught)} end below 95 % of the "
            f"highest, at worst at {min(share.values()):.0f} %."
        )
    if free:
        ending = f"{min(share[name] for name in names if share[name] >= 95.0):.1f} %"
        text.append(f"{sentence(', '.join(free))} reaches at least {ending} on every one.")
    return " ".join(text)


def converter_table(data: ReportData) -> ReportTable:
    """Return efficiency and losses of both converters at a few loads."""
    found = data.table("converters", "efficiency")
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
    found = data.table("converters", "check")
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
