"""What there is to choose from: `python -m pipeline modes`, `batteries`, `panels`."""

from __future__ import annotations

import argparse
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel, ValidationError

from pipeline.cell.records import Battery, resting_voltage_v
from pipeline.charge.records import COMPENSATION, Mode
from pipeline.charge.waveforms import WAVEFORMS, Limit, Until
from pipeline.commands import Parser, typed
from pipeline.commands.terminal import table_lines
from pipeline.config.compose import Composed, choose, options
from pipeline.config.inheritance import CONF, stamp
from pipeline.config.messages import explain
from pipeline.config.sources import Source, split
from pipeline.errors import UserError, best_matches
from pipeline.panel import database
from pipeline.panel.database import Listed
from pipeline.panel.records import Panel
from pipeline.report import text

_R = TypeVar("_R", bound=BaseModel)
HEAD = """\
A mode is a YAML file in conf/modes: `title`, knobs, `phases`, `stop`, `sources`.
  phases:  name -> {waveform: {parameters}, limit: {...}, until: {...}}, in the order in which they run
  stop:    what ends the whole charge; the same words as `until`
A parameter that is not given is taken from the knob of its name; text names another knob; a number stands for itself;
{from: STEP, value: NAME} is a value that a step finds. Knobs that go with any battery: one that ends in _c_rate is a
current over the capacity in use, one that ends in _v_cell or _w_cell a voltage or power per cell in series;
max_current_c_rate stands for max_current_a, voltage_v_cell for voltage_v, power_w_cell for power_w.
"""


def modes(arguments: Sequence[str]) -> int:
    """Print waveforms, limits and ends with their parameters; return 0."""
    _parser("modes", "The vocabulary of charging modes, from the records that read them.").parse_args(arguments)
    print(HEAD)
    print("waveforms")
    for name, record in WAVEFORMS.items():
        print("\n".join(lines(name, record)))
    print("\n".join(["", *lines("limit", Limit), *lines("until, stop", Until)]))
    print("\n  beside the phases, at the top of the sheet:")
    for key in COMPENSATION:
        print(f"    {key:<38}{Mode.model_fields[key].description}")
    print(f"\nmodes in conf/modes: {', '.join(options('modes'))}")
    return 0


def lines(name: str, record: type[BaseModel]) -> Iterator[str]:
    """Yield a record: its name with what it is, then each parameter with unit, meaning and default."""
    yield f"  {name}: {(record.__doc__ or '').splitlines()[0]}"
    optional: Mapping[str, float] = getattr(record, "optional", {})
    for key, field in record.model_fields.items():
        default = f" (default {optional[key]:g})" if key in optional else ""
        yield f"    {key:<28}{field.description or ''}{default}"


_HALF = 0.5


def batteries(arguments: Sequence[str]) -> int:
    """Print every battery of conf/battery with its numbers and where they come from; return 0."""
    parser = _parser(
        "batteries",
        "Batteries of conf/battery, each chosen with battery=NAME. Chemistry: as its title says. Voltage: at rest, "
        "half full, 25 °C. Values: how many come from where. Valid: what the measurement covers that it was fitted "
        "to.",
    )
    parser.add_argument("words", nargs="*", help="words of the name or title, all of them, capitals or not")
    words = _no_overrides(parser.parse_args(arguments).words)
    head = (
        "name",
        "chemistry",
        "voltage [V]",
        "capacity [Ah]",
        "cells",
        "usual [C-rate]",
        "usual [A]",
        "values",
        "valid",
    )
    rows, refused = [], []
    for name in options("battery"):
        try:
            one, sources = _battery(name)
        except UserError as error:
            refused.append(f"{name}: {error}")
            continue
        if all(word in f"{name} {one.title}".lower() for word in words):
            rows.append(_battery_row(name, one, sources))
    if words and not rows:
        print(f"no battery has all of these words; {best_matches(' '.join(words), options('battery'))}")
    else:
        print("\n".join(table_lines([head, *rows])))
    # Its title is not known: it may be the one that was looked for.
    for line in refused:
        print(line)
    return 0


def _battery(name: str) -> tuple[Battery, dict[str, Source]]:
    """Return a battery and the sources of its values."""
    composed, values, sources = _card("battery", name)
    return _record(Battery, "battery", values, composed), sources


def _card(group: str, name: str) -> tuple[Composed, dict[str, Any], dict[str, Source]]:
    """Return a file of a group as a run has it, its values and their sources, without what a run composes beside it."""
    words = ("~study", f"+{group}={name}")
    found = choose(words, CONF, stamp(CONF))
    composed = Composed(found.with_values(()), words, found.layers)
    values, written = split(composed.tree)
    sources = {path: Source.model_validate(one) for path, one in written.items() if path.startswith(f"{group}.")}
    return composed, values[group], sources


def _record(record: type[_R], group: str, values: Any, composed: Composed) -> _R:
    try:
        return record.model_validate(values)
    except ValidationError as error:
        raise explain(error, values, group, composed.origin, record) from None


def _battery_row(name: str, one: Battery, sources: Mapping[str, Source]) -> tuple[str, ...]:
    usual = one.usual_c_rate
    kinds = Counter(source.kind for source in sources.values())
    valid = next((source for source in sources.values() if source.valid), None)
    return (
        name,
        re.split(r"\s+(?=\d)", one.title)[0],
        text.number(resting_voltage_v(one, _HALF, 25.0)),
        text.number(one.capacity_in_use_ah),
        text.number(one.cells),
        "" if usual is None else f"{usual[0]:g} to {usual[1]:g}",
        "" if usual is None else " to ".join(text.number(rate * one.capacity_in_use_ah) for rate in usual),
        ", ".join(f"{count} {_KINDS.get(kind, kind)}" for kind, count in kinds.most_common()),
        "" if valid is None else f"{_valid(valid)} ({valid.file})",
    )


_KINDS = {"data_sheet": "data sheet", "estimate": "estimated"}


def _valid(source: Source) -> str:
    names = {"soc": "SOC {:g} to {:g}", "c_rate": "{:g}C to {:g}C", "temperature_c": "{:g} to {:g} °C"}
    return ", ".join(names[name].format(*span) for name, span in (source.valid or {}).items())


class Range(NamedTuple):
    """Numbers from `low` to `high`, both among them."""

    low: float
    high: float

    def holds(self, value: float) -> bool:
        """Tell whether a number lies in it, as far as its digits go."""
        return self.low - 1e-9 * abs(self.low) <= value <= self.high + 1e-9 * abs(self.high)


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_RANGE = re.compile(rf"(?:({_NUMBER})|({_NUMBER})?\.\.({_NUMBER})?)")


def between(words: str) -> Range:
    """Return the numbers that `90..110`, `90..`, `..110` or `36` stand for.

    Raises
    ------
    argparse.ArgumentTypeError : anything else, or a range that falls.
    """
    found = _RANGE.fullmatch(words.strip())
    if found is None or words.strip() == "..":
        raise argparse.ArgumentTypeError(f"{words!r}; allowed is a number as 36, or a range as 90..110, 90.. or ..110")
    one, low, high = found.groups()
    if one is not None:
        return Range(float(one), float(one))
    made = Range(float(low) if low else -math.inf, float(high) if high else math.inf)
    if made.low > made.high:
        raise argparse.ArgumentTypeError(f"{words!r}; the range falls: allowed is {high}..{low}")
    return made


PANEL_NUMBERS = {
    "power": ("max_power_w", "maximum power", "W"),
    "voltage": ("max_power_voltage_v", "voltage at maximum power", "V"),
    "current": ("max_power_current_a", "current at maximum power", "A"),
    "open-circuit": ("open_circuit_voltage_v", "open-circuit voltage", "V"),
    "short-circuit": ("short_circuit_current_a", "short-circuit current", "A"),
    "cells": ("cells_in_series", "cells in series", ""),
}
"""Option of `panels` -> field, what it is, unit."""
_MOST_PANELS = 30


def panels(arguments: Sequence[str]) -> int:
    """Print the panels that have some numbers and words; return 0."""
    parser = _parser(
        "panels",
        "Panels of conf/panel and of the CEC and Sandia databases, at 1000 W/m² and 25 °C; each is chosen with "
        "panel=NAME or panel.name=NAME (panel.database=sandia beside it). A range: 90..110, 90.., ..110, 36.",
    )
    parser.add_argument("words", nargs="*", help="words of the name, all of them, capitals or not")
    for option, (_, meaning, unit) in PANEL_NUMBERS.items():
        told = f"{meaning} [{unit}]" if unit else meaning
        parser.add_argument(f"--{option}", type=between, metavar="RANGE", help=told)
    parser.add_argument("--technology", metavar="WORD", help="Mono-c-Si, Multi-c-Si, CdTe, CIGS, ... or a part of it")
    parser.add_argument("--all", action="store_true", help=f"print all of them, not the first {_MOST_PANELS}")
    given = vars(parser.parse_intermixed_args(arguments))
    words = _no_overrides(given["words"])
    wanted = {field: given[option.replace("-", "_")] for option, (field, _, _) in PANEL_NUMBERS.items()}
    own, refused = _own_panels()
    fitting = _fitting(own, wanted, words, given["technology"])
    found = sorted(fitting, key=lambda one: (one.max_power_w, one.name))
    if not found:
        print("\n".join([f"no panel has all of that{_nearest(words)}", *refused]))
        return 0
    shown = found if given["all"] else found[:_MOST_PANELS]
    units = ["name", *(f"{_SHORT[field]} [{unit}]" if unit else _SHORT[field] for field, _, unit in _NUMBERS)]
    rows = [(one.name, *map(text.number, one[2:-1]), one.technology, one.database) for one in shown]
    for line in table_lines([(*units, "technology", "from"), *rows]):
        print(line)
    left = f", the first {len(shown)} are shown; --all shows all" if len(shown) < len(found) else ""
    print("\n".join([f"{len(found)} panel{'s' * (len(found) != 1)}{left}", *refused]))
    return 0


_NUMBERS = tuple(PANEL_NUMBERS.values())
_SHORT = dict(zip((field for field, _, _ in _NUMBERS), ("Pmp", "Vmp", "Imp", "Voc", "Isc", "cells"), strict=True))


def _fitting(
    own: Sequence[Listed], wanted: Mapping[str, Range | None], words: Sequence[str], technology: str | None
) -> Iterator[Listed]:
    parts = [part for word in words for part in re.findall(r"[a-z0-9]+", word.lower())]
    for one in (*own, *database.listed("cec", parts), *database.listed("sandia", parts)):
        name = one.name.lower()
        numbers = (limits is None or limits.holds(getattr(one, field)) for field, limits in wanted.items())
        of_kind = technology is None or technology.lower() in one.technology.lower()
        if all(part in name for part in parts) and of_kind and all(numbers):
            yield one


def _nearest(words: Sequence[str]) -> str:
    near = database.by_words(" ".join(words), database.names("cec")) if words else []
    return f"; names most like these words: {', '.join(near[:5])}" if near else ""


def _own_panels() -> tuple[list[Listed], list[str]]:
    """Return the panels that are described in conf/panel, and what is wrong with files that describe none.

    An entry of a database, which has its `name` there, is listed with that.
    """
    found, refused = [], []
    for name in options("panel"):
        try:
            composed, values, _ = _card("panel", name)
            if "name" not in values:
                sheet, _ = database.completed(values)
                one = _record(Panel, "panel", sheet, composed)
                found.append(Listed.of(name, "conf/panel", one.model_dump(), str(values.get("technology") or "")))
        except UserError as error:
            refused.append(f"{name}: {error}")
    return found, refused


def _no_overrides(words: Sequence[str]) -> list[str]:
    """Return words in small letters; a configuration is nothing to look for."""
    for word in words:
        if "=" in word or word[:1] in "+~":
            raise UserError(f"override {word}: words of a name are looked for here; numbers have options, see --help")
    return [word.lower() for word in words]


def _parser(word: str, says: str) -> Parser:
    return Parser(prog=typed(word), description=says)
