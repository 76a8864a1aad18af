"""The fit of a model to measurements: residuals of a population at once, least squares with bounds, a robust loss."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pipeline.experiments.own_battery.replay import Replay, replays
from pipeline.experiments.own_battery.segments import Thinned
from pipeline.experiments.own_battery.unknowns import Model, Population

Array = NDArray[np.float64]
_LOST = 1e3
"""Residual that stands where a vector has no solution."""
_NUDGE = 1e-4
_WARM_EVERY = 4
_SPREAD = 1.4826
"""Standard deviation over the median of the magnitudes of normal residuals."""
_HARMONICS, _LEAST_NOISE, _MOST_NOISE = 3, 0.2, 1.0
"""Harmonics of the error of rounding, and the noise, in steps, between which its mean is taken off."""
LEAST_V, LEAST_K, LEAST_SHARE = 2e-4, 0.02, 2e-4
"""Spread below which no residual is taken to be: of the voltage of a cell [V], of the temperature [K], of the current,
a share of its largest."""


class Part(NamedTuple):
    """A record with the rows that the fit may see.

    Arguments
    ---------
    thinned : the record.
    seen : whether the fit may see a row, shape (m,).
    fold : number of the part that a row is left out with; -1: with none.
    """

    thinned: Thinned
    seen: NDArray[np.bool_]
    fold: NDArray[np.int64]


class Spread(NamedTuple):
    """Standard deviation of the residuals: of the battery's voltage [V], of its temperature [K], of its current [A].

    The current is compared where a held voltage drives the replay.
    """

    voltage_v: float
    temperature_k: float
    current_a: float = 1.0


class Result(NamedTuple):
    """Where a fit ended.

    Arguments
    ---------
    model, vector : the model, and the best vector, (d,).
    cost : half the sum of the squared residuals as the loss counts them.
    evaluations : replays of the whole measurement, all vectors counted.
    converged : whether the tolerance was met.
    """

    model: Model
    vector: Array
    cost: float
    evaluations: int
    converged: bool


class Problem:
    """A model held against records: residuals and their slopes, in units of the spread.

    Arguments
    ---------
    parts : the records.
    spread : of the residuals.
    leave : the fold that is left out; -1: none.
    ridge : whether each number is drawn to its start, by the width of its prior.
    """

    def __init__(
        self, model: Model, parts: Sequence[Part], spread: Spread, leave: int = -1, ridge: bool = False
    ) -> None:
        self.model, self.parts, self.spread, self.ridge = model, parts, spread, ridge
        self._population = Population(model)
        self._start, self._priors = model.start(), model.widths()
        self._steps = _NUDGE * self._priors
        self._neighbours = model.neighbours()
        self.evaluations = 0
        rows = [part.seen & ((part.fold != leave) | (leave < 0)) for part in parts]
        held = [~np.isnan(part.thinned.drive.held_v) for part in parts]
        self._volts = [seen & ~driven for seen, driven in zip(rows, held, strict=True)]
        self._amperes = [seen & driven for seen, driven in zip(rows, held, strict=True)]
        self._warm = [
            _some(seen & ~np.isnan(part.thinned.temperature_k)) for seen, part in zip(rows, parts, strict=True)
        ]

    def replayed(self, vectors: Array) -> list[Replay]:
        """Return the replay of every record, for a population of vectors (n, d)."""
        cells, soc = self._population.cells(vectors)
        self.evaluations += len(vectors)
        found = []
        for place, part in enumerate(self.parts):
            start_k = np.full(len(vectors), part.thinned.start_k)
            found.append(replays(cells, soc[:, place], start_k, part.thinned.drive))
        return found

    def residuals(self, vectors: Array) -> Array:
        """Return the residuals of a population, shape (n, rows).

        Voltages, temperatures, currents at a held voltage, then what is known before.
        """
        made = self.replayed(vectors)
        rows = []
        for one, part, seen in zip(made, self.parts, self._volts, strict=True):
            rows.append((one.voltage_v[:, seen] - part.thinned.voltage_v[seen]) / self.spread.voltage_v)
        for one, part, seen in zip(made, self.parts, self._warm, strict=True):
            rows.append((one.temperature_k[:, seen] - part.thinned.temperature_k[seen]) / self.spread.temperature_k)
        for one, part, seen in zip(made, self.parts, self._amperes, strict=True):
            rows.append((one.current_a[:, seen] - part.thinned.drive.read_a[seen]) / self.spread.current_a)
        away = vectors - self._start
        if len(self._neighbours.first):
            first, second, width = self._neighbours
            rows.append(2.0 * (away[:, second] - np.where(first < 0, 0.0, away[:, first])) / width)
        if self.ridge:
            rows.append(2.0 * away / self._priors)
        found = np.concatenate(rows, axis=1)
        return np.where(np.isfinite(found), np.clip(found, -_LOST, _LOST), _LOST)

    def shared(self, vector: Array) -> list[tuple[NDArray[np.int64], float]]:
        """Return the residuals of voltage that share the error of a step of the logger: their places, and its size."""
        found, begin = [], 0
        for one, part, seen in zip(self.replayed(vector[None]), self.parts, self._volts, strict=True):
            count, step = int(seen.sum()), part.thinned.step_v
            if step > 0.0 and count and part.thinned.shared_v > 0.0:
                cell = np.round(one.voltage_v[0, seen] / step)
                runs = np.split(np.arange(count), np.flatnonzero(np.diff(cell)) + 1)
                found += [(begin + run, part.thinned.shared_v / self.spread.voltage_v) for run in runs]
            begin += count
        return found

    @property
    def voltages(self) -> int:
        """Return how many of the residuals are voltages."""
        return int(sum(seen.sum() for seen in self._volts))

    @property
    def temperatures(self) -> int:
        """Return how many of the residuals are temperatures."""
        return int(sum(seen.sum() for seen in self._warm))

    @property
    def currents(self) -> int:
        """Return how many of the residuals are currents."""
        return int(sum(seen.sum() for seen in self._amperes))

    def function(self, vector: Array) -> Array:
        """Return the residuals of one vector."""
        return np.asarray(self.residuals(vector[None])[0])

    def slopes(self, vector: Array) -> Array:
        """Return the derivatives of the residuals, shape (rows, d), by differences of one population."""
        _, high = self.model.bounds()
        steps = np.where(vector + self._steps > high, -self._steps, self._steps)
        found = self.residuals(np.vstack([vector[None], vector + np.diag(steps)]))
        return np.asarray(((found[1:] - found[0]) / steps[:, None]).T)


def mean_of_rounding(volts: Array, step_v: float, noise_v: float, grid_v: float) -> Array:
    """Return the error of readings of voltages with noise that are rounded to steps, on average [V].

    Rounding to steps of q leaves an error that is a wave over the voltage, which noise of a standard deviation s
    smooths: the k-th harmonic has the amplitude q / (pi k) exp(-2 (pi k s / q)^2). At a held voltage it is the same
    in every row, and no mean over rows makes it less.

    Arguments
    ---------
    volts : before they are read, any shape [V].
    step_v, noise_v : step, and standard deviation of the noise [V].
    grid_v : a reading, from which the steps count [V].

    Source: B. Widrow and I. Kollar, Quantization Noise, Cambridge University Press (2008), chapter 4.
    """
    angle = 2.0 * math.pi * (volts - grid_v) / step_v
    found = np.zeros_like(volts)
    for k in range(1, _HARMONICS + 1):
        size = step_v / (math.pi * k) * math.exp(-2.0 * (math.pi * k * noise_v / step_v) ** 2)
        found += (-size if k % 2 else size) * np.sin(k * angle)
    return np.asarray(found)


def unrounded(problem: Problem, vector: Array) -> list[Part]:
    """Return the records with voltages less the mean error of their rounding, by a fit near the answer.

    The noise before rounding is that which makes the readings likeliest: each is the step that the voltage with its
    noise falls into. Noise too small to tell the steps by their mean leaves the rows of a step with one error, which
    is counted as such; where it is large, steps do not matter.
    """
    from scipy.optimize import minimize_scalar
    from scipy.special import ndtr

    found = []
    for one, part in zip(problem.replayed(vector[None]), problem.parts, strict=True):
        step, volts = part.thinned.step_v, one.voltage_v[0]
        if step > 0.0 and part.seen.any():
            missed = (part.thinned.voltage_v - volts)[part.seen & np.isnan(part.thinned.drive.held_v)] / step

            def unlikely(log_noise: float, missed: Array = missed) -> float:
                noise = math.exp(log_noise)
                share = ndtr((missed + 0.5) / noise) - ndtr((missed - 0.5) / noise)
                return float(-np.sum(np.log(np.maximum(share, 1e-6))))

            noise = math.exp(minimize_scalar(unlikely, bounds=(math.log(0.05), math.log(3.0)), method="bounded").x)
            if _LEAST_NOISE <= noise <= _MOST_NOISE:
                read = part.thinned.voltage_v
                wave = mean_of_rounding(volts, step, noise * step, float(read[0]))
                part = part._replace(thinned=part.thinned._replace(voltage_v=read - wave, shared_v=0.0))
        found.append(part)
    return found


def _some(rows: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return every fourth of some rows: temperatures change slowly."""
    found = np.zeros_like(rows)
    found[np.flatnonzero(rows)[::_WARM_EVERY]] = True
    return found


def solve(
    problem: Problem, start: Array | None = None, robust: float = 3.0, most: int = 60, tolerance: float = 1e-6
) -> Result:
    """Fit by `scipy.optimize.least_squares` (trust region, bounds, soft_l1 loss).

    Arguments
    ---------
    start : vector to start from; that of the model where not given.
    robust : residual from which it counts less, in units of the spread.
    most : evaluations of the residuals at most, slopes not counted.
    tolerance : relative change of the loss and of the vector below which it ends.
    """
    from scipy.optimize import least_squares

    low, high = problem.model.bounds()
    begin = problem.model.start() if start is None else start
    if not len(begin):
        cost = 0.5 * float(np.sum(problem.residuals(begin[None])[0] ** 2))
        return Result(problem.model, begin, cost, problem.evaluations, True)
    begin = np.clip(begin, low + 1e-9 * (high - low), high - 1e-9 * (high - low))
    widths = problem.model.widths()

    def vector(steps: Array) -> Array:
        return np.clip(begin + steps * widths, low, high)

    def missed(steps: Array) -> Array:
        return problem.function(vector(steps))

    def slopes(steps: Array) -> Array:
        return np.asarray(problem.slopes(vector(steps)) * widths)

    # From nothing in units of the priors: the trust region begins with the length of one of these, not with the size
    # of the numbers, and a first step cannot leave for another valley.
    found = least_squares(
        missed, np.zeros(len(begin)), slopes, ((low - begin) / widths, (high - begin) / widths), "trf",
        ftol=tolerance, xtol=tolerance, gtol=1e-9, loss="soft_l1", f_scale=robust, max_nfev=most,
    )  # fmt: skip
    return Result(problem.model, vector(found.x), float(found.cost), problem.evaluations, found.status > 0)


def spread_of(problem: Problem, vector: Array) -> Spread:
    """Return the spread of the residuals at a vector, robustly, not below what no sensor does better."""
    found = problem.function(vector)
    ends = np.cumsum([problem.voltages, problem.temperatures, problem.currents])
    sizes = [
        _SPREAD * float(np.median(np.abs(one))) if len(one) else math.nan
        for one in np.split(found[: ends[-1]], ends[:-1])
    ]
    volts, warm, amperes = (size * unit for size, unit in zip(sizes, problem.spread, strict=True))
    least_v = LEAST_V * problem.model.battery.cells
    least_a = LEAST_SHARE * max(float(np.max(np.abs(part.thinned.drive.read_a))) for part in problem.parts)
    return Spread(
        least_v if math.isnan(volts) else max(volts, least_v),
        1.0 if math.isnan(warm) else max(warm, LEAST_K),
        1.0 if math.isnan(amperes) else max(amperes, least_a),
    )


def rmse_v(problem: Problem, vector: Array, rows: Sequence[NDArray[np.bool_]]) -> float:
    """Return the root of the mean squared residual of the voltage over some rows of each record [V]."""
    squares, count = 0.0, 0
    for one, part, chosen in zip(problem.replayed(vector[None]), problem.parts, rows, strict=True):
        own = chosen & np.isnan(part.thinned.drive.held_v)
        missed = one.voltage_v[0, own] - part.thinned.voltage_v[own]
        squares, count = squares + float(np.sum(missed**2)), count + int(own.sum())
    return math.sqrt(squares / count) if count else math.nan


def many_starts(
    problem: Problem, first: Array, starts: int, rng: np.random.Generator, robust: float, most: int
) -> list[Result]:
    """Fit from several starts, the first as given, the others away from it by up to the width of each prior.

    Time constants are drawn anew over their whole range, and put in order, so that pairs keep their roles.
    """
    model = problem.model
    low, high = model.bounds()
    found = [solve(problem, first, robust, most)]
    taus = [place for place, path in enumerate(model.paths) if path.startswith("pairs.") and path.endswith("_s")]
    volts = np.array([path.startswith("open_circuit") for path in model.paths], dtype=bool)
    for _ in range(starts - 1):
        away = np.where(volts, 0.1, 0.7) * model.widths() * rng.uniform(-1.0, 1.0, len(first))
        begin = found[0].vector + away
        if taus:
            begin[taus] = np.sort(
                rng.uniform(low[taus] + 0.15 * (high - low)[taus], high[taus] - 0.1 * (high - low)[taus])
            )
        found.append(solve(problem, np.clip(begin, low, high), robust, most))
    return sorted(found, key=lambda one: one.cost)
