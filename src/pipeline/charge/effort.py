"""About how much memory and time a charge takes, from its lab sheet alone; light to import."""

from __future__ import annotations

from pipeline.charge.records import ChargeSettings, EngineSettings, Mode

ROW_B = 8.0 * 48 * 3
"""A row of a trace in memory, while it is made and written [B]."""
_STEP_S, _EDGE_S = 0.5e-6, 0.3e-6  # of one core, from benchmarks/README.md, with a margin
_ROWS_A_PERIOD = 16.0
_SOUGHT_HZ = 500.0  # of a frequency that is yet to be found
_WITHOUT_END_S = 1e6


def longest_s(mode: Mode) -> float:
    """Return the time after which a charge in a mode ends at the latest [s]."""
    written = mode.stop.elapsed_s
    found = mode.knobs.get(written) if isinstance(written, str) else written
    return float(found) if isinstance(found, int | float) else _WITHOUT_END_S


def frequency_hz(mode: Mode) -> float:
    """Return the highest frequency of a mode's pulses [Hz]; 0 without any."""
    named = [value for name, value in mode.knobs.items() if name.endswith("frequency_hz")]
    return max((value if isinstance(value, int | float) else _SOUGHT_HZ for value in named), default=0.0)


def effort(mode: Mode, charge: ChargeSettings, engine: EngineSettings) -> tuple[float, float]:
    """Return memory [B] and time of one core [s] of a charge."""
    duration_s, pulses_hz = longest_s(mode), frequency_hz(mode)
    rows = duration_s / charge.sample_interval_s
    kept = sum(window.length_s for window in charge.windows) * max(pulses_hz, 1.0) * _ROWS_A_PERIOD
    steps = duration_s / engine.maximum_step_s + rows
    periods = duration_s * pulses_hz if engine.driver == "edge" or pulses_hz <= 2.0 else rows * _ROWS_A_PERIOD
    return (rows + kept) * ROW_B, min(float(engine.maximum_steps), steps + 4.0 * periods + kept) * (_STEP_S + _EDGE_S)
