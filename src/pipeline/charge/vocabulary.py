"""The numbers in the summary of a charge: names, units, meanings."""

from __future__ import annotations

from pipeline.quantity import Vocabulary

SUMMARY = Vocabulary(
    {
        "time_to_soc_{mark}_s": ("s", "time at which SOC {mark} was first reached"),
        "temperature_rise_at_soc_{mark}_k": ("K", "rise over the ambient when SOC {mark} was first reached"),
        "end_time_s": ("s", "time at which the charge ended"),
        "end_soc": ("1", "state of charge at the end"),
        "end_reason": ("", "what ended the charge"),
        "missed": ("", "goals it did not reach and why, phases that never ran or were over as they began; else empty"),
        "charge_in_ah": ("Ah", "charge put in, discharge pulses not subtracted"),
        "charge_out_ah": ("Ah", "charge taken out by discharge pulses"),
        "energy_in_wh": ("Wh", "energy put in, discharge pulses not subtracted"),
        "energy_out_wh": ("Wh", "energy taken out by discharge pulses"),
        "charge_efficiency": ("1", "charge gained (SOC) over net charge put in; none where none was"),
        "energy_efficiency": (
            "1",
            "stored chemical energy H(SOC) gained over net electrical energy put in; what discharge pulses "
            "give up outside the battery is not counted as lost",
        ),
        "energy_drawn_wh": (
            "Wh",
            "energy drawn at the source: from the panel, for converters and side loads too; of a bench supply, what is "
            "put in",
        ),
        "system_efficiency": (
            "1",
            "stored chemical energy H(SOC) gained over all energy drawn at the source; what the resistor of discharge "
            "pulses, converters and side loads take is counted as lost",
        ),
        "peak_temperature_c": ("degC", "highest battery temperature"),
        "peak_temperature_rise_k": ("K", "highest rise over the ambient"),
        "end_temperature_c": ("degC", "battery temperature at the end"),
        "peak_temperature_rate_k_s": ("K/s", "highest rate of the battery temperature, over a sampling interval"),
        "mean_current_a": ("A", "net charge put in over time"),
        "time_at_voltage_limit_s": ("s", "time with the voltage at its limit, or above it without current"),
        "time_at_supply_limit_s": ("s", "time with the supply at its limit"),
        "energy_balance_residual": ("1", "first law's residual over energy in"),
        "steps": ("1", "steps integrated, rejected ones and those of root finding included"),
        "edges": ("1", "segments of the waveform begun"),
        "control_changes": ("1", "changes between current, voltage and supply limit"),
    }
)
