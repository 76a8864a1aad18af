"""The panel against pvlib: maximum power of fifty modules, and the energy of a day by its ModelChain."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.panel.database import PanelEntry, look_up, names
from pipeline.panel.maximum_power import maximum_power
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import SingleDiode, fit
from pipeline.validation import panel_day
from pipeline.validation.records import Curve, Found, at_least, at_most, largest

Array = NDArray[np.float64]

MODULES, CONDITIONS, SEED = 50, 20, 20150401
POWER_BOUND, ENERGY_BOUND = 1e-6, 5e-3


def check(settings: Mapping[str, Any]) -> Found:
    """Return both checks, mistakes that the day must show, and the differences over irradiance and over the day."""
    irradiance, power = maximum_power_differences()
    panel, diode = _known(panel_day.MODULE)
    ours, theirs = panel_day.ours_w(panel, diode), panel_day.theirs_w()
    energy, minute = panel_day.difference(ours, theirs)
    hours, over_most = np.arange(panel_day.MINUTES) / 60.0, (ours - theirs) / float(theirs.max())
    up = "difference [1]"
    rows = [
        at_most(f"maximum power, {MODULES} modules in {CONDITIONS} conditions each", largest(power), POWER_BOUND),
        at_most("energy of a clear day, against pvlib's ModelChain", energy, ENERGY_BOUND),
        at_most("power of every minute of it, over its most", minute, ENERGY_BOUND),
    ]
    for mistake, changes in panel_day.MISTAKES.items():
        wrong = panel_day.ours_w(panel, diode, panel_day.with_mistake(changes))
        rows.append(at_least(f"mistake: {mistake}", max(panel_day.difference(wrong, theirs)), ENERGY_BOUND))
    return Found(
        rows,
        [
            Curve("maximum power over pvlib's", f"{MODULES} modules", "irradiance [W/m²]", up, irradiance, power),
            Curve("power on a clear day over its most", "ModelChain", "time [h]", up, hours, over_most),
        ],
    )


def maximum_power_differences() -> tuple[Array, Array]:
    """Return irradiance, rising, and relative difference of maximum power from pvlib's, shape (1000,) each.

    The modules are drawn by a fixed seed; pvlib reads the database itself and has its own laws of irradiance.
    """
    from pvlib.pvsystem import calcparams_cec, max_power_point, retrieve_sam

    rng = np.random.default_rng(SEED)
    drawn = rng.choice(names("cec"), MODULES, replace=False)
    irradiance = rng.uniform(20.0, 1200.0, (MODULES, CONDITIONS))
    temperature = rng.uniform(-20.0, 80.0, (MODULES, CONDITIONS))
    modules = retrieve_sam("CECMod")
    found = np.empty((MODULES, CONDITIONS))
    for row, (name, light, cells) in enumerate(zip(drawn, irradiance, temperature, strict=True)):
        panel, diode = _known(str(name))
        their = modules[str(name)]
        circuit = calcparams_cec(
            *(light, cells, their.alpha_sc, their.a_ref, their.I_L_ref, their.I_o_ref),
            *(their.R_sh_ref, their.R_s, their.Adjust),
        )
        theirs = np.asarray(max_power_point(*circuit, method="brentq")["p_mp"])
        found[row] = maximum_power(panel, diode, light, cells).max_power_w / theirs - 1.0
    order = np.argsort(irradiance, axis=None)
    return irradiance.ravel()[order], found.ravel()[order]


def _known(name: str) -> tuple[Panel, SingleDiode]:
    panel = Panel.model_validate(look_up(PanelEntry(database="cec", name=name)))
    return panel, fit(panel)
