"""Maximum power over arrays of conditions against pvlib: ratio of times, and how far the two are apart.

Run as `PYTHONPATH=src python -m benchmarks.maximum_power`; medians of interleaved rounds, without imports and
compilation.
Ours takes irradiance and temperature; for pvlib the conditions' parameters are made outside the time.
"""

from __future__ import annotations

import statistics
import time

import numpy as np
from benchmarks.edge import load
from pvlib.pvsystem import calcparams_cec, max_power_point

from pipeline.panel.maximum_power import maximum_power
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import fit

ROUNDS = 5
FLOOR = 15.0


def main() -> int:
    panel = Panel(**load("panel/kc65t.yaml"))
    diode = fit(panel)
    rng = np.random.default_rng(1)
    maximum_power(panel, diode, [1000.0], [25.0])
    worst_ratio = np.inf
    print(
        f"{'conditions':>10s} {'ours s':>9s} {'pvlib s':>9s} {'ratio':>7s} {'range':>13s} {'error':>9s} {'ours/s':>9s}"
    )
    for count in (10_000, 100_000):
        irradiance, temperature = rng.uniform(5.0, 1200.0, count), rng.uniform(-20.0, 80.0, count)
        parameters = calcparams_cec(
            irradiance, temperature, panel.alpha_isc_a_per_k, diode.modified_ideality_v, diode.photocurrent_a,
            diode.saturation_current_a, diode.shunt_resistance_ohm, diode.series_resistance_ohm, diode.adjust_percent,
        )  # fmt: skip
        ours_s, theirs_s = [], []
        for _ in range(ROUNDS):
            begin = time.perf_counter()
            ours = maximum_power(panel, diode, irradiance, temperature)
            middle = time.perf_counter()
            theirs = max_power_point(*parameters, method="newton")
            ours_s.append(middle - begin)
            theirs_s.append(time.perf_counter() - middle)
        ratios = [peer / own for own, peer in zip(ours_s, theirs_s, strict=True)]
        error = float(np.max(np.abs(ours.max_power_w / theirs["p_mp"] - 1.0)))
        own, peer, ratio = statistics.median(ours_s), statistics.median(theirs_s), statistics.median(ratios)
        spread = f"{min(ratios):.1f}-{max(ratios):.1f}"
        print(f"{count:10d} {own:9.5f} {peer:9.5f} {ratio:7.1f} {spread:>13s} {error:9.1e} {count / own:9.2e}")
        worst_ratio = min(worst_ratio, ratio)
    print(f"asked: {FLOOR:g} x; a median below half of that fails")
    return int(worst_ratio < FLOOR / 2.0)


if __name__ == "__main__":
    raise SystemExit(main())
