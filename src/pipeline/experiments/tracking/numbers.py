"""The numbers that the steps of tracking find: names, units, meanings."""

from __future__ import annotations

from pipeline.quantity import Vocabulary

CONVERTER_NUMBERS = Vocabulary(
    {
        "{converter}_full_efficiency": ("1", "at the panel's power"),
        "{converter}_best_efficiency": ("1", "highest over load"),
        "{converter}_best_w": ("W", "input power of that load"),
        "{converter}_off_switched": ("1", "largest difference to the switches"),
    }
)

TRACKING_NUMBERS = Vocabulary(
    {
        "{tracker}_steady_efficiency": ("1", "captured at 1000 W/m2, settled"),
        "{tracker}_ripple_v": ("V", "swing of the panel's voltage there"),
        "{tracker}_ripple_w": ("W", "swing of the power of its periods there"),
        "{tracker}_start_s": ("s", "settling time from near open circuit"),
        "{tracker}_step_s": ("s", "settling time after a step"),
        "{tracker}_ramps_efficiency": ("1", "mean over the ramps of captured / available"),
        "{tracker}_worst_ramp": ("1", "the least of them"),
    }
)
