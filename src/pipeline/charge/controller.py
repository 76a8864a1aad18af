"""What decides the current at each sample: a sensor, and a network or a plain rule behind it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import ZERO_CELSIUS_K
from pipeline.charge.protocol import Protocol
from pipeline.charge.waveforms import Controller, Sampled
from pipeline.errors import UserError
from pipeline.grnn.charger_network import ChargerNetwork
from pipeline.grnn.network import Network, command, make_network
from pipeline.jit import kernel

Array = NDArray[np.float64]

NETWORK, RATE_SWITCH = range(2)
# What is held from sample to sample: the current decided last, whether the rule has switched, samples taken, and how
# many of them before the current was last interrupted.
_DECIDED, _SWITCHED, _TAKEN, _BEFORE = range(4)


class Control(NamedTuple):
    """A sampled controller as the kernels take it; `held` and `readings` change as it runs."""

    law: int
    network: Network
    capacity_in_use_ah: float
    fast_a: float
    trickle_a: float
    trip_rate_k_s: float
    interval_s: float
    span: int
    step_k: float
    noise_k: Array
    readings: Array
    held: Array


def compile_control(protocol: Protocol, capacity_in_use_ah: float) -> Control:
    """Return the controller of a protocol; one that is never asked where the protocol has none.

    Arguments
    ---------
    capacity_in_use_ah : what a network's C-rate is a multiple of [A h].

    Raises
    ------
    UserError : the network is still to be found.
    """
    course = next((one for one in protocol.courses if isinstance(one.waveform, Sampled)), None)
    if course is None:
        return _NOTHING
    law, network = RATE_SWITCH, _NO_NETWORK
    if isinstance(course.waveform, Controller):
        written = course.waveform.network
        if not isinstance(written, ChargerNetwork):
            raise UserError(f"phases.{course.name}.network: still to be found by {written.source!r}; put it in first")
        law, network = NETWORK, written.compiled()
    samples = math.ceil(protocol.stop["elapsed_s"] / course.values["sample_interval_s"]) + len(protocol.courses) + 1
    return _control(law, network, dict(course.values), capacity_in_use_ah, samples)


def _control(law: int, network: Network, values: dict[str, float], capacity_in_use_ah: float, samples: int) -> Control:
    interval = values.get("sample_interval_s", 1.0)
    span = max(1, round(values.get("rate_span_s", 0.0) / interval))
    deviation = values.get("temperature_noise_k", 0.0)
    stream = np.random.default_rng(int(values.get("noise_stream", 0.0)))
    return Control(
        law,
        network,
        capacity_in_use_ah,
        values.get("fast_a", 0.0),
        values.get("trickle_a", 0.0),
        values.get("trip_rate_k_s", math.inf),
        interval,
        span,
        values.get("temperature_step_k", 0.0),
        deviation * stream.standard_normal(samples) if deviation > 0.0 else np.zeros(1),
        np.zeros(span + 1),
        np.zeros(4),
    )


@kernel
def begin(control: Control) -> None:
    """Start a phase: nothing has been read or decided in it."""
    control.held[_DECIDED] = control.held[_SWITCHED] = 0.0
    control.held[_TAKEN] = control.held[_BEFORE] = 0.0


def interrupt(control: Control) -> None:
    """Let the next sample be as the first of a phase, for a pause lies before it; a rule that has switched stays so."""
    control.held[_BEFORE] = control.held[_TAKEN]


@kernel
def next_current(control: Control, temperature_k: float) -> float:
    """Read the sensor, decide a current for the next sample, and return the one decided at the last [A].

    The first sample of a phase, or after a pause, has no other before it: its current is applied at once.
    """
    held, readings = control.held, control.readings
    taken, since = int(held[_TAKEN]), int(held[_TAKEN] - held[_BEFORE])
    reading = temperature_k - ZERO_CELSIUS_K + control.noise_k[taken % len(control.noise_k)]
    if control.step_k > 0.0:
        reading = control.step_k * math.floor(reading / control.step_k + 0.5)
    places = len(readings)
    readings[taken % places] = reading
    back = min(since, control.span)
    rate = 0.0
    if back > 0:
        rate = (reading - readings[(taken - back) % places]) / (back * control.interval_s)
    decided = _law(control, reading, rate)
    applied = held[_DECIDED] if since > 0 else decided
    held[_DECIDED] = decided
    held[_TAKEN] = taken + 1
    return float(applied)


@kernel
def _law(control: Control, temperature_c: float, rate_k_s: float) -> float:
    if control.law == NETWORK:
        return float(max(0.0, command(control.network, temperature_c, rate_k_s)) * control.capacity_in_use_ah)
    if rate_k_s >= control.trip_rate_k_s:
        control.held[_SWITCHED] = 1.0
    return control.trickle_a if control.held[_SWITCHED] > 0.0 else control.fast_a


_NO_NETWORK = make_network([[0.0, 0.0]], [0.0], widths=1.0)
_NOTHING = _control(RATE_SWITCH, _NO_NETWORK, {}, 0.0, 1)
