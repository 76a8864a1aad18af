"""Numbers that count what is done to them, and when each would be ready; run where nothing is compiled.

`NUMBA_DISABLE_JIT=1 python -m benchmarks.counting CASE LATENCIES` runs the drivers' own functions, uncompiled, on such
numbers and prints what an edge costs: operations, and the longest chain of operations that wait for one another.
"""

from __future__ import annotations

import json
import math
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np

FEW, MANY = 6, 18
KINDS = ("add", "multiply", "divide", "compare", "function")


class Count:
    """Operations so far, by kind, and how long each kind takes."""

    done = dict.fromkeys(KINDS, 0)
    takes = dict.fromkeys(KINDS, 0.0)


class Number(float):
    """A float that knows when it would be ready if operations waited for nothing but their operands."""

    ready: float
    # Numbers of numpy leave an operation with such a one to it.
    __array_ufunc__ = None

    def __new__(cls, value: float, ready: float = 0.0) -> Number:
        """Return a number that is ready at a time."""
        made = super().__new__(cls, value)
        made.ready = ready
        return made


def _ready(*numbers: Any) -> float:
    return max(getattr(number, "ready", 0.0) for number in numbers)


def _operation(name: str, kind: str) -> Any:
    plain = getattr(float, name)

    def operate(self: Number, *others: Any) -> Any:
        found = plain(self, *(float(other) for other in others))
        if found is NotImplemented:
            return found
        Count.done[kind] += 1
        return Number(found, _ready(self, *others) + Count.takes[kind])

    return operate


def _comparison(name: str) -> Any:
    plain = getattr(float, name)

    def compare(self: Number, other: Any) -> Any:
        Count.done["compare"] += 1
        return plain(self, float(other))

    return compare


for _name, _kind in {"add": "add", "sub": "add", "mul": "multiply", "truediv": "divide"}.items():
    for _side in ("", "r"):
        setattr(Number, f"__{_side}{_name}__", _operation(f"__{_side}{_name}__", _kind))
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(Number, f"__{_name}__", _comparison(f"__{_name}__"))
# A sign is a bit: it costs nothing that the clock would tell.
Number.__neg__ = lambda self: Number(-float(self), self.ready)  # type: ignore[method-assign]
Number.__abs__ = lambda self: Number(abs(float(self)), self.ready)  # type: ignore[method-assign]
Number.__hash__ = float.__hash__  # type: ignore[method-assign]


def _function(name: str) -> Any:
    plain = getattr(math, name)

    def call(*numbers: Any) -> Any:
        if not any(isinstance(number, Number) for number in numbers):
            return plain(*numbers)
        Count.done["function"] += 1
        return Number(plain(*(float(number) for number in numbers)), _ready(*numbers) + Count.takes["function"])

    return call


def counted(value: Any) -> Any:
    """Return a record, array, tuple or number with every float in it replaced by one that counts."""
    if isinstance(value, np.void | np.record):
        return SimpleNamespace(**{name: counted(value[name]) for name in value.dtype.names or ()})
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        made = np.empty(value.shape, dtype=object)
        made.ravel()[:] = [Number(one) for one in value.ravel()]
        return made
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return type(value)(*(counted(one) for one in value))
    if isinstance(value, float):
        return Number(value)
    return value.item() if isinstance(value, np.generic) else value


def edge_cost(case: str) -> dict[str, float]:
    """Return operations an edge by kind, and the longest chain through the state an edge [s]."""
    from benchmarks import chemistry
    from benchmarks.peers import engine
    from pipeline.cell.circuit import compile_cell
    from pipeline.charge.books import book_for
    from pipeline.charge.period import new_clock, run_periods
    from pipeline.charge.program import compile_program
    from pipeline.charge.protocol import resolve
    from pipeline.charge.state import DEPTH, TEMPERATURE, new_run

    battery, mode, soc = chemistry.every_case()[case][:3]
    settings, _ = engine.settings_of(soc, "edge", 1e4)
    cell = compile_cell(battery)
    program = compile_program(resolve(mode, battery.capacity_in_use_ah, battery.fills), battery.cells_in_series, "edge")
    state, book, clock = new_run(), book_for(program, settings), new_clock(1e4)
    state["state"][DEPTH], state["state"][TEMPERATURE] = 1.0 - soc, engine.AMBIENT_K
    state["proposal_s"][:] = math.inf
    clock["period_s"] = float(np.sum(program.length_s[0]))
    run, ledger, time = counted(state), counted(book), counted(clock)
    time.phase_end_s, supply_s, supply_w = math.inf, np.zeros(1), np.full(1, math.inf)
    arguments = (counted(cell), counted(program), supply_s, supply_w, run, ledger, time, 0)
    for name in ("exp", "log", "sqrt", "hypot", "asinh"):
        setattr(math, name, _function(name))
    marks = []
    for count in (FEW, MANY):
        run_periods(*arguments, count, Number(engine.AMBIENT_K), 1e-6, 60.0, 1_000_000, 1)
        chain = max(_ready(*run.state), _ready(*ledger.sums), _ready(*ledger.recent_gains))
        marks.append((run.edges, dict(Count.done), chain))
    (before, first, early), (after, second, late) = marks
    edges = after - before
    return {kind: (second[kind] - first[kind]) / edges for kind in KINDS} | {"chain_s": (late - early) / edges}


if __name__ == "__main__":
    Count.takes = json.loads(sys.argv[2])
    print(json.dumps(edge_cost(sys.argv[1])))
