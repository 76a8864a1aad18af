"""Compile every kernel before parallel charges start."""

from __future__ import annotations

from pipeline.cell.circuit import enthalpy
from pipeline.cell.curves import value_and_slope
from pipeline.cell.records import Battery, Pair, SideReaction, Thermal
from pipeline.charge import drive, period
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, simulate

_BATTERY = Battery(
    name="warm_up",
    title="Warm-up",
    cells_in_series=1,
    capacity_ah=1.0,
    open_circuit_voltage_v=2.0,
    series_resistance_ohm=0.01,
    pairs={"one": Pair(resistance_ohm=0.01, time_constant_s=1.0)},
    side_reaction=SideReaction(current_a=1e-6, reference_voltage_v=2.0, voltage_scale_v=0.1),
    thermal=Thermal(heat_capacity_j_k=100.0, resistance_k_w=1.0),
)
_MODE = Mode.model_validate(
    {
        "title": "Warm-up",
        "phases": {"charge": {"constant_current": {"current_a": 1.0}}},
        "stop": {"elapsed_s": 0.1},
    }
)


def compile_kernels() -> list[str]:
    """Run a fraction of a second of a charge, which compiles everything it calls; return the kernels' names."""
    simulate(_BATTERY, _MODE, BENCH, ChargeSettings(initial_soc=0.5, ambient_c=25.0), EngineSettings())
    return [kernel.__name__ for kernel in (drive.run_program, period.run_periods, enthalpy, value_and_slope)]
