"""What a day asks of a mode before it begins."""

from __future__ import annotations

from pipeline.charge.records import Mode
from pipeline.charge.waveforms import Sampled
from pipeline.errors import UserError


def check(mode: Mode) -> None:
    """Refuse a mode that a change of the air or a cloud would make forget what it has seen.

    Raises
    ------
    UserError : a stop on the voltage's fall from its peak, or a current decided from sample to sample.
    """
    ends = {"stop": mode.stop} | {f"phases.{name}.until": phase.until for name, phase in mode.phases.items()}
    for where, until in ends.items():
        if until.voltage_drop_v is not None:
            raise UserError(
                f"{where}.voltage_drop_v: a day runs a charge piece by piece, and the voltage's peak would be "
                "forgotten in between; leave the mode out of day.modes, or stop it by temperature_rate_k_s"
            )
    for name, phase in mode.phases.items():
        if isinstance(phase.waveform, Sampled):
            raise UserError(
                f"phases.{name}: a day runs a charge piece by piece, and a current decided from sample to sample would "
                "begin anew in between; leave the mode out of day.modes"
            )
