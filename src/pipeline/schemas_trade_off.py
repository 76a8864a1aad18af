"""The table of the trade-off between charge time and peak temperature."""

from __future__ import annotations

from pipeline.tables import Column, Table

TRADE_OFF = Table(
    "trade_off",
    "Charge time and peak temperature, a row per charge",
    (
        Column("law", "", "constant_current, or the name of the mode", "text"),
        Column("c_rate", "1", "constant current [C-rate]; empty for a mode", optional=True),
        Column("stop", "", "name of what stops a constant current; empty for a mode, which has its own", "text"),
        Column("condition", "", "name of the condition", "text"),
        Column("sensor", "", "name of the sensor a mode sees through, own for that of its sheet", "text"),
        Column("time_to_full_s", "s", "time until charged; empty where the charge ended before", optional=True),
        Column("peak_temperature_c", "degC", "highest battery temperature of the whole charge"),
        Column("end_time_s", "s", "time at which the charge ended"),
        Column("end_soc", "1", "state of charge at the end"),
        Column("charge_in_share", "1", "charge put in over the capacity"),
        Column("end_reason", "", "what ended the charge", "text"),
    ),
)
