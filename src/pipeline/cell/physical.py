"""Is a battery one that can be? What its curves must keep to over the whole range of SOC."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.cell.records import Battery, Curve, Tabulated
from pipeline.cell.resting import value_of

_GRID = tuple(n / 100 for n in range(101))
_REFERENCE_K = 298.15


def faults(battery: Battery) -> Iterator[str]:
    """Yield what is not physical about a battery's curves: key, value, where, and what is allowed.

    Resistances may not be negative, exchange currents must be positive; the potential of a full cell must be positive,
    no lower than that of a half-full one, and larger than the share of it that is entropy.
    """
    yield from _low("series_resistance_ohm", battery.series_resistance_ohm, "ohm")
    for name, pair in battery.pairs.items():
        yield from _low(f"pairs.{name}.resistance_ohm", pair.resistance_ohm, "ohm")
    if battery.charge_transfer is not None:
        inside = [value_of(battery.charge_transfer.exchange_current_a, soc) for soc in _GRID[1:-1]]
        if min(inside) <= 0.0:
            soc = _GRID[1:-1][inside.index(min(inside))]
            key = "charge_transfer.exchange_current_a"
            yield f"{key} is {min(inside):g} A at SOC {soc:g}; it must be greater than 0"
    full, half = (value_of(battery.open_circuit_voltage_v, soc) for soc in (0.99, 0.5))
    if half <= 0.0 or full < half:
        yield (
            f"open_circuit_voltage_v is {half:g} V at SOC 0.5 and {full:g} V at SOC 0.99; "
            "it must be greater than 0 and may not fall while charging"
        )
    entropy = max((abs(value_of(battery.entropic_coefficient_v_k, soc)) for soc in _GRID[1:-1]), default=0.0)
    if half > 0.0 and entropy * _REFERENCE_K >= half:
        yield (
            f"entropic_coefficient_v_k comes to {entropy:g} V/K; allowed is less than {half / _REFERENCE_K:.3g} V/K, "
            "the potential over the temperature"
        )


def _low(key: str, curve: Curve, unit: str) -> Iterator[str]:
    grid = curve.soc if isinstance(curve, Tabulated) else _GRID
    lowest, soc = min((value_of(curve, soc), soc) for soc in grid)
    if lowest < 0.0:
        yield f"{key} is {lowest:g} {unit} at SOC {soc:g}; it must be 0 or greater"
