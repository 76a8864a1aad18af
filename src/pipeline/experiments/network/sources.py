"""What the steps of the network take: the data of every surface, and the paper's tables of its network."""

from __future__ import annotations

import csv

from pipeline.experiments.network.surfaces import Printed
from pipeline.grnn.records import Data, data_of
from pipeline.kernel.artefacts import Inputs
from pipeline.published.reference import REFERENCE

LEARNT = "learnt"
"""Name of the data that the network learns, among the surfaces."""


def surfaces(inputs: Inputs) -> dict[str, Data]:
    """Return the data of every surface that the step `surface` made, `LEARNT` among them."""
    table = inputs.table("surface", "surface")
    found = {}
    for name in dict.fromkeys(map(str, table["surface"])):
        own = {key: values[table["surface"] == name] for key, values in table.items()}
        seconds = float(own["gradient_seconds"][0])
        found[name] = data_of(own["temperature_c"], own["gradient"], own["rate_c"], seconds)
    return found


def printed_rows() -> list[Printed]:
    """Return those rows of the paper's Table II that are legible as a whole."""
    found = []
    for row in printed("nicd_table2"):
        numbers = [row[key] for key in ("temperature_c", "gradient", "rate_c")]
        if all(numbers):
            temperature, gradient, rate = map(float, numbers)
            found.append(Printed(int(row["row"]), temperature, gradient, rate, row["certainty"]))
    return found


def printed_temperatures() -> set[float]:
    """Return the temperatures legible in the paper's Table II, also of rows that are not as a whole [degC]."""
    return {float(row["temperature_c"]) for row in printed("nicd_table2") if row["temperature_c"]}


def printed_mse() -> float:
    """Return the error that the paper's Table III prints for its network [C-rate^2]."""
    return next(float(row["mse"]) for row in printed("nicd_table3") if row["network"] == "GA-trained GRNN")


def printed(name: str) -> list[dict[str, str]]:
    """Return the rows of a table of the paper as printed: column -> text, empty where it cannot be read."""
    with (REFERENCE / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))
