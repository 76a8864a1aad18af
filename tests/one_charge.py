"""`python -m tests.one_charge`: the package imports and charges a battery, whatever the version of Python."""

from __future__ import annotations

import sys

import pipeline

CHARGED_SOC = 0.99


def main() -> int:
    """Charge; return 1 where the charge is not what it is to be."""
    charge = pipeline.charge(battery="lead_acid_12v7ah", mode="cc_cv", initial_soc=0.2)
    found = charge.summary
    told = f"SOC {found['end_soc']:.6f} after {found['end_time_s']:.6f} s"
    sys.stdout.write(f"Python {sys.version.split()[0]}: {told}\n")
    right = abs(found["end_soc"] - CHARGED_SOC) < 1e-9 and abs(found["energy_balance_residual"]) < 1e-9
    return 0 if right else 1


if __name__ == "__main__":
    sys.exit(main())
