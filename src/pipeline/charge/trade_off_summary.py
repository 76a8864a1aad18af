"""The trade-off in numbers: what the network reaches, and who else reaches it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from pipeline.charge.trade_off import Row
from pipeline.charge.trade_off_records import CONSTANT, ENDED, OWN, TradeOff
from pipeline.quantity import Quantity

SAME_TIME = 1e-3
"""Share of a charge time by which nobody would call a charge slower."""


def quantities(rows: Sequence[Row], chosen: TradeOff) -> list[Quantity]:
    """Return the named numbers of a trade-off; those of a mode that was not charged are left out.

    Arguments
    ---------
    rows : its charges.
    chosen : its settings, which name the modes that stand for the network and the rule.
    """
    found: list[Quantity] = []
    for condition in chosen.conditions:
        here = [row for row in rows if row.condition == condition]
        constants = [row for row in here if row.law == CONSTANT and not math.isnan(row.time_to_full_s)]
        for who, law in (("network", chosen.candidate), ("rule", chosen.rule)):
            for row in (one for one in here if one.law == law and one.sensor == OWN):
                found += _reached(who, condition, row)
                found.append(
                    Quantity(
                        f"{who}_charge_in_{condition}", row.charge_in_share, "1", "charge put in over the capacity"
                    )
                )
                if who == "network":
                    found += _rivals(condition, row, constants)
    for sensor in chosen.sensors:
        found += _behind(rows, sensor, chosen)
    first = next(iter(chosen.conditions))
    return found + [
        Quantity(
            ENDED.format(rate=row.c_rate, stop=row.stop), row.end_time_s, "s", f"end of the charge, {row.end_reason}"
        )
        for row in rows
        if row.law == CONSTANT and row.condition == first
    ]


def _rivals(condition: str, network: Row, constants: Sequence[Row]) -> Iterator[Quantity]:
    """Yield the fastest constant current that gets no hotter than the network, and the coolest that is no slower."""
    no_hotter = [row for row in constants if row.peak_temperature_c <= network.peak_temperature_c]
    if no_hotter:
        rival = min(no_hotter, key=lambda row: (round(row.time_to_full_s, 3), row.peak_temperature_c))
        yield from _reached("rival", condition, rival)
        yield Quantity(f"rival_c_rate_{condition}", rival.c_rate, "1", f"its current; stopped by {rival.end_reason}")
    no_slower = [row for row in constants if row.time_to_full_s <= (1.0 + SAME_TIME) * network.time_to_full_s]
    if no_slower:
        coolest = min(no_slower, key=lambda row: (row.peak_temperature_c, row.time_to_full_s))
        yield from _reached("coolest", condition, coolest)
        yield Quantity(
            f"coolest_c_rate_{condition}", coolest.c_rate, "1", f"its current; stopped by {coolest.end_reason}"
        )


_WHO = {
    "network": "the network's charge",
    "rule": "the plain rule's charge",
    "rival": "the fastest constant current that gets no hotter than the network",
    "coolest": "the coolest constant current that is no slower than the network",
}


def _reached(who: str, condition: str, row: Row) -> Iterator[Quantity]:
    yield Quantity(f"{who}_time_to_full_{condition}_s", row.time_to_full_s, "s", f"{_WHO[who]}: time until charged")
    yield Quantity(f"{who}_peak_{condition}_c", row.peak_temperature_c, "degC", f"{_WHO[who]}: highest temperature")


def _behind(rows: Sequence[Row], sensor: str, chosen: TradeOff) -> Iterator[Quantity]:
    for row in (one for one in rows if one.sensor == sensor):
        who = "network" if row.law == chosen.candidate else "rule" if row.law == chosen.rule else ""
        if who:
            name, said = f"{who}_time_to_full_behind_{sensor}_s", f"{_WHO[who]} behind this sensor: time until charged"
            yield Quantity(name, row.time_to_full_s, "s", said)
        if who == "network":
            yield Quantity(f"network_peak_behind_{sensor}_c", row.peak_temperature_c, "degC", "its highest temperature")
        if who == "rule":
            yield Quantity(f"rule_end_soc_behind_{sensor}", row.end_soc, "1", "state of charge at its end")
