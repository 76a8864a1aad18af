"""Usual values for what a data sheet leaves out: the temperature coefficients and the number of cells.

Medians of the CEC module database (sam-library-cec-modules-2019-03-05.csv, in pvlib) by technology, with the range that
nine of ten modules lie in, from its 5th to its 95th percentile.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from pipeline.errors import UserError, best_matches

LEFT_OUT = ("alpha_isc_a_per_k", "beta_voc_v_per_k", "gamma_pmp_percent_per_k", "cells_in_series")
_STRINGS = (9, 18, 36, 40, 48, 54, 60, 66, 72, 80, 96, 120, 128, 144)
"""Numbers of cells in series that modules of crystalline silicon are made with; half cells are in two strings."""


class Usual(NamedTuple):
    """Values of a technology, each (5th percentile, median, 95th percentile) over a number of modules.

    Arguments
    ---------
    modules : how many.
    isc, voc, power : coefficients of the short-circuit current, open-circuit voltage, maximum power [%/K].
    cell_v : open-circuit voltage of a cell [V].
    """

    modules: int
    isc: tuple[float, float, float]
    voc: tuple[float, float, float]
    power: tuple[float, float, float]
    cell_v: tuple[float, float, float]


TECHNOLOGIES = {
    "crystalline_silicon": Usual(
        20946, (0.0240, 0.0512, 0.0945), (-0.4012, -0.3374, -0.2833), (-0.5271, -0.4502, -0.383), (0.600, 0.6255, 0.665)
    ),
    "mono_silicon": Usual(
        9725, (0.0193, 0.0500, 0.0860), (-0.4014, -0.3319, -0.2780), (-0.5328, -0.450, -0.370), (0.6037, 0.6306, 0.6783)
    ),
    "multi_silicon": Usual(
        11221, (0.0250, 0.0564, 0.1041), (-0.3998, -0.340, -0.299), (-0.5212, -0.4515, -0.400), (0.5994, 0.6222, 0.6485)
    ),
    "cadmium_telluride": Usual(
        20, (0.0550, 0.0560, 0.0570), (-0.2800, -0.2785, -0.2770), (-0.2610, -0.2525, -0.244), (0.8135, 0.8235, 0.8304)
    ),
}
"""CEC's Technology: Mono-c-Si and Multi-c-Si together, each alone, CdTe. Its thin films differ too much for one."""
DEFAULT = "crystalline_silicon"


def completed(values: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """Return a data sheet with usual values in the place of those it leaves out, and their sources.

    Arguments
    ---------
    values : fields of `pipeline.panel.records.Panel`, without some of LEFT_OUT, perhaps with `technology`, a key of
        TECHNOLOGIES; crystalline silicon where it is not there.

    Returns
    -------
    The fields without `technology`; name of each value that was put in -> its source, an estimate with its range.

    Raises
    ------
    UserError : an unknown technology.
    """
    given = {key: value for key, value in values.items() if key != "technology"}
    technology = values.get("technology") or DEFAULT
    if technology not in TECHNOLOGIES:
        raise UserError(f"technology: value {technology!r}; {best_matches(str(technology), TECHNOLOGIES)}")
    current: Any = given.get("short_circuit_current_a")
    voltage: Any = given.get("open_circuit_voltage_v")
    if not _is_positive(current) or not _is_positive(voltage):
        return given, {}  # the record says what is wrong with it
    found = _usual(TECHNOLOGIES[technology], float(current), float(voltage))
    absent = [name for name in LEFT_OUT if given.get(name) is None]
    sources = {}
    for name in absent:
        low, given[name], high = found[name]
        sources[name] = {
            "kind": "estimate",
            "ref": f"not given: usual for {technology.replace('_', ' ')}, the median of "
            f"{TECHNOLOGIES[technology].modules} modules of the CEC database (in pvlib); nine of ten lie in the range",
            "range": [low, high],
        }
    return given, sources


def _usual(one: Usual, current_a: float, voltage_v: float) -> dict[str, tuple[float, float, float]]:
    """Return lowest, usual and highest value of each field, in its own unit."""
    low_v, median_v, high_v = one.cell_v
    likely = voltage_v / median_v
    cells = min(_STRINGS, key=lambda cells: (abs(cells - likely), cells)) if median_v < 0.75 else max(1, round(likely))
    if abs(cells - likely) > 0.08 * likely:
        cells = max(1, round(likely))
    alpha = [share / 100.0 * current_a for share in one.isc]
    beta = [share / 100.0 * voltage_v for share in one.voc]
    return {
        "alpha_isc_a_per_k": (alpha[0], alpha[1], alpha[2]),
        "beta_voc_v_per_k": (beta[0], beta[1], beta[2]),
        "gamma_pmp_percent_per_k": one.power,
        "cells_in_series": (min(cells, int(voltage_v / high_v)), cells, max(cells, round(voltage_v / low_v))),
    }


def _is_positive(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and value > 0
