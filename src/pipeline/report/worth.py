"""Is the network worth it? Its charge beside the plain rule's and the constant currents that are no worse."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pipeline.report.data import ReportData
from pipeline.report.tables import Cell, ReportTable

_RIVALS = (
    ("network", "the network"),
    ("rule", "the plain rule"),
    ("rival", "fastest constant current that gets no hotter than the network"),
    ("coolest", "coolest constant current that is no slower than the network"),
)


def worth(data: ReportData) -> ReportTable:
    """Return time and temperature of the network and its rivals in each condition, and what they come to in words."""
    found = data.numbers("trade_off")
    settings: Mapping[str, Any] = data.settings.get("trade_off", {})
    titles = {name: one["title"] for name, one in settings.get("conditions", {}).items()}
    rows: list[tuple[Cell, ...]] = []
    for condition, title in titles.items():
        for who, words in _RIVALS:
            time, peak = (found.get(f"{who}_{part}") for part in (f"time_to_full_{condition}_s", f"peak_{condition}_c"))
            if time is None and peak is None:
                continue
            rate = found.get(f"{who}_c_rate_{condition}")
            rows.append((title, words if rate is None else f"{words}: {rate:g}C", time, peak))
    full = 100.0 * float(settings.get("full_soc", 0.0))
    return ReportTable(
        "worth",
        "Is the network worth it?",
        answer(found, titles),
        ("condition", "charge", f"time until {full:g} % charged / s", "peak temperature / °C"),
        tuple(rows),
        grouped=True,
    )


def answer(found: Mapping[str, float], titles: Mapping[str, str]) -> str:
    """Return the answer as sentences, every number of which was computed.

    Arguments
    ---------
    found : the trade-off's numbers.
    titles : name of each condition -> its title.
    """
    known = [name for name in titles if f"network_time_to_full_{name}_s" in found]
    if not known:
        return "The network did not charge the battery in this run."
    beaten = [name for name in known if _beaten(found, name)]
    first = known[0]
    network = _both(found, "network", first)
    verdict = "No" if len(beaten) == len(known) else "Yes" if not beaten else "Not always"
    sentences = [
        f"{verdict}, in this model: in {len(beaten)} of {len(known)} conditions a constant current with one plain stop "
        "is no slower and stays cooler.",
        f"At {titles[first]}, the network takes {network}.",
    ]
    if f"rival_peak_{first}_c" in found:
        rate = found[f"rival_c_rate_{first}"]
        sentences.append(
            f"The best constant current that gets no hotter, {rate:g}C, takes {_both(found, 'rival', first)}."
        )
    if f"rule_peak_{first}_c" in found and f"rule_time_to_full_{first}_s" in found:
        sentences.append(f"The plain rule takes {_both(found, 'rule', first)}.")
    sentences += _sensors(found)
    return " ".join(sentences)


def _beaten(found: Mapping[str, float], condition: str) -> bool:
    coolest, network = (found.get(f"{who}_peak_{condition}_c") for who in ("coolest", "network"))
    return coolest is not None and network is not None and coolest < network


def _both(found: Mapping[str, float], who: str, condition: str) -> str:
    return (
        f"{found[f'{who}_time_to_full_{condition}_s']:.0f} s and peaks at {found[f'{who}_peak_{condition}_c']:.1f} °C"
    )


def _sensors(found: Mapping[str, float]) -> list[str]:
    """Say behind how many sensors each of the two still charges the battery."""
    behind = "rule_end_soc_behind_"
    sensors = [name.removeprefix(behind) for name in found if name.startswith(behind)]
    if not sensors:
        return []
    charged = {
        who: sum(f"{who}_time_to_full_behind_{sensor}_s" in found for sensor in sensors) for who in ("network", "rule")
    }
    return [
        f"What speaks for it: behind {charged['network']} of {len(sensors)} sensors that read in steps or with noise "
        f"the network still charges the battery, the plain rule behind {charged['rule']}."
    ]
