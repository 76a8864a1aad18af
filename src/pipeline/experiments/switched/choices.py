"""Pulses against the switches that make them: none may be shorter than a switching period."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pipeline.charge.protocol import Resolver, parameters
from pipeline.charge.records import Mode
from pipeline.errors import UserError
from pipeline.record import Reference

_SHARES = ("charge_share", "discharge_share")


def check(study: Any) -> None:
    """Refuse pulses whose shortest part is shorter than a switching period of the buck converter.

    Raises
    ------
    UserError : with the key path, the value and what is allowed.
    """
    if study.converter is None or study.converter.switched is None:
        return
    switching_hz = study.converter.switched.buck.switching_frequency_hz
    refused: list[tuple[float, str]] = []
    for name in study.run:
        for phase, found in _pulses(study.modes[name], study.battery.capacity_in_use_ah):
            numbers = {key: value for key, value in found.items() if isinstance(value, float)}
            share = _shortest(numbers)
            path, frequency = _frequency(study, name, phase, found["frequency_hz"])
            if share is None or frequency is None or frequency <= share * switching_hz * (1.0 + 1e-9):
                continue
            told = (
                f"{path}: value {frequency:g} Hz; the shortest part of a pulse, {100 * share:g} % of its period, would "
                f"last {share / frequency:.3g} s, less than a switching period of {1 / switching_hz:.3g} s; allowed is "
                f"up to {share * switching_hz:g} Hz"
            )
            refused.append((share, told))
    if refused:
        raise UserError(min(refused)[1])


def _pulses(mode: Mode, capacity_ah: float) -> Iterator[tuple[str, dict[str, float | Reference]]]:
    for phase, card in mode.phases.items():
        if card.waveform.periodic:
            yield phase, dict(parameters(Resolver(mode, capacity_ah), card.waveform, f"phases.{phase}"))


def _shortest(numbers: dict[str, float]) -> float | None:
    """Return the share of the shortest part that there is; none where the current never changes."""
    shares = [numbers.get(name, 0.0) for name in _SHARES]
    parts = [part for part in (*shares, 1.0 - sum(shares)) if part > 1e-9]
    return min(parts) if len(parts) > 1 else None


def _frequency(study: Any, mode: str, phase: str, value: float | Reference) -> tuple[str, float | None]:
    """Return key path and value of a frequency, or of the highest that a search may find."""
    if isinstance(value, Reference):
        box = study.search.variables.get(value.value) if study.search is not None else None
        return (f"search.variables.{value.value}.high", box.high) if box is not None else ("search", None)
    own = study.modes[mode].phases[phase].waveform
    given = getattr(own, "frequency_hz", None)
    if isinstance(given, float | int):
        waveform = next(
            key for key in study.configuration["modes"][mode]["phases"][phase] if key not in ("limit", "until")
        )
        return f"modes.{mode}.phases.{phase}.{waveform}.frequency_hz", value
    return f"modes.{mode}.{given or 'frequency_hz'}", value
