"""Response surfaces, fitted once on arrays and asked at many points.

Points are n × k and coded to the original box by the caller, as `infuse.doe.coded` does; values are n. A surface that was
fitted on a data frame takes data frames by the names of its columns.
"""

from __future__ import annotations

from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike

from infuse import _native
from infuse._checks import finite
from infuse._parameters import Designs, Floats, Names, is_frame, matrix, numbers, rows
from infuse.doe import Model, _model
from infuse.pooled import as_json


def _optional(values: Optional[ArrayLike], what: str) -> Optional[List[float]]:
    return None if values is None else numbers(values, what)


class _Fitted:
    """What was fitted on points, and knows the names of their columns if they had any."""

    _columns: Optional[Names] = None

    def _first(self, points: Designs) -> Floats:
        """The points it is fitted on."""
        if is_frame(points):
            frame: Any = points
            self._columns = Names.of([str(column) for column in frame.columns])
        return self._at(points)

    def _at(self, points: Designs) -> Floats:
        """Any points."""
        if self._columns is not None and is_frame(points):
            return rows(self._columns, points, others=False)
        return matrix(points)  # type: ignore[arg-type]


class _Surface(_Fitted):
    """What every surface can do."""

    _surface: Union[_native.Regression, _native.InverseDistance, _native.SquaredExponential]

    def __call__(self, points: Designs) -> Floats:
        """The estimate at each point."""
        return self.predict(points)

    def predict(self, points: Designs) -> Floats:
        """The estimate at each point."""
        return self._surface.predict(self._at(points))

    def gradient(self, points: Designs) -> Floats:
        """Slopes at each point, n × k; NaN where there is none."""
        return self._surface.gradient(self._at(points))

    def minimum(self, points: Designs) -> Optional[Tuple[int, float]]:
        """Which of the points has the smallest estimate, and that."""
        return self._surface.minimum(self._at(points))

    def leave_one_out(self) -> Floats:
        """Value less what the surface through all others says, at each point."""
        return self._surface.leave_one_out()


class Regression(_Surface):
    """Weighted least squares on the terms of a model, (30) and (31).

    >>> line = Regression([[-1.0], [0.0], [1.0], [1.0]], [0.0, 1.0, 4.0, 5.0], model="linear")
    >>> (11 * line.coefficients).round(12)
    array([21., 26.])
    >>> line.predict([[0.5]]).round(6)
    array([3.090909])
    """

    _surface: _native.Regression

    def __init__(
        self, points: Designs, values: ArrayLike, *, model: Model = "quadratic", weights: Optional[ArrayLike] = None
    ) -> None:
        of_each = _optional(weights, "`weights`")
        self._surface = _native.Regression(self._first(points), numbers(values), of_each, _model(model))

    @property
    def terms(self) -> List[str]:
        """Names of the terms."""
        return self._surface.terms()

    @property
    def coefficients(self) -> Floats:
        """One per term."""
        return self._surface.coefficients()

    @property
    def standard_errors(self) -> Optional[Floats]:
        """One per term; none without degrees of freedom."""
        return self._surface.standard_errors()

    @property
    def degrees_of_freedom(self) -> int:
        """Points less terms."""
        return self._surface.degrees_of_freedom()

    @property
    def sigma_squared(self) -> Optional[float]:
        """Residual mean square; none without degrees of freedom."""
        return self._surface.sigma_squared()

    @property
    def r_squared(self) -> Optional[float]:
        """Share of the variation that the model explains."""
        return self._surface.r_squared()

    def variance(self, points: Designs) -> Floats:
        """Variance of the estimated mean at each point; NaN without degrees of freedom."""
        return self._surface.variance(self._at(points))

    def lack_of_fit(self) -> Tuple[float, float]:
        """F of the test against the scatter of repeats, and its probability if the model is right."""
        return self._surface.lack_of_fit()


class InverseDistance(_Surface):
    """The average of the values, each weighted by a power of the inverse distance to its point, (32) and (33).

    >>> surface = InverseDistance([[0.0], [1.0], [1.0]], [2.0, 5.0, 7.0])
    >>> surface([[0.0], [1.0]])
    array([2., 6.])
    """

    _surface: _native.InverseDistance

    def __init__(
        self, points: Designs, values: ArrayLike, *, power: float = 2.0, weights: Optional[ArrayLike] = None
    ) -> None:
        of_each, exponent = _optional(weights, "`weights`"), finite("`power`", power)
        self._surface = _native.InverseDistance(self._first(points), numbers(values), of_each, exponent)


class SquaredExponential(_Surface):
    """The average of the values, each weighted by exp(-(c d)^2), (34). Without a scale c one is chosen by leaving out.

    >>> surface = SquaredExponential([[0.0], [1.0]], [0.0, 1.0], scale=2.0)
    >>> surface([[0.5]])
    array([0.5])
    """

    _surface: _native.SquaredExponential

    def __init__(
        self,
        points: Designs,
        values: ArrayLike,
        *,
        scale: Optional[float] = None,
        weights: Optional[ArrayLike] = None,
    ) -> None:
        of_each, c = _optional(weights, "`weights`"), None if scale is None else finite("`scale`", scale)
        self._surface = _native.SquaredExponential(self._first(points), numbers(values), of_each, c)

    @property
    def scale(self) -> float:
        """c."""
        return self._surface.scale()


class GaussianProcess(_Fitted):
    """Trend, simulation and a Matérn residual, averaged over what the values leave possible; with mean and variance.

    `simulated` is what a simulation says at the points; predictions then need it, too. `noise` is the standard deviation
    of a value, where it is known. Without a simulation only structures without one are averaged.

    >>> points = np.linspace(-1, 1, 9).reshape(-1, 1)
    >>> process = GaussianProcess(points, points[:, 0] ** 2, seed=1)
    >>> mean, variance = process.predict([[0.1]])
    >>> bool(abs(mean[0] - 0.01) < 0.005), bool(variance[0] >= 0)
    (True, True)
    """

    def __init__(
        self,
        points: Designs,
        values: ArrayLike,
        *,
        simulated: Optional[ArrayLike] = None,
        weights: Optional[ArrayLike] = None,
        noise: Optional[float] = None,
        particles: int = 32,
        structures: Optional[Sequence[Tuple[str, str]]] = None,
        seed: int = 1,
    ) -> None:
        pairs = None if structures is None else [_structure(*one) for one in structures]
        settings = as_json({"structures": pairs, "noise": noise, "particles": particles, "seed": seed})
        self._process = _native.GaussianProcess.averaged(
            self._first(points),
            numbers(values),
            _optional(weights, "`weights`"),
            _optional(simulated, "`simulated`"),
            settings,
        )

    @classmethod
    def given(
        cls,
        points: Designs,
        values: ArrayLike,
        *,
        lengths: Sequence[float],
        residual_variance: float,
        noise_variance: float,
        trend_variance: float = 0.0,
        simulation_variance: float = 0.0,
        simulation: str = "ignored",
        residual: str = "smooth",
        simulated: Optional[ArrayLike] = None,
        weights: Optional[ArrayLike] = None,
        center: float = 0.0,
        scale: float = 1.0,
    ) -> "GaussianProcess":
        """One process with these hyperparameters; variances are in units of the squared `scale`, about `center`.

        `residual` is `none`, `smooth` (Matérn-5/2) or `rough` (Matérn-3/2), `simulation` is `ignored`, `subtracted` or
        `scaled`. Besides there is a constant of variance 4.
        """
        hyperparameters: Dict[str, Any] = {
            "trend": trend_variance,
            "simulation": simulation_variance,
            "residual": residual_variance,
            "lengths": lengths,
            "noise": noise_variance,
        }
        self = cls.__new__(cls)
        self._process = _native.GaussianProcess.given(
            self._first(points),
            numbers(values),
            _optional(weights, "`weights`"),
            _optional(simulated, "`simulated`"),
            as_json(_structure(simulation, residual)),
            as_json(hyperparameters),
            (finite("`center`", center), finite("`scale`", scale)),
        )
        return self

    def predict(self, points: Designs, *, simulated: Optional[ArrayLike] = None) -> Tuple[Floats, Floats]:
        """Mean and variance of the response at each point, without the noise of a value."""
        found = self._process.predict(self._at(points), _optional(simulated, "`simulated`"))
        return np.ascontiguousarray(found[:, 0]), np.ascontiguousarray(found[:, 1])

    @property
    def noise(self) -> Optional[float]:
        """Standard deviation of a value, as given or as learnt; none of a process with given hyperparameters."""
        return self._process.noise()

    def leave_one_out(self) -> Floats:
        """Each value less what the others say, in standard deviations of that; one per place."""
        return self._process.leave_one_out()


def _structure(simulation: str, residual: str) -> Dict[str, str]:
    return {"simulation": simulation, "residual": residual}
