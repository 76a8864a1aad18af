"""What a tracker works on: the panels and the converter behind them, as numbers for the closed loop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.converter.switched_records import SwitchedBoost
from pipeline.panel.maximum_power import characteristic_points, conditions, maximum_power
from pipeline.panel.records import REFERENCE_IRRADIANCE_W_M2, REFERENCE_TEMPERATURE_C, Panel
from pipeline.panel.single_diode import SingleDiode
from pipeline.tracker.scales import Scales

Array = NDArray[np.float64]


class Source(NamedTuple):
    """The panels and the boost converter that sets their voltage against a stiff bus.

    Arguments
    ---------
    panel : the data sheet, with the number of panels.
    diode : single-diode parameters of one panel.
    boost : the parts of the converter.
    bus_voltage_v : voltage of the bus [V].
    """

    panel: Panel
    diode: SingleDiode
    boost: SwitchedBoost
    bus_voltage_v: float


def scales(source: Source) -> Scales:
    """Return what the settings of a tracker are relative to."""
    points = characteristic_points(source.panel, source.diode, REFERENCE_IRRADIANCE_W_M2, REFERENCE_TEMPERATURE_C)
    return Scales(
        float(points.open_circuit_voltage_v[0]) * source.panel.panels_in_series,
        float(points.short_circuit_current_a[0]) * source.panel.panels_in_parallel,
        source.bus_voltage_v,
    )


def parts(source: Source) -> Array:
    """Return the circuit's values in the order of `circuit_kernel`."""
    boost = source.boost
    diode = boost.rectifier == "diode_emulated"
    return np.array(
        [
            *(boost.inductance_h, boost.input_capacitance_f, source.bus_voltage_v),
            boost.rectifier_voltage_v if diode else 0.0,
            *(boost.inductor_resistance_ohm, boost.on_resistance_ohm, boost.rectifier_resistance_ohm),
            *(boost.switching_period_s, float(diode)),
        ]
    )


def of_all_panels(source: Source, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike) -> tuple[Array, float]:
    """Return the single-diode parameters of all panels in each condition, shape (4, n), and their resistance [ohm]."""
    one = conditions(source.panel, source.diode, irradiance_w_m2, cell_temperature_c)
    series, parallel = source.panel.panels_in_series, source.panel.panels_in_parallel
    rows = np.array(
        [
            one.photocurrent_a * parallel,
            one.saturation_current_a * parallel,
            one.shunt_conductance_s * parallel / series,
            one.modified_ideality_v * series,
        ]
    )
    return rows, source.diode.series_resistance_ohm * series / parallel


def available_power_w(source: Source, irradiance_w_m2: ArrayLike, cell_temperature_c: ArrayLike) -> Array:
    """Return the maximum power of all panels in each condition [W], shape (n,)."""
    one = maximum_power(source.panel, source.diode, irradiance_w_m2, cell_temperature_c)
    return one.max_power_w * (source.panel.panels_in_series * source.panel.panels_in_parallel)
