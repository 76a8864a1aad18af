"""Is the network worth it? Its charge beside the plain rule's and the constant currents that are no worse."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from pipeline.experiments.trade_off.records import SAME_TIME
from pipeline.report.pages import PageFigure, PageSection
from pipeline.report.tables import Cell, ReportData, ReportTable

LABELS = ("trade_off",)
_RIVALS = (
    ("network", "the network"),
    ("rule", "the plain rule"),
    ("rival", "fastest constant current that gets no hotter than the network"),
    ("coolest", "coolest constant current that is no slower than the network"),
)


def sections(data: ReportData, figures: Sequence[PageFigure]) -> list[PageSection]:
    """Return the section on what the network is worth; none where the run does not weigh it.

    Arguments
    ---------
    figures : those of this experiment that the paper does not have.
    """
    if "trade_off" not in data.inputs:
        return []
    text = answer(data.numbers("trade_off"), titles(data))
    return [PageSection("is-it-worth-it", "Is the network worth it?", text, [worth(data)], list(figures))]


def worth(data: ReportData) -> ReportTable:
    """Return time and temperature of the network and its rivals in each condition."""
    found = data.numbers("trade_off")
    settings: Mapping[str, Any] = data.settings.get("trade_off", {})
    rows: list[tuple[Cell, ...]] = []
    for condition, title in titles(data).items():
        for who, words in _RIVALS:
            time, peak = (found.get(f"{who}_{part}") for part in (f"time_to_full_{condition}_s", f"peak_{condition}_c"))
            if time is None and peak is None:
                continue
            rate = found.get(f"{who}_c_rate_{condition}")
            rows.append((title, words if rate is None else f"{words}: {rate:g}C", time, peak))
    full = 100.0 * float(settings.get("full_soc", 0.0))
    return ReportTable(
        "worth",
        "The network beside its rivals",
        "All with ideal sensors. The constant currents are chosen in hindsight for each condition, each with one stop.",
        ("condition", "charge", f"time until {full:g} % charged / s", "peak temperature / °C"),
        tuple(rows),
        grouped=True,
    )


def titles(data: ReportData) -> dict[str, str]:
    """Return the name of each condition -> its title."""
    conditions: Mapping[str, Any] = data.settings.get("trade_off", {}).get("conditions", {})
    return {name: one["title"] for name, one in conditions.items()}


def answer(found: Mapping[str, float], titles: Mapping[str, str]) -> str:
    """Return whether the network is worth it, as sentences, every number of which was computed.

    Arguments
    ---------
    found : the trade-off's numbers.
    titles : name of each condition -> its title.
    """
    known = [name for name in titles if f"network_time_to_full_{name}_s" in found]
    if not known:
        return "The network did not charge the battery in this run."
    first, count = known[0], len(known)
    by_rule = sum(_beaten(found, "rule", name) for name in known)
    by_hindsight = sum(_beaten(found, "coolest", name) for name in known)
    verdict = "No" if by_rule == count else "Yes" if not by_rule else f"In {count - by_rule} of {count} conditions"
    sentences = [
        f"{verdict}, in this model: the plain rule, the same everywhere, is no slower and stays cooler in {by_rule} of "
        f"{count} conditions; so does a constant current with one plain stop, chosen in hindsight, in {by_hindsight}.",
        f"At {titles[first]}, the network takes {_both(found, 'network', first)}.",
    ]
    if f"rival_peak_{first}_c" in found:
        rate, rival = found[f"rival_c_rate_{first}"], _both(found, "rival", first)
        sentences.append(f"The best constant current that gets no hotter, {rate:g}C, takes {rival}.")
    if f"rule_peak_{first}_c" in found and f"rule_time_to_full_{first}_s" in found:
        sentences.append(f"The plain rule takes {_both(found, 'rule', first)}.")
    return " ".join(sentences + _sensors(found))


def _beaten(found: Mapping[str, float], who: str, condition: str) -> bool:
    """Tell whether somebody is no slower than the network, to a thousandth, and stays cooler."""
    theirs, network = (
        (found.get(f"{one}_time_to_full_{condition}_s"), found.get(f"{one}_peak_{condition}_c"))
        for one in (who, "network")
    )
    if None in theirs or None in network:
        return False
    return theirs[0] <= (1.0 + SAME_TIME) * network[0] and theirs[1] < network[1]  # type: ignore[operator]


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
