"""Checks of what samples the battery, and of the stops that need a steady current."""

from __future__ import annotations

import math
from collections.abc import Mapping

from pipeline.charge.records import Mode
from pipeline.charge.waveforms import Sampled
from pipeline.errors import UserError

MOST_SAMPLES = 20_000_000
SHORTEST_SAMPLE_S = 1e-3
MOST_SAMPLES_A_SPAN = 100_000
WATCHED = ("voltage_drop_v", "temperature_rate_k_s")


def check_sampled(where: str, values: Mapping[str, float], stop_s: float) -> None:
    """Check the sensor and the currents of a sampled controller.

    Arguments
    ---------
    where : key path of the phase.
    values : its parameters; one still to be found is left out.
    stop_s : time at which the charge is given up [s].

    Raises
    ------
    UserError : with the key path, the value and what is allowed.
    """
    interval, span = values.get("sample_interval_s"), values.get("rate_span_s", 0.0)
    if interval is None:
        return
    if interval < SHORTEST_SAMPLE_S:
        raise UserError(f"{where}.sample_interval_s: {interval:g} s; allowed is {SHORTEST_SAMPLE_S:g} s or more")
    if stop_s / interval > MOST_SAMPLES:
        raise UserError(
            f"{where}.sample_interval_s: {interval:g} s up to stop.elapsed_s {stop_s:g} s are more than "
            f"{MOST_SAMPLES} samples"
        )
    samples = round(span / interval)
    if span > 0.0 and (samples < 1 or abs(samples * interval - span) > 1e-9 * span or samples > MOST_SAMPLES_A_SPAN):
        raise UserError(
            f"{where}.rate_span_s: {span:g} s is no whole number of samples of {interval:g} s, "
            f"from 1 to {MOST_SAMPLES_A_SPAN}; give a multiple, or 0 for one sample"
        )
    if values.get("trickle_a", 0.0) >= values.get("fast_a", math.inf):
        raise UserError(f"{where}.trickle_a: {values['trickle_a']:g} A is not below fast_a, {values['fast_a']:g} A")
    stream = values.get("noise_stream", 0.0)
    if stream != int(stream):
        raise UserError(f"{where}.noise_stream: {stream:g}; allowed is a whole number, 0 or more")


def check_watched(mode: Mode) -> None:
    """Check that nobody watches for a falling voltage or a rising rate where pulses make them by themselves.

    Raises
    ------
    UserError : with the key path.
    """
    pulsed = [name for name, phase in mode.phases.items() if phase.waveform.periodic]
    places = [(f"phases.{name}.until", mode.phases[name].until, name in pulsed) for name in mode.phases]
    for where, until, wrong in [*places, ("stop", mode.stop, bool(pulsed))]:
        for name in WATCHED:
            if wrong and getattr(until, name) is not None:
                raise UserError(f"{where}.{name}: needs a steady current; pulses change voltage and heat by themselves")
    sampled = [phase.waveform for phase in mode.phases.values() if isinstance(phase.waveform, Sampled)]
    if any(other != sampled[0] for other in sampled[1:]):
        raise UserError("phases: a mode has one controller; those of its phases differ")
