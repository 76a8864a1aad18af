"""A panel that is named instead of described: its values from a database, each with its source."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from pipeline.config.compose import Composed, options
from pipeline.config.messages import explain
from pipeline.errors import UserError
from pipeline.panel import database
from pipeline.panel.database import PanelEntry, look_up, reference
from pipeline.panel.records import Panel
from pipeline.panel.single_diode import fit


def by_name(composed: Composed, values: dict[str, Any], written: dict[str, Any]) -> dict[str, Any]:
    """Put the values of a panel that stands in a database in the place of its name.

    Arguments
    ---------
    values : the composed tree without sources.
    written : key path -> source; those of the panel are added.

    Returns
    -------
    The tree with the panel described.

    Raises
    ------
    UserError : no such database or name, or a data sheet that no single-diode curve goes through.
    """
    given = values.get("panel")
    if not isinstance(given, Mapping):
        return values
    if "database" not in given:
        try:
            made, estimates = database.completed(given)
        except UserError as error:
            raise UserError(f"{composed.origin('panel.technology')}: panel.{error}") from None
        written.update({f"panel.{name}": source for name, source in estimates.items()})
        return values | {"panel": made}
    try:
        entry = PanelEntry.model_validate(given)
    except ValidationError as error:
        raise explain(error, given, "panel", composed.origin, PanelEntry) from None
    try:
        found = look_up(entry)
        if entry.database == "sandia":  # no parameters of the model stand there
            fit(Panel.model_validate(found))
    except UserError as error:
        own = f"; conf/panel/{entry.name}.yaml is chosen with panel={entry.name}" * (entry.name in options("panel"))
        raise UserError(f"{composed.origin('panel.name')}: panel.name: {error}{own}") from None
    except ValidationError as error:
        raise explain(error, found, "panel", composed.origin("panel.name"), Panel) from None
    source = {"kind": "data_sheet", "ref": reference(entry)}
    for name, value in found.items():
        if name not in given and not isinstance(value, str):
            written[f"panel.{name}"] = source
    return values | {"panel": found}
