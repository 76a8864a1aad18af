"""Maximum power over arrays of conditions against pvlib's Newton iteration.

Ours takes irradiance and temperature; for pvlib the conditions' parameters are made outside the time. Errors are
against pvlib's `brentq`, which is a thousand times slower, on the first conditions.
"""

from __future__ import annotations

import numpy as np
from pvlib.pvsystem import calcparams_cec, max_power_point

from benchmarks.protocol import Figure, Row, compared, interleaved, once
from benchmarks.sheets import load
from pipeline.panel.maximum_power import maximum_power
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import fit

PACKAGES = ("numba", "pvlib")
FIGURE, ERROR_ASKED = Figure(15.0), 1e-10
COUNTS, CHECKED = (10_000, 100_000), 500


def rows() -> list[Row]:
    """Return a row for each number of conditions."""
    panel = Panel(**load("panel/kc65t.yaml"))
    fit_s, diode = once(lambda: fit(panel))
    compile_s, _ = once(lambda: maximum_power(panel, diode, [1000.0], [25.0]))
    rng = np.random.default_rng(1)
    made = []
    for count in COUNTS:
        irradiance, temperature = rng.uniform(5.0, 1200.0, count), rng.uniform(-20.0, 80.0, count)
        parameters = calcparams_cec(
            irradiance, temperature, panel.alpha_isc_a_per_k, diode.modified_ideality_v, diode.photocurrent_a,
            diode.saturation_current_a, diode.shunt_resistance_ohm, diode.series_resistance_ohm, diode.adjust_percent,
        )  # fmt: skip

        def ours(irradiance=irradiance, temperature=temperature):
            return maximum_power(panel, diode, irradiance, temperature)

        def theirs(parameters=parameters):
            return max_power_point(*parameters, method="newton")

        few = [np.broadcast_to(part, count)[:CHECKED] for part in parameters]
        exact = max_power_point(*few, method="brentq")["p_mp"]
        found, others = ours().max_power_w, theirs()["p_mp"]
        walls = interleaved({"ours": ours, "pvlib": theirs})
        own, other = (float(np.max(np.abs(power[:CHECKED] / exact - 1.0))) for power in (found, others))
        apart = np.max(np.abs(found / others - 1.0))
        row = compared(
            f"maximum power, {count} conditions", "pvlib, newton", walls["ours"], walls["pvlib"], FIGURE,
            ours_error=own, peer_error=other, error_asked=ERROR_ASKED,
            error_means=f"power against pvlib's brentq, relative, {CHECKED} conditions",
            note=f"{count / np.median(walls['ours']):.1e} conditions a second; the two are {apart:.0e} apart at most",
            before_s={"this project": compile_s, "fit of the panel": fit_s},
        )  # fmt: skip
        made.append(row)
    return made
