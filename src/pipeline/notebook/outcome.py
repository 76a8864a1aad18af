"""A charge as a notebook shows it: frames, a summary with units, a plot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from pipeline.charge.summary import Quantity

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from pipeline.charge.simulate import Charge, Task

# Column of the trace, its factor and label, and the columns between which it pulses.
_SHOWN = (
    ("Voltage / V", 1.0, "Voltage [V]", ("voltage_min_v", "voltage_max_v")),
    ("Current / A", 1.0, "Current [A]", ("current_min_a", "current_max_a")),
    ("soc", 100.0, "State of charge [%]", None),
    ("Surface Temperature / degC", 1.0, "Temperature [°C]", None),
)


class Summary(Mapping[str, float | str | None]):
    """What came of a charge: name -> number or text; None where the charge did not get there.

    `units` and `meanings` are mappings of the same names.
    """

    def __init__(self, rows: Sequence[Quantity]) -> None:
        self._values = {row.quantity: row.value if row.text is None else row.text for row in rows}
        self.units = {row.quantity: row.unit for row in rows}
        self.meanings = {row.quantity: row.description for row in rows}

    def __getitem__(self, name: str) -> float | str | None:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        width = max(map(len, self), default=0)
        return "\n".join(f"{name:<{width}}  {self.shown(name)}" for name in self)

    def shown(self, name: str) -> str:
        """Return a value with its unit, as a person reads it."""
        value, unit = self._values[name], self.units[name]
        if value is None:
            return "not reached"
        return value if isinstance(value, str) else f"{value:.6g} {unit if unit != '1' else ''}".rstrip()


class NotebookCharge:
    """A charge of one battery in one mode.

    `battery`, `mode` and `settings` are the records that it was made from, `summary` is what came of it.
    """

    def __init__(self, task: Task, made: Charge) -> None:
        self.battery, self.mode, self.settings = task.battery, task.mode, task.settings
        self.summary = Summary(made.summary)
        self._made = made

    @cached_property
    def trace(self) -> pd.DataFrame:
        """Return the course of the charge: means over intervals, a row each, in the columns of a shipped trace."""
        return _frame(self._made.trace)

    @cached_property
    def phases(self) -> pd.DataFrame:
        """Return the phases that were run, a row each."""
        return _frame(self._made.phases)

    @cached_property
    def energy(self) -> pd.DataFrame:
        """Return where the energy went, a row a path; the first law closes over the rows."""
        return _frame(self._made.energy)

    @cached_property
    def waveform(self) -> pd.DataFrame:
        """Return what was kept at full resolution, where `windows` asked for it."""
        return _frame(self._made.waveform)

    def plot(self, axes: Sequence[Axes] | None = None) -> Any:
        """Draw voltage, current, state of charge and temperature over time.

        Arguments
        ---------
        axes : four axes to draw into, as those of another charge; new ones where not given.

        Returns
        -------
        The axes, one under the other, shape (4,).

        >>> import matplotlib; matplotlib.use("Agg")
        >>> import pipeline as cp
        >>> slow, fast = (cp.charge("lfp_8ah", "cc_cv_5c", max_current_c_rate=rate) for rate in (1.0, 2.0))
        >>> [str(one.get_ylabel()) for one in fast.plot(slow.plot())]
        ['Voltage [V]', 'Current [A]', 'State of charge [%]', 'Temperature [°C]']
        """
        import matplotlib.pyplot as plt

        trace = self._made.trace
        if axes is None:
            _, axes = plt.subplots(len(_SHOWN), 1, sharex=True, layout="constrained", figsize=(7.0, 8.0))
        hours = trace["Test Time / s"] / 3600.0
        label = f"{self.battery.title}, {self.mode.title}"
        for one, (column, factor, words, band) in zip(axes, _SHOWN, strict=True):
            (line,) = one.plot(hours, factor * trace[column], label=label)
            if band is not None:
                low, high = (trace[name] for name in band)
                if np.any(high > low):
                    one.fill_between(hours, low, high, color=line.get_color(), alpha=0.2, linewidth=0)
            one.set_ylabel(words)
        axes[-1].set_xlabel("Time [h]")
        axes[0].legend(loc="best")
        return axes

    def __repr__(self) -> str:
        return f"{self.battery.title}, {self.mode.title}\n{self.summary!r}"


def _frame(columns: Mapping[str, Any]) -> pd.DataFrame:
    import pandas as pd

    return pd.DataFrame(dict(columns))
