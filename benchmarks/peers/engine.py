"""This project's engine on the common model: a whole `simulate`, records in and columns out."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.common_model import KELVIN, End

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Charge, run, simulate
from pipeline.charge.state import DEPTH, RELAXATIONS, TEMPERATURE

TITLE = "this project"


def build(
    battery: Battery, mode: Mode, initial_soc: float, driver: str, interval_s: float = 10.0
) -> Callable[[], Charge]:
    """Return the run; its table has a row every `interval_s`."""
    settings = ChargeSettings(initial_soc=initial_soc, ambient_c=25.0, sample_interval_s=interval_s)
    engine = EngineSettings(driver=driver)  # type: ignore[arg-type]
    return lambda: simulate(battery, mode, BENCH, settings, engine)


def end_of(battery: Battery, mode: Mode, initial_soc: float, driver: str, interval_s: float = 10.0) -> End:
    """Return the state at the end of the same run; pairs' voltages are in the kernels' state alone."""
    settings = ChargeSettings(initial_soc=initial_soc, ambient_c=25.0, sample_interval_s=interval_s)
    outcome = run(battery, mode, BENCH, settings, EngineSettings(driver=driver))  # type: ignore[arg-type]
    state, cells = outcome.run["state"], battery.cells_in_series
    put, taken = numbers(build(battery, mode, initial_soc, driver, interval_s)(), ("energy_in_wh", "energy_out_wh"))
    return End(
        float(1.0 - state[DEPTH]),
        float(cells * state[RELAXATIONS]),
        float(cells * state[RELAXATIONS + 1]),
        float(state[TEMPERATURE]),
        3600.0 * (put - taken),
    )


def numbers(charge: Charge, names: tuple[str, ...]) -> list[float]:
    """Return quantities of a charge's summary."""
    values = {row.quantity: row.value for row in charge.summary}
    return [float(values[name] or 0.0) for name in names]


def celsius(kelvin: float) -> float:
    """Return a temperature in degC."""
    return kelvin - KELVIN
