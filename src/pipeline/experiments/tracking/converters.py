"""Converters: their parts and losses in; efficiency over load, and the averaged model against the switches, out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.converter.efficiency import COLUMNS, CONDUCTION, loads
from pipeline.converter.records import ChainLosses, ConverterLosses, PowerChain, SwitchedStage
from pipeline.converter.steady import discontinuous_point, steady_state
from pipeline.converter.switched import follow, gains, operating_point, start
from pipeline.converter.topologies import BatteryLoad, PanelSource, boost, buck, maps
from pipeline.experiments.tracking.records import CONVERTER_NUMBERS
from pipeline.kernel.artefacts import Inputs, Output
from pipeline.quantity import Quantity

Array = NDArray[np.float64]

PANEL_SHARES = (0.8, 0.9, 1.0, 1.1)
"""Voltages of the panel at which the boost converter is looked at, over that at maximum power."""
BATTERY_SHARES = (0.85, 1.0, 1.1)
"""Voltages of the battery at which the buck converter is looked at, over the nominal one."""
_LEAST_SHARE = 0.01
_POINTS = 41
_CHECKED_SHARES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
_CHECK_PERIODS = 2000
_STIFF = BatteryLoad(0.0, 0.005, 1e-6, 1.0)
"""A battery that is little but a voltage, so that the converter alone is looked at."""
_NONE = ConverterLosses(
    transition_time_s=0.0,
    node_capacitance_f=0.0,
    gate_charge_c=0.0,
    gate_voltage_v=0.0,
    core_loss_w=0.0,
    core_ripple_a=1.0,
    core_frequency_hz=1.0,
    ripple_exponent=2.0,
    frequency_exponent=1.0,
    control_power_w=0.0,
)
_CONDUCTION_ALONE = ChainLosses(boost=_NONE, buck=_NONE)


def run(settings: Mapping[str, Any], inputs: Inputs, output: Output) -> None:
    """Look at both converters at every load up to the panel's maximum power."""
    chain = PowerChain.model_validate(settings["converter"])
    voltage, power = float(settings["panel_voltage_v"]), float(settings["panel_power_w"])
    found, check = efficiency_map(chain, voltage, power), against_switches(chain, voltage, power)
    output.write("efficiency", found)
    output.write("check", check)
    output.numbers(quantities(found, check))


def efficiency_map(chain: PowerChain, panel_voltage_v: float, panel_power_w: float) -> dict[str, Any]:
    """Return both converters over load and voltage: the columns of the table of efficiencies.

    Arguments
    ---------
    chain : the converters, with their parts and losses.
    panel_voltage_v, panel_power_w : of all panels at maximum power.
    """
    power = panel_power_w * np.geomspace(_LEAST_SHARE, 1.0, _POINTS)
    battery_v = chain.nominal_battery_voltage_v
    cases = [("boost", share * panel_voltage_v, chain.bus_voltage_v) for share in PANEL_SHARES]
    cases += [("buck", chain.bus_voltage_v, share * battery_v) for share in BATTERY_SHARES]
    found: dict[str, list[Any]] = {}
    for which, source, sink in cases:
        if (which == "boost") is not (source < sink):
            continue
        load = loads(chain, which, source, sink, power)
        columns = {
            "converter": np.full(power.shape, which, object),
            "source_v": np.full(power.shape, source),
            "sink_v": np.full(power.shape, sink),
            "power_w": power,
            "efficiency": load.efficiency(),
            "conduction_efficiency": load.efficiency(CONDUCTION),
            **{name: load.columns[name] for name in COLUMNS},
        }
        for name, column in columns.items():
            found.setdefault(name, []).append(column)
    return {name: np.concatenate(parts) for name, parts in found.items()}


def against_switches(chain: PowerChain, panel_voltage_v: float, panel_power_w: float) -> dict[str, list[Any]]:
    """Return the conduction losses of the averaged model beside those of the switches, as columns.

    The boost converter in its periodic state, with a current that is continuous or ends within the period; the buck
    converter run until it is periodic. Both models get the same voltages and the same power.
    """
    assert chain.switched is not None
    powers = [share * panel_power_w for share in _CHECKED_SHARES]
    rows = [("boost", *_boost(chain, panel_voltage_v, power)) for power in powers]
    rows += [("buck", *_buck(chain, chain.switched, power)) for power in powers]
    rows = [row for row in rows if np.isfinite(row[-1])]
    columns = ("converter", "source_v", "sink_v", "power_w", "averaged", "switched")
    return {name: [row[number] for row in rows] for number, name in enumerate(columns)}


def _boost(chain: PowerChain, panel_v: float, power_w: float) -> tuple[float, float, float, float, float]:
    assert chain.switched is not None
    stage, bus_v = chain.switched.boost, chain.bus_voltage_v
    source = PanelSource(2.0 * panel_v, panel_v**2 / power_w)
    duty, resistance = operating_point(stage, bus_v, source)
    synchronous = stage.rectifier == "synchronous"
    steady = steady_state(boost(stage, source, resistance), synchronous, duty, stage.switching_period_s)
    if not synchronous and steady.valley_a < 0.0:
        resistance = discontinuous_point(stage, bus_v, source)[1]
    averaged = _conduction(chain, "boost", panel_v, bus_v, power_w)
    return panel_v, bus_v, power_w, averaged, bus_v**2 / resistance / power_w


def _buck(chain: PowerChain, switched: SwitchedStage, power_w: float) -> tuple[float, float, float, float, float]:
    stage, bus_v, battery_v = switched.buck, chain.bus_voltage_v, chain.nominal_battery_voltage_v
    planned = loads(chain, "buck", bus_v, battery_v, power_w)
    current = power_w / battery_v
    load = _STIFF._replace(voltage_v=battery_v - _STIFF.series_resistance_ohm * current)
    made = maps(buck(stage, bus_v, load, np.inf), stage.switching_period_s, switched.samples_per_period)
    state, memory = start(stage, bus_v, load, current, 0.0)
    reference = np.full(_CHECK_PERIODS, current)
    synchronous = stage.rectifier == "synchronous"
    duty = float(planned.columns["duty"][0])
    run = follow(made, gains(stage, bus_v), synchronous, reference, state, memory, fixed_duty=duty)
    last = {name: float(column[-1]) for name, column in run.periods.items()}
    drawn = bus_v * last["source_mean_a"]
    given = last["battery_mean_a"] * last["voltage_mean_v"]
    averaged = _conduction(chain, "buck", bus_v, last["voltage_mean_v"], drawn)
    return bus_v, last["voltage_mean_v"], drawn, averaged, given / drawn if drawn > 0.0 else np.nan


def _conduction(chain: PowerChain, which: str, source_v: float, sink_v: float, power_w: float) -> float:
    """Return the efficiency where there are no losses but those by conduction."""
    alone = chain.model_copy(update={"losses": _CONDUCTION_ALONE})
    return float(loads(alone, which, source_v, sink_v, power_w).efficiency()[0])


def quantities(found: dict[str, Any], check: dict[str, list[Any]]) -> list[Quantity]:
    """Return the best efficiency and that at full load of both converters, and the largest difference found."""
    numbers: list[Quantity] = []
    for which in ("boost", "buck"):
        own = found["converter"] == which
        nominal = _nominal(found, own, which)
        best = int(np.argmax(found["efficiency"][nominal]))
        pairs = zip(check["converter"], check["averaged"], check["switched"], strict=True)
        off = [abs(ours - theirs) for converter, ours, theirs in pairs if converter == which]
        values = {
            "{converter}_full_efficiency": found["efficiency"][nominal][-1],
            "{converter}_best_efficiency": found["efficiency"][nominal][best],
            "{converter}_best_w": found["power_w"][nominal][best],
            "{converter}_off_switched": max(off, default=np.nan),
        }
        numbers += [CONVERTER_NUMBERS.quantity(pattern, value, converter=which) for pattern, value in values.items()]
    return numbers


def _nominal(found: dict[str, Any], own: NDArray[np.bool_], which: str) -> NDArray[np.int64]:
    """Return the rows of a converter at its nominal voltages: those of share 1."""
    name, shares = ("source_v", PANEL_SHARES) if which == "boost" else ("sink_v", BATTERY_SHARES)
    voltages = np.unique(found[name][own])
    wanted = voltages[min(shares.index(1.0), len(voltages) - 1)]
    return np.flatnonzero(own & (found[name] == wanted))
