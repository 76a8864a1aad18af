"""The first law for every battery and mode under both drivers, and mistakes that it must show."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.cell.circuit import compile_cell
from pipeline.cell.records import Battery, Tabulated
from pipeline.charge.energy import balance
from pipeline.charge.outcome import Outcome
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, run
from pipeline.charge.state import TEMPERATURE
from pipeline.experiments.validation.plain import suited
from pipeline.experiments.validation.records import FirstLaw, Found, Row, at_least, at_most

BOUNDS = {"edge": 1e-9, "averaged": 1e-6}
"""Residual over energy in that each driver may leave."""
MISTAKE = "mistake: "
"""How a row begins that must show a mistake."""
_AMBIENT_C, _MOST_STEPS = 25.0, 5_000_000


def check(settings: Mapping[str, Any]) -> Found:
    """Return the residual of the first law over the energy in, for every battery, mode and driver; then mistakes."""
    conditions = FirstLaw.model_validate(settings)
    rows = [
        at_most(f"{battery}, {mode}, {driver}", residual(outcome, conditions.batteries[battery]), BOUNDS[driver])
        for battery in conditions.batteries
        for mode in conditions.modes
        for driver in BOUNDS
        for outcome in [_outcome(conditions, battery, mode, driver)]
    ]
    return Found(rows + _mutations(conditions), [])


def residual(outcome: Outcome, against: Battery) -> float:
    """Return what the first law leaves over the electrical energy, with the state functions of a battery.

    Arguments
    ---------
    outcome : a finished run; its heats were added up from the dissipations.
    against : the battery whose stored energies are compared, the run's own unless a mistake is put in.
    """
    cell = compile_cell(against)
    energy = balance(cell, outcome.book.gains, outcome.start, outcome.run["state"], tuple(against.pairs))
    of_path = dict(zip(energy["path"], energy["energy_j"], strict=True))
    return float(abs(of_path["residual"] / of_path["electrical"]))


def _outcome(conditions: FirstLaw, battery: str, mode: str, driver: str) -> Outcome:
    own = conditions.conditions[battery]
    cell = conditions.batteries[battery]
    sheet: Mode = suited(conditions.modes[mode], cell, own, conditions.bulk_s, conditions.duration_s)
    settings = ChargeSettings(initial_soc=own.initial_soc, ambient_c=_AMBIENT_C, sample_interval_s=10.0)
    engine = EngineSettings.model_validate({"driver": driver, "maximum_steps": _MOST_STEPS})
    return run(cell, sheet, BENCH, settings, engine)


def _mutations(conditions: FirstLaw) -> list[Row]:
    """Return what the first law leaves where a mistake is put in; each must be far above its bound."""
    rows: list[Row] = []
    for name, cell in conditions.batteries.items():
        outcome = _outcome(conditions, name, next(iter(conditions.modes)), "edge")
        for mistake, wrong in _wrong(cell).items():
            rows.append(at_least(f"{MISTAKE}{name}, {mistake}", residual(outcome, wrong), 1e-6))
        outcome.run["state"][TEMPERATURE] -= 1e-5
        rows.append(at_least(f"{MISTAKE}{name}, 10 uK of heat lost", residual(outcome, cell), 3e-9))
    return rows


def _wrong(cell: Battery) -> dict[str, Battery]:
    """Return batteries with a mistake each, of those that this one has the part for."""
    found = {}
    entropy, neutral_v = cell.entropic_coefficient_v_k, cell.thermoneutral_voltage_v
    if neutral_v is not None:
        found["thermoneutral voltage off by 1 %"] = cell.model_copy(
            update={"thermoneutral_voltage_v": 1.01 * neutral_v}
        )
    elif isinstance(entropy, Tabulated):
        turned = entropy.model_copy(update={"scale": -entropy.scale})
        found["wrong sign of dU/dT"] = cell.model_copy(update={"entropic_coefficient_v_k": turned})
    elif isinstance(entropy, float) and entropy != 0.0:
        found["wrong sign of dU/dT"] = cell.model_copy(update={"entropic_coefficient_v_k": -entropy})
    if cell.acceptance is not None:
        found["acceptance pair lost"] = cell.model_copy(update={"acceptance": None})
    if cell.pairs:
        last = list(cell.pairs)[-1]
        fewer = {name: pair for name, pair in cell.pairs.items() if name != last}
        found[f"pair {last} lost"] = cell.model_copy(update={"pairs": fewer})
    return found
