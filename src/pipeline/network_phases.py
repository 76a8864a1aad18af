"""The nodes of a charger's network: its data, the selections of its centres, its size, its kernel."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pipeline import digest
from pipeline.config.study import Study
from pipeline.draft import Draft, plain
from pipeline.errors import UserError
from pipeline.grnn.records import NetworkStudy

STEPS = ("surface", "network", "network_size", "network_kernels")
_SECTIONS = {
    "network": ("form", "selection", "anfis"),
    "network_size": ("form", "selection.genetic", "size"),
    "network_kernels": ("form", "selection.genetic", "kernels"),
}


def network(study: Study) -> Iterator[Draft]:
    """Yield the nodes of a study's network, if it has one."""
    if study.network is None:
        return
    yield Draft(
        "surface",
        "surface",
        "surface",
        _data(study.network),
        sections=("network.data",),
        shown=_shown("surface", ("surface", "printed", "quantities")),
    )
    own = plain(study.network)
    files = ("networks", "selections", "trials", "history", "response", "learning", "quantities")
    yield _selecting(study, "network", {key: own[key] for key in ("form", "selection", "anfis")}, files)
    genetic = {"form": own["form"], "genetic": own["selection"]["genetic"]}
    for part, step, table in (("size", "network_size", "sizes"), ("kernels", "network_kernels", "kernels")):
        if own[part] is not None:
            yield _selecting(study, step, {**genetic, part: own[part]}, (table, "quantities"))


def _data(settings: NetworkStudy) -> dict[str, Any]:
    """Return where the data come from; a table of a person's own stands in the key with its content."""
    found: dict[str, Any] = {"data": plain(settings.data)}
    if settings.data.table is not None:
        path = Path(settings.data.table)
        if not path.is_file():
            raise UserError(f"network.data.table: {path}: no such file")
        found["table_sha256"] = digest.of_file(path)
    return found


def _selecting(study: Study, step: str, settings: dict[str, Any], files: tuple[str, ...]) -> Draft:
    """Return a node that selects centres from the data."""
    return Draft(
        step,
        step,
        study.study.name,
        {**settings, "seed": study.seed},
        inputs={"surface": "surface"},
        sections=tuple(f"network.{part}" for part in _SECTIONS[step]),
        shown=_shown(step, files),
    )


def _shown(room: str, names: tuple[str, ...]) -> dict[str, str]:
    return {f"{name}.parquet": f"{room}/{name}.parquet" for name in names}
