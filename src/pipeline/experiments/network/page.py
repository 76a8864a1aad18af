"""The network on the page: tables of the network that commands a charger; Tables I to III of the paper among them."""

from __future__ import annotations

import numpy as np

from pipeline.experiments.network import sources
from pipeline.experiments.network.records import USED, gradient_unit
from pipeline.report.tables import Cell, ReportData, ReportTable, plain

LABELS = ()
_ERROR = "MSE / (C-rate)²"
# Errors below this are rounding.
_ROUNDING = 1e-12
_NUMBERS = {
    "surface": ("The data in numbers", "C stands for the C-rate: the current that charges the battery in an hour."),
    "network": ("The network in numbers", "Errors are mean squares over all points of the data [C-rate²]."),
}


def tables(data: ReportData) -> list[ReportTable]:
    """Return the tables of those steps of the network that a run holds."""
    shown: list[ReportTable] = []
    if "network" in data.inputs:
        shown += [table_1(data), table_2(data), table_3(data), selections(data)]
    if "surface" in data.inputs:
        shown.append(printed_rows(data))
    if "network_size" in data.inputs:
        shown.append(sizes(data))
    if "network_kernels" in data.inputs:
        shown.append(kernels(data))
    return shown + [numbers(data, source) for source in _NUMBERS if source in data.inputs]


def table_1(data: ReportData) -> ReportTable:
    """Return the settings of the genetic algorithm."""
    found = data.numbers("network")
    rows: list[tuple[Cell, ...]] = [
        (title, found.get(name))
        for name, title in (
            ("population", "population"),
            ("crossover", "crossover"),
            ("mutation", "mutation"),
            ("elite", "elite"),
            ("generations", "generations behind the network that is used"),
            ("long_generations", "generations in all"),
            ("genetic_evaluations", "evaluations behind the network that is used"),
        )
    ]
    return ReportTable(
        "nicd_table_1",
        "The genetic algorithm",
        "As run. Population, crossover, mutation and generations are the paper's.",
        ("parameter", "value"),
        tuple(rows),
        paper="Table I",
    )


def table_2(data: ReportData) -> ReportTable:
    """Return the six selected rows of the data, as printed and as our algorithm selects them."""
    rows: list[tuple[Cell, ...]] = []
    for row in sources.printed("nicd_table2"):
        values = (float(row[key]) if row[key] else None for key in ("temperature_c", "gradient", "rate_c"))
        rows.append(("printed", int(row["row"]), *(None if one is None else plain(one) for one in values), None))
    table = data.table("network", "networks")
    own = table["network"] == USED
    columns = (table[name][own] for name in ("centre", "temperature_c", "gradient", "rate_c", "row"))
    unit = gradient_unit(float(table["gradient_seconds"][0]))
    rows += [("selected here", *map(plain, row)) for row in zip(*columns, strict=True)]
    return ReportTable(
        "nicd_table_2",
        "The data points that become centres",
        "An empty cell of the printed table cannot be read in its scan. Ours come from a surface that stands in for "
        f"the lost data, with dT/dt in {unit}.",
        ("table", "No.", "T / °C", f"dT/dt / {unit}", "rate / C", "row of the data"),
        tuple(rows),
        paper="Table II",
        grouped=True,
    )


def table_3(data: ReportData) -> ReportTable:
    """Return the networks against each other, printed and computed."""
    found = data.numbers("network")
    units, error = found["units"], found.get
    ours: dict[str, list[tuple[Cell, ...]]] = {
        "ANFIS": [("ANFIS", found["nodes_of_anfis"], error("anfis_mse"), None)],
        "GRNN": [
            (f"GRNN, {words} points", units, error(f"{name}_mse"), error(f"{name}_mse_median"))
            for name, words in (("random", "random"), ("regular", "regular"), ("least_squares", "least squares'"))
            if f"{name}_mse" in found
        ],
        "GA-trained GRNN": [("GA-trained GRNN", units, error("genetic_mse"), error("genetic_mse_median"))],
    }
    rows: list[tuple[Cell, ...]] = []
    for row in sources.printed("nicd_table3"):
        theirs = (int(row["layers"]), int(row["nodes"]), float(row["mse"]))
        rows += [(row["network"], *theirs, *one) for one in ours[row["network"]]]
    return ReportTable(
        "nicd_table_3",
        "Neuro-fuzzy system, GRNN and GA-trained GRNN",
        "The paper's systems were trained on data that are lost; ours on a surface that stands in for them. How the "
        "paper's GRNN [7] chose its points is not said: random, regular and least-squares points stand in for it.",
        (
            "printed",
            "layers",
            "nodes",
            _ERROR,
            "computed here",
            "nodes or units",
            f"least {_ERROR}",
            f"median {_ERROR}",
        ),
        tuple(rows),
        paper="Table III",
        grouped=True,
    )


def selections(data: ReportData) -> ReportTable:
    """Return every method of selecting centres."""
    found = data.numbers("network")
    names = [str(name) for name in dict.fromkeys(data.table("network", "selections")["method"])]
    parts = ("mse", "mse_median", "mse_worst", "share_at_printed", "evaluations", "replicates", "width_temperature",
             "width_gradient")  # fmt: skip
    rows = [
        (name.replace("_", " "), *(found.get(f"{name}_{part}") for part in parts), *_effect(found, name))
        for name in names
    ]
    return ReportTable(
        "network_selections",
        "Ways to select the centres",
        "Each at the widths that suit it. A: the chance that the genetic algorithm's error is the larger one (Vargha "
        "and Delaney), with its 95 % interval; below 0.5 the genetic algorithm is better.",
        (
            "selection",
            f"least {_ERROR}",
            "median",
            "worst",
            "share at the printed MSE",
            "evaluations",
            "replicates",
            "width T",
            "width dT/dt",
            "A",
            "low",
            "high",
        ),
        tuple(rows),
    )


def printed_rows(data: ReportData) -> ReportTable:
    """Return which surfaces agree with the rows of Table II that can be read."""
    table = data.table("surface", "printed")
    rows = []
    for row in range(len(table["surface"])):
        values = [table[name][row] for name in ("temperature_c", "gradient", "printed_rate_c", "computed_rate_c")]
        says = "yes" if table["consistent"][row] else "no"
        surface = str(table["surface"][row]).replace("_", " ")
        rows.append((surface, int(table["row"][row]), *map(plain, values), says, str(table["certainty"][row])))
    return ReportTable(
        "surfaces_against_table_2",
        "Which surfaces agree with Table II",
        "The legible rows of the printed table against the surfaces that could stand in for the lost data.",
        ("surface", "row", "T / °C", "dT/dt", "printed / C", "surface / C", "agrees", "legibility"),
        tuple(rows),
        grouped=True,
    )


def sizes(data: ReportData) -> ReportTable:
    """Return the error against the number of centres."""
    found = data.numbers("network_size")
    counts = np.unique(data.table("network_size", "sizes")["centres"])
    parts = ("units", "mse", "mse_median", "forward_mse")
    rows: list[tuple[Cell, ...]] = []
    for count in counts.tolist():
        units, *errors = (found[f"size_{count}_{part}"] for part in parts)
        rows.append((count, units, *(error if error > _ROUNDING else 0.0 for error in errors)))
    return ReportTable(
        "network_sizes",
        "How many centres are enough?",
        "A surface that depends on temperature alone is met at every point of the grid by as many centres as it has "
        "different rates; the error then says nothing of the points between.",
        ("centres", "units", f"least {_ERROR}", "median", "forward selection"),
        tuple(rows),
    )


def kernels(data: ReportData) -> ReportTable:
    """Return every kernel on every surface."""
    found, table = data.numbers("network_kernels"), data.table("network_kernels", "kernels")
    pairs = dict.fromkeys(zip(map(str, table["surface"]), map(str, table["kernel"]), strict=True))
    rows: list[tuple[Cell, ...]] = []
    for surface, kernel in pairs:
        own = (table["surface"] == surface) & (table["kernel"] == kernel)
        widths = (plain(table[name][own][0]) for name in ("width_temperature", "width_gradient"))
        errors = (found.get(f"{surface}_{kernel}_{part}") for part in ("mse", "mse_median"))
        rows.append((surface.replace("_", " "), kernel, *errors, *widths))
    return ReportTable(
        "network_kernels",
        "Every kernel on every surface",
        "Six centres by the genetic algorithm. The paper prints 0.0046, for a kernel and data it does not give.",
        ("surface", "kernel", f"least {_ERROR}", "median", "width T", "width dT/dt"),
        tuple(rows),
        grouped=True,
    )


def numbers(data: ReportData, source: str) -> ReportTable:
    """Return the named numbers that a step found."""
    title, caption = _NUMBERS[source]
    table = data.table(source, "quantities")
    columns = (table[name] for name in ("quantity", "value", "unit", "description"))
    rows = tuple(tuple(map(plain, row)) for row in zip(*columns, strict=True))
    return ReportTable(f"numbers_{source}", title, caption, ("quantity", "value", "unit", "meaning"), rows)


def _effect(found: dict[str, float], name: str) -> tuple[float | None, ...]:
    return tuple(found.get(f"genetic_over_{name}{end}") for end in ("", "_low", "_high"))
