"""Where every parameter comes from: the `sources:` beside the values, taken out before the values are used."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Literal

from pydantic import ValidationError, model_validator

from pipeline.config.compose import Composed
from pipeline.config.messages import explain
from pipeline.config.yaml_file import shown
from pipeline.errors import UserError, best_matches
from pipeline.kernel import registry
from pipeline.kernel.scope import below
from pipeline.record import Record

_SLACK_SOC, _NEARLY_FULL, _SLACK_K = 0.02, 0.9, 3.0

Kind = Literal["published", "data_sheet", "derived", "estimate", "calibrated", "fitted", "override", "found"]


class Source(Record):
    """Where a value comes from.

    `to` names the published statement, `<study>.<statement>`, that it or the model it enters was fitted to. `range`
    says over which values an estimate is plausible, in the value's own unit; `same_as` names the key beside it whose
    value it follows there. `file` names the measurement that a value was fitted to; `valid` says from where to where
    that went: `soc` [1], `c_rate` [C-rate], `temperature_c` [degC].
    """

    kind: Kind
    ref: str = ""
    to: str | None = None
    range: tuple[float, float] | None = None
    same_as: str | None = None
    file: str = ""
    valid: dict[Literal["soc", "c_rate", "temperature_c"], tuple[float, float]] | None = None

    @model_validator(mode="after")
    def _complete(self) -> Source:
        if self.kind == "calibrated" and not self.to:
            raise ValueError("a calibrated value must say `to` which published statement")
        if self.kind == "fitted" and not self.file:
            raise ValueError("a fitted value must say to which `file`")
        if self.kind in ("published", "data_sheet", "derived") and not self.ref:
            raise ValueError(f"a {self.kind} value needs a `ref`")
        if self.range is not None and not self.range[0] < self.range[1]:
            raise ValueError(f"range {list(self.range)} must rise")
        return self


def beyond(sources: Mapping[str, Source], initial_soc: float, ambient_c: float) -> list[str]:
    """Return in sentences where charges leave what the measurement covers that a battery was fitted to.

    Arguments
    ---------
    sources : key path -> source, of the battery.
    initial_soc, ambient_c : from which state of charge the charges run [1], and how warm it is [degC].
    """
    one = next((source for source in sources.values() if source.valid), None)
    if one is None or one.valid is None:
        return []
    said = []
    low, high = one.valid.get("soc", (0.0, 1.0))
    if initial_soc < low - _SLACK_SOC or high < _NEARLY_FULL:
        said.append(
            f"charges run from a state of charge of {initial_soc:g} upwards, {one.file} covers {low:g} to {high:g}"
        )
    cold, warm = one.valid.get("temperature_c", (ambient_c, ambient_c))
    if not cold - _SLACK_K <= ambient_c <= warm + _SLACK_K:
        said.append(f"charges run at {ambient_c:g} degC, {one.file} covers {cold:.1f} to {warm:.1f} degC")
    return [f"outside what the battery was fitted to: {line}" for line in said]


def split(tree: Mapping[str, Any], path: str = "") -> tuple[dict[str, Any], dict[str, Any]]:
    """Take every `sources` mapping out of a tree.

    Returns
    -------
    The tree without them, and key path -> source as written.
    """
    values: dict[str, Any] = {}
    found: dict[str, Any] = {}
    for key, value in tree.items():
        here = f"{path}.{key}" if path else str(key)
        if key == "sources":
            if not isinstance(value, Mapping):
                raise UserError(f"{path}.sources: value {value!r}; allowed is a mapping with the names of the values")
            found.update(_flat(value, path))
        elif isinstance(value, Mapping):
            values[key], below = split(value, here)
            found.update(below)
        else:
            values[key] = value
    return values, found


def leaves(values: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield key path and value of every number, list of numbers, and reference below `path`."""
    if isinstance(values, Mapping):
        if set(values) == {"from", "value"}:
            yield path, values
            return
        for key, value in values.items():
            yield from leaves(value, f"{path}.{key}" if path else str(key))
    elif isinstance(values, list | tuple):
        if values and all(_is_number(value) for value in values):
            yield path, list(values)
        else:
            for index, value in enumerate(values):
                yield from leaves(value, f"{path}.{index}")
    elif _is_number(values):
        yield path, values


def attribute(
    composed: Composed, values: Mapping[str, Any], written: Mapping[str, Any], sections: tuple[str, ...]
) -> dict[str, Source]:
    """Give every parameter its source.

    Arguments
    ---------
    values : the tree without sources.
    written : key path -> source as written, from `split`.
    sections : key paths below which every number needs a source.

    Returns
    -------
    Key path of every number below `sections` -> its source; an overridden value's source is `override`.

    Raises
    ------
    UserError : a number without a source, a source for a key that is not there, a source that does not read.
    """
    records = {path: _record(composed, path, source) for path, source in written.items()}
    named = [path for path in records if any(path == s or path.startswith(s + ".") for s in sections)]
    # What the command line takes out or replaces may leave its source behind.
    for path in (path for path in named if composed.overridden(path) is None):
        _check_names_a_value(composed, values, path)
    result: dict[str, Source] = {}
    missing: list[str] = []
    for section in sections:
        for path, value in leaves(_at(values, section), section):
            word = composed.overridden(path)
            # What an override takes out may get a usual value, with the source of that.
            if word is not None and not (word.startswith("~") and path in records):
                result[path] = Source(kind="override", ref=word)
            elif isinstance(value, Mapping):
                result[path] = Source(kind="found", ref=f"{value['value']} of {value['from']}")
            elif (source := _covering(records, path)) is not None:
                _check_range(composed, path, value, source)
                result[path] = source
            else:
                missing.append(f"  {composed.origin(path)}: {path} = {value}{_changed(composed, path)}")
    if missing:
        raise UserError(
            "parameters without a source (add it to `sources:` beside the value, "
            "{kind: published | data_sheet | derived | estimate | calibrated | fitted, ref: ...}):\n"
            + "\n".join(missing)
        )
    return result


def _changed(composed: Composed, path: str) -> str:
    """Say that a file changes a value which has a source in the file it builds on."""
    files = composed.setters(path)
    return f", changed from that of {shown(files[-2].file)}, whose source is not its own" if len(files) > 1 else ""


def _check_range(composed: Composed, path: str, value: Any, source: Source) -> None:
    if source.range is None:
        return
    if not _is_number(value):
        raise UserError(
            f"{composed.origin(path)}: {path}: value {value}; its source has a range, which one number needs"
        )
    if not source.range[0] <= value <= source.range[1]:
        raise UserError(
            f"{composed.origin(path)}: {path}: value {value} lies outside the range of its own source, {source.range}"
        )


def _flat(sources: Mapping[str, Any], path: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in sources.items():
        here = f"{path}.{key}" if path else str(key)
        if isinstance(value, Mapping) and "kind" not in value:
            found.update(_flat(value, here))
        else:
            found[here] = value
    return found


def _record(composed: Composed, path: str, source: Any) -> Source:
    try:
        return Source.model_validate(source)
    except ValidationError as error:
        raise explain(error, {"source": source}, f"source of {path}", composed.origin(path)) from None


def _check_names_a_value(composed: Composed, values: Mapping[str, Any], path: str) -> None:
    here: Any = values
    keys = path.split(".")
    for depth, key in enumerate(keys):
        if isinstance(here, Mapping) and key in here:
            here = here[key]
            continue
        parent = ".".join(keys[:depth])
        known = list(here) if isinstance(here, Mapping) else []
        raise UserError(
            f"{composed.origin(parent)}: sources of {parent} name {key!r}, which is no key there; "
            f"{best_matches(key, known)}"
        )


def _covering(records: Mapping[str, Source], path: str) -> Source | None:
    keys = path.split(".")
    for depth in range(len(keys), 0, -1):
        source = records.get(".".join(keys[:depth]))
        if source is not None:
            return source
    return None


def _at(values: Mapping[str, Any], path: str) -> Any:
    here: Any = values
    for key in path.split("."):
        here = here.get(key, {}) if isinstance(here, Mapping) else {}
    return here


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def found_values(study: Any) -> dict[str, tuple[str, ...]]:
    """Return step -> names of the values it finds, for the steps the study has."""
    found: dict[str, tuple[str, ...]] = {}
    for one in registry.experiments().values():
        found |= one.finds(study)
    return found


def check_references(study: Any) -> None:
    """Refuse a reference `{from: step, value: name}` to a value that no step of the study finds.

    Raises
    ------
    UserError : with the key path, the value and what is allowed.
    """
    check_found(references(study), found_values(study), study.overrides)


def check_found(
    asked: Iterable[tuple[str, Mapping[str, Any]]], found: Mapping[str, tuple[str, ...]], overrides: Iterable[str]
) -> None:
    """Refuse a reference to a value that no step finds.

    Arguments
    ---------
    asked : key path and reference of each.
    found : step -> names of the values it finds.
    overrides : what is overridden is told first.

    Raises
    ------
    UserError : with the key path, the value and what is allowed.
    """
    # Others may have theirs from one that an override changed: that one is told first.
    own = [word.split("=", 1)[0].lstrip("+") for word in overrides]
    for path, reference in sorted(asked, key=lambda one: not below(one[0], own)):
        step, value = str(reference["from"]), str(reference["value"])
        if path.split(".")[0] == step:
            others = ", ".join(name for name in found if name != step) or "none"
            raise UserError(f"{path}.from: {step!r} would wait for itself; allowed is {others}, or a number")
        if step not in found:
            raise UserError(
                f"{path}.from: no step {step!r} finds values in this study; {best_matches(step, found)}; or give a "
                f"number: {path}=NUMBER"
            )
        if value not in found[step]:
            raise UserError(f"{path}.value: {step} finds no {value!r}; {best_matches(value, found[step])}")


def references(study: Any) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield key path and reference of every parameter that another step finds."""
    for section in study.parameter_sections():
        for path, value in study.parameters(section):
            if isinstance(value, Mapping):
                yield path, value
