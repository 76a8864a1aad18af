"""Batteries and modes of the configuration, and the lists that every test over all of them goes through."""

from pathlib import Path

import yaml

from pipeline.cell.records import Battery
from pipeline.charge.records import ChargeSettings, EngineSettings, Mode
from pipeline.charge.simulate import BENCH, simulate

CONF = Path(__file__).parents[2] / "conf"
# A charge that needs more steps than this has gone wrong.
ENGINE = EngineSettings(driver="edge", maximum_steps=2_000_000)


def load(path):
    """Read a file of the configuration as the records take it: without sources, over its defaults.

    A frequency that a search is to find is about what it finds.
    """
    data = yaml.safe_load((CONF / path).read_text())
    data.pop("sources", None)
    if "frequency_hz" in data:
        data["frequency_hz"] = 90.0
    bases = [base for base in data.pop("defaults", []) if base != "_self_"]
    for base in bases:
        data = load(f"{path.split('/')[0]}/{base}.yaml") | data
    return data


def battery(name):
    return Battery(**load(f"battery/{name}.yaml"))


# Currents and voltage limits that suit each chemistry: (charge C-rate, limit in volt of the battery, SOC at the start).
SUITED = {
    "lead_acid_12v7ah": (0.3, 14.4, 0.8),
    "lead_acid_12v18ah": (0.3, 14.4, 0.8),
    "lead_acid_generic": (0.3, 13.0, 0.8),
    "nicd_2s_600mah": (4.0, 3.55, 0.8),
    "lfp_8ah": (2.0, 3.42, 0.8),
}
BATTERIES = sorted(SUITED)
MODES = ["cc_cv", "cv_pulse", "cv_reflex", "cv_reflex_hourly"]


def suited_mode(name, cell, bulk_s=20.0, stop_s=40.0):
    """Return a mode of the configuration with currents and voltage suited to a battery, shortened."""
    rate, voltage, _ = SUITED[cell]
    sheet = load(f"modes/{name}.yaml")
    for knob, share in (("max_current", 1.0), ("charge", 1.0), ("discharge", 0.25)):
        if sheet.pop(f"{knob}_a", None) is not None:
            sheet[f"{knob}_c_rate"] = share * rate
    sheet["voltage_v"] = voltage
    for phase in sheet["phases"].values():
        if "elapsed_s" in phase.get("until", {}):
            phase["until"]["elapsed_s"] = bulk_s
    sheet["stop"] = {"elapsed_s": stop_s}
    return Mode(**sheet)


def settings(soc, **more):
    return ChargeSettings(**({"initial_soc": soc, "ambient_c": 25.0} | more))


def charge(cell, mode, conditions, supply=BENCH, engine=ENGINE):
    return simulate(cell, mode, supply, conditions, engine)


def values(result):
    return {row.quantity: row.value if row.text is None else row.text for row in result.summary}
