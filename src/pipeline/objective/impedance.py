"""The frequency at which a pulse charger that looks for the least impedance ends up; it is not that of least loss.

Chen, "A design of an optimal battery pulse charge system by frequency-varied technique", IEEE Trans. Ind. Electron. 54
(2007) 398, DOI 10.1109/TIE.2006.888796. The impedance is Z = j w L + R_0 + R / (1 + j w R C).
"""

from __future__ import annotations

import math


def impedance_ohm(
    frequency_hz: float, inductance_h: float, series_ohm: float, pair_ohm: float, pair_f: float
) -> complex:
    """Return the impedance [ohm] of inductance, series resistance and one pair at a frequency [Hz]."""
    omega = 2.0 * math.pi * frequency_hz
    return 1j * omega * inductance_h + series_ohm + pair_ohm / (1.0 + 1j * omega * pair_ohm * pair_f)


def impedance_minimum_hz(inductance_h: float, series_ohm: float, pair_ohm: float, pair_f: float) -> float:
    """Return the frequency of least |Z|.

    Arguments
    ---------
    inductance_h : inductance of battery and leads [H].
    series_ohm : series resistance R_0 [ohm].
    pair_ohm, pair_f : charge-transfer resistance R [ohm] and double-layer capacitance C [F].

    Returns
    -------
    Frequency [Hz] from d|Z|^2/dw = 0; 0 where |Z| rises from direct current on.
    """
    time_constant = pair_ohm * pair_f
    root = math.sqrt(
        2.0 * inductance_h * pair_ohm**2 * pair_f + pair_ohm**3 * pair_f**2 * (2.0 * series_ohm + pair_ohm)
    )
    square = (root / inductance_h - 1.0) / time_constant**2
    return math.sqrt(max(square, 0.0)) / (2.0 * math.pi)


def resonance_hz(inductance_h: float, pair_ohm: float, pair_f: float) -> float:
    """Return the frequency [Hz] at which Z is real, 1/(L C) - 1/(R C)^2 = w^2; 0 where there is none."""
    square = 1.0 / (inductance_h * pair_f) - 1.0 / (pair_ohm * pair_f) ** 2
    return math.sqrt(max(square, 0.0)) / (2.0 * math.pi)
