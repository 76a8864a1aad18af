"""The network as an estimator with scikit-learn's conventions, for notebooks; needs no scikit-learn itself."""

from __future__ import annotations

import inspect
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.errors import best_matches
from pipeline.grnn.network import make_network, responses
from pipeline.grnn.records import Kernel

Array = NDArray[np.float64]


class GeneralizedRegression:
    """Generalised regression neural network (Specht 1991): every row of the data that is chosen becomes a centre.

    Arguments
    ---------
    kernel : gaussian, wendland or extendable.
    widths : width of the kernel along each scaled input, a number or one per input [1].
    scales : what the inputs are divided by: `largest` for the largest magnitude of each, or numbers.
    extension : support's radius over the nearest centre's distance, above 1; for the extendable kernel.
    rows : rows of the data that become centres; None for all of them.

    Attributes
    ----------
    network_ : the fitted network.
    n_features_in_ : number of inputs.
    """

    def __init__(
        self,
        kernel: Kernel = "gaussian",
        widths: ArrayLike = 0.1,
        scales: ArrayLike | str = "largest",
        extension: float = 2.0,
        rows: ArrayLike | None = None,
    ) -> None:
        self.kernel = kernel
        self.widths = widths
        self.scales = scales
        self.extension = extension
        self.rows = rows

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Take inputs, shape (m, d), and outputs, shape (m,), as centres; return the estimator.

        Raises
        ------
        ValueError : shapes that do not fit, a value that is not finite, or a row that is not there.
        """
        if y is None:
            raise ValueError("requires y to be passed, but the target y is None")
        points = _inputs(X)
        values = _real(y, "y")
        if values.ndim == 2 and values.shape[1] == 1:
            _warn_of_column()
            values = values[:, 0]
        if values.shape != points.shape[:1]:
            raise ValueError(f"y has shape {values.shape}, X {points.shape}; allowed is one output a row")
        chosen = np.arange(len(points)) if self.rows is None else np.asarray(self.rows)
        if chosen.ndim != 1 or not np.issubdtype(chosen.dtype, np.integer) or not len(chosen):
            raise ValueError(f"rows is {self.rows!r}; allowed are whole numbers, one or more, or None")
        if np.min(chosen) < 0 or np.max(chosen) >= len(points):
            raise ValueError(f"rows go from {np.min(chosen)} to {np.max(chosen)}; allowed are 0 to {len(points) - 1}")
        self.n_features_in_ = points.shape[1]
        self.network_ = make_network(
            points[chosen],
            values[chosen],
            widths=self.widths,
            scales=self._scales(points),
            kernel=self.kernel,
            extension=self.extension,
            low=np.min(points, axis=0),
            high=np.max(points, axis=0),
        )
        return self

    def predict(self, X: ArrayLike) -> Array:
        """Return the outputs at inputs, shape (m, d), as (m,)."""
        if not hasattr(self, "network_"):
            raise self._not_fitted()
        points = _inputs(X)
        if points.shape[1] != self.n_features_in_:
            raise ValueError(
                f"X has {points.shape[1]} features, but {type(self).__name__} is expecting "
                f"{self.n_features_in_} features as input"
            )
        return responses(self.network_, points)

    def score(self, X: ArrayLike, y: ArrayLike) -> float:
        """Return the coefficient of determination; where all outputs are one value, 1 if all are met, else 0."""
        wanted = np.asarray(y, dtype=float).reshape(-1)
        rest = float(np.sum((wanted - self.predict(X)) ** 2))
        spread = float(np.sum((wanted - np.mean(wanted)) ** 2))
        return 1.0 - rest / spread if spread > 0.0 else float(rest == 0.0)

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """Return the arguments by name."""
        return {name: getattr(self, name) for name in _arguments(type(self))}

    def set_params(self, **params: Any) -> Self:
        """Change arguments by name; return the estimator."""
        known = _arguments(type(self))
        for name, value in params.items():
            if name not in known:
                raise ValueError(f"no parameter {name!r}; {best_matches(name, known)}")
            setattr(self, name, value)
        return self

    def __repr__(self) -> str:
        """Return the call that makes the estimator."""
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.get_params().items())})"

    def __sklearn_is_fitted__(self) -> bool:
        """Tell scikit-learn whether `fit` has been called."""
        return hasattr(self, "network_")

    def __sklearn_tags__(self) -> Any:
        """Describe the estimator to scikit-learn, which alone calls this."""
        from sklearn.utils import RegressorTags, Tags, TargetTags

        return Tags(
            estimator_type="regressor",
            target_tags=TargetTags(required=True),
            regressor_tags=RegressorTags(poor_score=True),
        )

    def _scales(self, points: Array) -> Array:
        if isinstance(self.scales, str):
            if self.scales != "largest":
                raise ValueError(f"scales is {self.scales!r}; allowed are 'largest', or numbers")
            largest = np.max(np.abs(points), axis=0)
            return np.where(largest > 0.0, largest, 1.0)
        return np.asarray(self.scales, dtype=float)

    def _not_fitted(self) -> Exception:
        """Return scikit-learn's own error where it is installed, as its tools expect."""
        words = f"this {type(self).__name__} is not fitted yet; call fit first"
        try:
            from sklearn.exceptions import NotFittedError
        except ImportError:
            return ValueError(words)
        error: Exception = NotFittedError(words)
        return error


def _arguments(kind: type) -> list[str]:
    return list(inspect.signature(kind).parameters)


def _inputs(values: ArrayLike) -> Array:
    if hasattr(values, "tocsr"):
        raise TypeError("sparse data are not supported; give a dense array of shape (m, d)")
    points = _real(values, "X")
    if points.ndim != 2:
        raise ValueError(f"X has shape {points.shape}; Reshape your data to (m, d)")
    if not points.shape[0]:
        raise ValueError(f"Found array with 0 sample(s) (shape={points.shape}) while a minimum of 1 is required.")
    if not points.shape[1]:
        raise ValueError(f"0 feature(s) (shape={points.shape}) while a minimum of 1 is required.")
    return points


def _real(values: ArrayLike, name: str) -> Array:
    given = np.asarray(values)
    if np.iscomplexobj(given):
        raise ValueError("Complex data not supported")
    found = np.ascontiguousarray(given, dtype=float)
    if not np.all(np.isfinite(found)):
        raise ValueError(f"{name} holds NaN or infinity; each value must be finite")
    return found


def _warn_of_column() -> None:
    import warnings

    try:
        from sklearn.exceptions import DataConversionWarning
    except ImportError:
        return
    warnings.warn("A column-vector y was passed when a 1d array was expected", DataConversionWarning, stacklevel=3)
