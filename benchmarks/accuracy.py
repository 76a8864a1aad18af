"""How far the edge driver is from a tight `solve_ivp` over 60 s of 90 Hz Reflex, in three windows of a charge.

Run as `make accuracy`; takes some minutes, nearly all of it scipy's.
"""

from __future__ import annotations

import numpy as np
from tests.charge.independent import CELLS, circuit, reference
from tests.charge.samples import battery, charge, load, settings

from pipeline.charge.records import Mode

SECONDS, LIMIT_V = 60, 14.4
WINDOWS = {"s = 0.3, unclipped": 0.3, "s = 0.9, clipping": 0.9, "s = 0.985, side current": 0.985}


def engine(soc: float) -> dict[str, np.ndarray]:
    sheet = load("modes/cv_reflex.yaml")
    sheet["phases"].pop("bulk")
    sheet.pop("max_current_a")
    ends = [{"start_s": second - 1e-4, "length_s": 1e-4} for second in range(1, SECONDS)]
    mode = Mode(**(sheet | {"stop": {"elapsed_s": float(SECONDS)}, "voltage_v": LIMIT_V}))
    result = charge(battery("lead_acid_12v7ah"), mode, settings(soc, sample_interval_s=1.0, windows=ends))
    last = np.flatnonzero(np.diff(result.waveform["window"], append=-1))
    return {
        "soc": result.trace["soc"],
        "temperature_k": result.trace["Surface Temperature / degC"] + 273.15,
        "voltage_v": result.waveform["voltage_v"][last],
        "side": result.trace["side_current_a"],
        "current": result.trace["Current / A"],
        "limited": result.trace["voltage_limited_share"],
    }


def main() -> None:
    print(f"{'window':26s} {'dSOC':>9s} {'dT [K]':>9s} {'dV [V]':>9s} {'clipped':>8s} {'side/current':>12s}")
    for name, soc in WINDOWS.items():
        ours, states = engine(soc), reference(soc, SECONDS, LIMIT_V, rtol=1e-10)
        rest = [circuit(state, "current", 0.0) for state in states]
        voltage = np.array([CELLS * (node + ohm * total) for total, _, _, node, ohm in rest])
        gaps = (
            np.abs(ours["soc"] - (1 - states[:, 0])).max(),
            np.abs(ours["temperature_k"] - states[:, 4]).max(),
            np.abs(ours["voltage_v"] - voltage[: len(ours["voltage_v"])]).max(),
        )
        side = ours["side"][-1] / ours["current"][-1]
        print(f"{name:26s} {' '.join(f'{gap:9.1e}' for gap in gaps)} {ours['limited'].mean():8.0%} {side:12.1%}")


if __name__ == "__main__":
    main()
