"""A protocol as the kernels take it: arrays, one row a course."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.cell.circuit import REFERENCE_K, ZERO_CELSIUS_K
from pipeline.charge.protocol import Course, Protocol
from pipeline.charge.segment import FIRST_WATCHED, PLACES, STAGE_EDGE, WATCHED
from pipeline.charge.waveforms import Sampled
from pipeline.jit import inlined

MOST_SEGMENTS = 3
# Where a battery counts as full: the kernels keep 1 - SOC above zero.
_FULL = 1e-12
# A temperature this far over a clamp is beyond it, so that none is crossed to and fro.
_CHATTER_K = 1e-9
# Frequency above which strides over periods pay.
AVERAGED_ABOVE_HZ = 2.0


class Program(NamedTuple):
    """Arrays of a protocol; voltages are of one cell, SOC stands as 1 - SOC, what is not asked for is out of reach.

    The current of a course that is `sampled` is written anew as each of its periods begins.
    """

    segments: NDArray[np.int64]
    length_s: NDArray[np.float64]
    current_a: NDArray[np.float64]
    charging: NDArray[np.bool_]
    limit_v: NDArray[np.float64]
    limits: NDArray[np.float64]
    elapsed_s: NDArray[np.float64]
    group: NDArray[np.int64]
    sampled: NDArray[np.bool_]
    averaged: NDArray[np.bool_]
    power_w: NDArray[np.float64]
    stop_elapsed_s: float
    lift_v_k: float
    reference_k: float
    lowest_k: float
    highest_k: float


def compile_program(protocol: Protocol, cells: int, driver: str, units: int = 1) -> Program:
    """Return the arrays of a protocol.

    Arguments
    ---------
    cells : cells in series.
    units : electrochemical cells in each of them, where a model knows only the block.
    driver : `edge`, `averaged` or `auto`; only what repeats is averaged.
    """
    count = len(protocol.courses)
    program = Program(
        np.zeros(count, dtype=np.int64),
        np.zeros((count, MOST_SEGMENTS)),
        np.zeros((count, MOST_SEGMENTS)),
        np.zeros((count, MOST_SEGMENTS), dtype=np.bool_),
        np.full(count, np.inf),
        np.zeros((count, PLACES)),
        np.full(count, np.inf),
        np.zeros(count, dtype=np.int64),
        np.array([isinstance(course.waveform, Sampled) for course in protocol.courses]),
        np.array([_averages(course, driver) for course in protocol.courses]),
        np.array([course.values["power_w"] if course.waveform.holds_power else np.inf for course in protocol.courses]),
        protocol.stop.get("elapsed_s", math.inf),
        protocol.lift.v_per_k_cell * units,
        protocol.lift.reference_c + ZERO_CELSIUS_K,
        protocol.lift.lowest_c + ZERO_CELSIUS_K,
        protocol.lift.highest_c + ZERO_CELSIUS_K,
    )
    for row, course in enumerate(protocol.courses):
        program.segments[row] = len(course.segments)
        for n, segment in enumerate(course.segments):
            program.length_s[row, n] = segment.length_s
            program.current_a[row, n] = segment.current_a
            program.charging[row, n] = segment.charging
        if course.limit_v is not None:
            program.limit_v[row] = course.limit_v / cells
        program.limits[row, :4] = _limits(course.until, cells)
        program.limits[row, 4:8] = _limits(protocol.stop, cells)
        program.limits[row, STAGE_EDGE] = -1.0 if course.edge_soc is None else 1.0 - course.edge_soc
        watched = [*_watched(course.until, cells), *_watched(protocol.stop, cells)]
        program.limits[row, FIRST_WATCHED:] = watched
        program.limits[row, WATCHED] = math.isfinite(min(watched))
        # What is watched is looked at in every period.
        program.averaged[row] &= not math.isfinite(min(watched))
        program.elapsed_s[row] = course.until.get("elapsed_s", math.inf)
        program.group[row] = course.group
    return program


@inlined
def lift_line(program: Program, temperature_k: float) -> tuple[float, float, float, float]:
    """Return the straight line that the voltages of a sheet follow at a temperature, and how far it reaches.

    Returns
    -------
    What is added per cell at 25 degC [V] and per kelvin [V/K]; lowest and highest temperature of the line [K].
    """
    slope = program.lift_v_k
    if slope == 0.0:
        return 0.0, 0.0, -math.inf, math.inf
    if temperature_k >= program.highest_k:
        return slope * (program.highest_k - program.reference_k), 0.0, program.highest_k - _CHATTER_K, math.inf
    if temperature_k <= program.lowest_k:
        return slope * (program.lowest_k - program.reference_k), 0.0, -math.inf, program.lowest_k + _CHATTER_K
    low_k, high_k = program.lowest_k - _CHATTER_K, program.highest_k + _CHATTER_K
    return slope * (REFERENCE_K - program.reference_k), slope, low_k, high_k


def _averages(course: Course, driver: str) -> bool:
    if driver == "edge" or not course.waveform.periodic:
        return False
    period_s = sum(segment.length_s for segment in course.segments)
    return math.isfinite(period_s) and (driver == "averaged" or period_s * AVERAGED_ABOVE_HZ < 1.0)


def _limits(until: Mapping[str, float], cells: int) -> tuple[float, float, float, float]:
    return (
        max(1.0 - until["soc"], _FULL) if "soc" in until else -1.0,
        until.get("voltage_v", math.inf) / cells,
        until.get("current_a", -math.inf),
        until.get("temperature_c", math.inf) + ZERO_CELSIUS_K,
    )


def _watched(until: Mapping[str, float], cells: int) -> tuple[float, float]:
    return until.get("voltage_drop_v", math.inf) / cells, until.get("temperature_rate_k_s", math.inf)
