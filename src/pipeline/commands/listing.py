"""`python -m pipeline modes`: the vocabulary of charging modes, from the records that read them."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence

from pydantic import BaseModel

from pipeline.charge.records import COMPENSATION, Mode
from pipeline.charge.waveforms import WAVEFORMS, Limit, Until
from pipeline.config.compose import options

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
    argparse.ArgumentParser(prog="python -m pipeline modes", description=__doc__).parse_args(arguments)
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
