"""This project's engine: a whole `simulate`, records in and columns out, or its driver alone."""

from __future__ import annotations

from collections.abc import Callable

from benchmarks.common_model import End
from pipeline.cell.circuit import compile_cell
from pipeline.cell.records import Battery
from pipeline.charge import drive
from pipeline.charge.books import book_for
from pipeline.charge.checks import check
from pipeline.charge.controller import compile_control
from pipeline.charge.period import new_clock
from pipeline.charge.program import compile_program
from pipeline.charge.protocol import resolve
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, Charge, launch, run, simulate
from pipeline.charge.state import DEPTH, HYSTERESIS, RELAXATIONS, TEMPERATURE, new_run

TITLE = "this project"
AMBIENT_C, AMBIENT_K = 25.0, 298.15


def settings_of(initial_soc: float, driver: str, interval_s: float) -> tuple[ChargeSettings, EngineSettings]:
    """Return the settings of a charge whose table has a row every `interval_s`."""
    settings = ChargeSettings(initial_soc=initial_soc, ambient_c=AMBIENT_C, sample_interval_s=interval_s)
    return settings, EngineSettings(driver=driver)  # type: ignore[arg-type]


def whole(
    battery: Battery, mode: Mode, initial_soc: float, driver: str, interval_s: float = 10.0
) -> Callable[[], Charge]:
    """Return the run of a whole `simulate`."""
    settings, engine = settings_of(initial_soc, driver, interval_s)
    return lambda: simulate(battery, mode, BENCH, settings, engine)


def solver(
    battery: Battery, mode: Mode, initial_soc: float, driver: str, interval_s: float = 10.0
) -> Callable[[], int]:
    """Return the run of the compiled driver alone, on what `simulate` would hand it; a fresh state every time."""
    settings, engine = settings_of(initial_soc, driver, interval_s)
    check(battery, mode, settings)
    cell, protocol = compile_cell(battery), resolve(mode, battery.capacity_in_use_ah, battery.fills)
    program = compile_program(protocol, battery.cells_in_series, engine.driver)
    control = compile_control(protocol, battery.capacity_in_use_ah)

    def solve() -> int:
        state, book, clock = new_run(), book_for(program, settings), new_clock(interval_s)
        state["state"][DEPTH], state["state"][TEMPERATURE] = 1.0 - initial_soc, AMBIENT_K
        state["state"][HYSTERESIS] = cell.hysteresis_start_v
        status = launch(cell, program, control, BENCH, state, book, clock, AMBIENT_K, engine)
        if status != drive.DONE:
            raise RuntimeError(f"the driver ended with status {status}")
        return int(state["edges"])

    return solve


def end_of(battery: Battery, mode: Mode, initial_soc: float, driver: str, interval_s: float = 10.0) -> End:
    """Return the state at the end of the same run; pairs' voltages are in the kernels' state alone."""
    settings, engine = settings_of(initial_soc, driver, interval_s)
    state, cells = run(battery, mode, BENCH, settings, engine).run["state"], battery.cells_in_series
    charge = whole(battery, mode, initial_soc, driver, interval_s)()
    put, taken = numbers(charge, ("energy_in_wh", "energy_out_wh"))
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
