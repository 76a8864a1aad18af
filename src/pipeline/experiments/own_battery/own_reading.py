"""Measurement: the files in; rows in order, segments, and what can be told of the battery out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.cell.records import Battery
from pipeline.experiments.own_battery.plausible import ambient_of, soc_at_start
from pipeline.experiments.own_battery.reading import Series, measured_series
from pipeline.experiments.own_battery.records import HeldOut, Measured
from pipeline.experiments.own_battery.segments import (
    CONSTANT_VOLTAGE,
    PULSE,
    REST,
    Segment,
    charge_ah,
    held_out,
    resting_points,
    segments,
    sensors_apart_k,
)
from pipeline.kernel.artefacts import Inputs, Output

YES, PARTLY, NO = "yes", "in part", "no"
_LEVEL = 0.03
_WARM_K, _WARMTH_K = 0.5, 8.0


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Read the files and write what is in them."""
    measured = Measured.model_validate(settings["measured"])
    battery = Battery.model_validate(settings["battery"])
    wanted = HeldOut.model_validate(settings["held_out"])
    stated = list(settings["initial_soc"])
    series = measured_series(measured)
    rows: dict[str, list[Any]] = output.empty("series")
    files, listed, notes, all_segments = [], [], [], []
    for place, one in enumerate(series):
        soc = stated[place] if stated else soc_at_start(one, battery)
        found = segments(one, soc, battery.capacity_in_use_ah)
        out = held_out(one, found, wanted, 0 if len(series) == 1 else place + 1)
        apart = sensors_apart_k(one, found)
        if apart:
            one = one._replace(ambient_c=one.ambient_c + apart)
            notes.append(
                f"{Path(one.file).name}: after long rests the battery's sensor reads {apart:.2f} K more than that of "
                "the surroundings: added to these"
            )
        ambient, how = ambient_of(one, measured)
        moved = np.diff(charge_ah(one))
        files.append(
            (place, Path(one.file).name, len(one.time_s), float(moved[moved > 0].sum()), float(-moved[moved < 0].sum()),
             soc, bool(stated), ambient)
        )  # fmt: skip
        listed += [
            (place, s.kind, s.start_s, s.length_s, s.current_a, s.charge_ah, s.soc, s.start_v, s.end_v, s.first, s.last)
            for s in found
        ]
        all_segments.append(found)
        notes += [f"{Path(one.file).name}: {line}" for line in (*one.said, how)]
        if not stated:
            notes.append(
                f"{Path(one.file).name}: begins at a state of charge of {soc:.3f}, where the start card rests at its "
                "first voltage; own_battery.initial_soc says it"
            )
        count = len(one.time_s)
        rows["file"] += [place] * count
        rows["jumps"] += [one.jumps] * count
        rows["held_out"] += out.tolist()
        for name in ("row", "time_s", "voltage_v", "current_a", "step"):
            rows[name] += getattr(one, name).tolist()
        for name in ("temperature_c", "ambient_c"):
            rows[name] += [None if np.isnan(value) else value for value in getattr(one, name).tolist()]
    output.write("series", rows)
    output.rows("segments", listed)
    output.rows("files", files)
    seen = [place for place, one in enumerate(series) if not wanted.takes(one.file)]
    output.rows(
        "foresight",
        list(_foresight([series[place] for place in seen], [all_segments[place] for place in seen], battery)),
    )
    output.write("notes", {"note": notes})


def _foresight(
    series: Sequence[Series], found: Sequence[Sequence[Segment]], battery: Battery
) -> Iterator[tuple[str, str, str, str]]:
    """Yield what the files that the fit may see can tell: quantity, how far, why, and which test would tell it."""
    flat = [one for group in found for one in group]
    spacing = min(float(np.median(np.diff(one.time_s))) for one in series)
    socs = np.array(
        [value for one in flat for value in (one.soc, one.soc + one.charge_ah / battery.capacity_in_use_ah)]
    )
    low, high = float(socs.min()), float(socs.max())
    rests = [rest for one, group in zip(series, found, strict=True) for rest in resting_points(one, group)]
    levels = _levels([soc for soc, _, _ in rests])
    span = f"the charge moves between {100 * low:.0f} and {100 * high:.0f} %"
    yield (
        "open-circuit voltage", YES if len(levels) >= 5 else PARTLY if rests else NO,
        f"{len(rests)} long rests at {len(levels)} levels; {span}; on one branch of the hysteresis, which is no part "
        "of the model",
        "a discharge in steps of 10 % with an hour of rest after each, and the same while charging",
    )  # fmt: skip
    yield (
        "capacity", YES if high - low > 0.9 else NO,
        f"{span} on the start card", "a full charge, then a discharge to the lowest voltage at C/10 or less",
    )  # fmt: skip
    pulses = [one for one in flat if one.kind == PULSE]
    at = _levels([one.soc for one in pulses])
    yield (
        "series resistance", YES if pulses and spacing <= 0.1 else PARTLY if pulses else NO,
        f"{len(pulses)} pulses at {len(at)} levels, rows {spacing:.3g} s apart: it cannot be told from pairs "
        "faster than that",
        "a 10 s pulse at 50 % with ten rows a second",
    )  # fmt: skip
    longest = max((one.length_s for one in flat if one.kind == REST), default=0.0)
    yield (
        "pairs", YES if longest >= 600.0 else PARTLY if longest >= 60.0 else NO,
        f"time constants between about {2 * spacing:.3g} s and {longest / 2:.3g} s, half of the longest rest",
        "a 10 s pulse and a two-hour rest at 50 %",
    )  # fmt: skip
    warm = [one.temperature_c[~np.isnan(one.temperature_c)] for one in series]
    warm = [one for one in warm if len(one)]
    rise = float(max(one.max() for one in warm) - min(one.min() for one in warm)) if warm else 0.0
    own_rise = max((float(np.ptp(one)) for one in warm), default=0.0)
    yield (
        "temperature dependence", YES if rise >= _WARMTH_K else NO,
        f"temperatures span {rise:.1f} K" if warm else "no temperature is measured",
        "the same test at two temperatures, 15 K apart, with the temperature measured",
    )  # fmt: skip
    yield (
        "heat capacity and cooling", YES if own_rise >= 4 * _WARM_K else PARTLY if own_rise >= _WARM_K else NO,
        f"the temperature moves by {own_rise:.1f} K in a file" if warm else "no temperature is measured",
        "an hour at 1C and an hour of rest, with the battery's and the room's temperature",
    )  # fmt: skip
    held = [one for one in flat if one.kind == CONSTANT_VOLTAGE and one.current_a > 0 and one.length_s > 600.0]
    if battery.side_reaction is not None or battery.acceptance is not None:
        yield (
            "acceptance and side reaction", YES if held and high > 0.97 else NO,
            f"{len(held)} long stretches at a held voltage; {span}",
            "a charge at constant voltage that goes on for hours after the current has fallen to a fiftieth of the "
            "capacity",
        )  # fmt: skip


def _levels(socs: Sequence[float]) -> list[float]:
    found: list[float] = []
    for soc in sorted(socs):
        if not found or soc - found[-1] > _LEVEL:
            found.append(soc)
    return found
