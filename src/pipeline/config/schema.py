"""A JSON schema of the configuration: the root record, and a part of it for every group of `conf/`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any

from pipeline.charge.waveforms import WAVEFORMS
from pipeline.config.compose import groups
from pipeline.config.inheritance import CONF, content, roots
from pipeline.config.sources import Source
from pipeline.config.study import study_type
from pipeline.kernel import registry

DIALECT = "https://json-schema.org/draft/2020-12/schema"
_SOURCES = {"description": "where the values come from: key -> {kind, ref, ...}, or nested as the values are"}
_TEXT = {"type": "string", "pattern": r"\$\{", "description": "another value of the configuration"}
_ROOT = "group:study"


def schema() -> dict[str, Any]:
    """Return the schema.

    A file of `conf/` holds a part of a configuration that others complete, so nothing is required in it; beside what
    the records declare it may hold `defaults` and `sources`, and `${...}` wherever a value stands.

    Returns
    -------
    JSON schema, draft 2020-12; `$defs` has one entry `group:NAME` for each group, the schema of the files in it.
    """
    whole = study_type().model_json_schema(by_alias=True)
    definitions: dict[str, Any] = whole.pop("$defs")
    definitions["Source"] = Source.model_json_schema()
    root = _open(whole)
    for name in ("configuration", "overrides", "sources", "run"):
        root["properties"].pop(name, None)
    for one in registry.experiments().values():
        for name, record in one.written.items():
            form = _open(record.model_json_schema())  # type: ignore[attr-defined]
            definitions |= form.pop("$defs", {})
            root["properties"][name] = {"anyOf": [root["properties"][name], form]}
    root["properties"]["modes"] = _modes(root["properties"]["modes"])
    if "Phase" in definitions:
        # A phase is written under the name of its waveform.
        definitions["Phase"]["properties"] |= {name: {"type": ["object", "null"]} for name in WAVEFORMS}
    for one in definitions.values():
        for name in ("columns", "units"):
            # Of a person's file: a quantity of which nothing is said yet stands there to be overridden.
            entry = one.get("properties", {}).get(name, {})
            if entry.get("additionalProperties") == {"type": "string"}:
                entry["additionalProperties"] = {"type": ["string", "null"]}
    found = {name: _open(one) for name, one in definitions.items()}
    found |= {f"group:{name}": one for name, one in _groups(root)}
    return {"$schema": DIALECT, "title": "Configuration of a study", "$ref": f"#/$defs/{_ROOT}", "$defs": found}


def _groups(root: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the schema of the files of each group: of the place where the studies put them."""
    properties = root["properties"]
    places = _places()
    for group in groups():
        if group == "study":
            yield group, dict(root)
            continue
        place = places.get(group, group)
        part = _at(properties, place)
        yield group, part if part is not None else {"type": "object"}


def _places() -> dict[str, str]:
    """Return group -> the key path at which the defaults lists of `conf/` put its files."""
    found: dict[str, str] = {}
    for file in (file for root in roots(CONF) for file in sorted(root.rglob("*.yaml"))):
        for entry in content(file).get("defaults", []):
            for key in entry if isinstance(entry, Mapping) else ():
                group, _, package = str(key).removeprefix("override ").strip("/").partition("@")
                inside = "" if file.parent.name == "study" else f"{file.parent.name}."
                found.setdefault(group, f"{inside}{package or group}")
    return found


def _at(properties: Mapping[str, Any], place: str) -> dict[str, Any] | None:
    head, _, rest = place.partition(".")
    part = properties.get(head)
    if part is None:
        return None
    if not rest:
        return dict(part)
    # Below an entry of a mapping, as `calibrations.NAME`, the schema of the entries.
    options = [part, *part.get("anyOf", [])]
    entries = next(
        (one["additionalProperties"] for one in options if isinstance(one.get("additionalProperties"), dict)), None
    )
    return dict(entries) if entries is not None else None


def _modes(part: Mapping[str, Any]) -> dict[str, Any]:
    """Return the schema of `modes`: modes by name, and under `run` the names of those that are charged."""
    return {**part, "properties": {"run": {"type": "array", "items": {"type": "string"}}}}


def _open(part: Any) -> Any:
    """Return the schema of a part of what another describes: nothing required; `defaults`, `sources`, `${...}` too."""
    if isinstance(part, list):
        return [_open(one) for one in part]
    if not isinstance(part, Mapping):
        return part
    kept = {key: _open(one) for key, one in part.items() if key not in ("required", "discriminator")}
    if "oneOf" in kept:
        # A part of a value may fit several of its forms.
        kept["anyOf"] = kept.pop("oneOf")
    if "properties" in kept:
        kept["properties"] = {
            **kept["properties"],
            "sources": deepcopy(_SOURCES),
            "defaults": {"type": "array", "description": "files that this one builds on, as Hydra reads them"},
        }
    if kept.get("type") in ("number", "integer", "boolean"):
        kept = {"anyOf": [kept, _TEXT]}
    return kept
