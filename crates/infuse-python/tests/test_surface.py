"""Surfaces, against scipy, scikit-learn and closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg, stats
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import ConstantKernel, Matern

from conftest import Refused
from infuse import Error, doe, surface

RNG = np.random.default_rng(11)
POINTS = RNG.uniform(-1, 1, (20, 2))
VALUES = 1 + POINTS[:, 0] - POINTS[:, 1] ** 2 + 0.1 * RNG.normal(size=20)
WEIGHTS = RNG.uniform(0.5, 2, 20)
AT = RNG.uniform(-1, 1, (50, 2))


def test_a_regression_is_least_squares() -> None:
    fit = surface.Regression(POINTS, VALUES, weights=WEIGHTS)
    r, root = doe.regressor(POINTS), np.sqrt(WEIGHTS)
    expected, residual, _, _ = linalg.lstsq(r * root[:, None], VALUES * root)
    np.testing.assert_allclose(fit.coefficients, expected, rtol=1e-11)
    np.testing.assert_allclose(fit(AT), doe.regressor(AT) @ expected, rtol=1e-11)
    assert fit.sigma_squared == pytest.approx(residual / 14, rel=1e-11)
    covariance = residual / 14 * np.linalg.inv((r * WEIGHTS[:, None]).T @ r)
    assert fit.standard_errors is not None
    np.testing.assert_allclose(fit.standard_errors, np.sqrt(np.diag(covariance)), rtol=1e-9)
    rows = doe.regressor(AT)
    np.testing.assert_allclose(fit.variance(AT), np.einsum("ij,jk,ik->i", rows, covariance, rows), rtol=1e-9)


def test_leaving_out_is_fitting_again() -> None:
    left_out = surface.Regression(POINTS, VALUES).leave_one_out()
    for i in range(3):
        others = np.arange(20) != i
        again = surface.Regression(POINTS[others], VALUES[others])
        assert left_out[i] == pytest.approx(VALUES[i] - again(POINTS[i])[0], rel=1e-9)


def test_the_slope_of_line_is_scipys() -> None:
    fit = surface.Regression(POINTS[:, :1], VALUES, model="linear")
    expected = stats.linregress(POINTS[:, 0], VALUES)
    assert fit.coefficients[1] == pytest.approx(expected.slope, rel=1e-12)
    assert fit.standard_errors is not None and fit.standard_errors[1] == pytest.approx(expected.stderr, rel=1e-10)
    assert fit.r_squared == pytest.approx(expected.rvalue**2, rel=1e-10)
    np.testing.assert_allclose(fit.gradient([[0.3]]), [[expected.slope]], rtol=1e-12)


def test_lack_of_fit_is_an_f_test() -> None:
    points, values = np.repeat([-1.0, 0.0, 1.0, 0.5], 2).reshape(-1, 1), np.array([1, 1.2, 0, 0.1, 1.1, 0.9, 0.3, 0.2])
    f, p = surface.Regression(points, values, model="linear").lack_of_fit()
    assert p == pytest.approx(stats.f.sf(f, 2, 4), rel=1e-9)


def test_averages_are_their_formulas() -> None:
    distances = np.linalg.norm(AT[:, None] - POINTS[None], axis=2)
    for weights, found in [
        (distances**-2.0, surface.InverseDistance(POINTS, VALUES)(AT)),
        (distances**-3.0, surface.InverseDistance(POINTS, VALUES, power=3)(AT)),
        (np.exp(-((2.5 * distances) ** 2)), surface.SquaredExponential(POINTS, VALUES, scale=2.5)(AT)),
    ]:
        np.testing.assert_allclose(found, weights @ VALUES / weights.sum(axis=1), rtol=1e-11)
    assert (surface.InverseDistance(POINTS, VALUES)(POINTS) == VALUES).all()
    chosen = surface.SquaredExponential(POINTS, VALUES)
    again = surface.SquaredExponential(POINTS, VALUES, scale=chosen.scale)
    assert (chosen(AT) == again(AT)).all()


@pytest.mark.parametrize("residual, nu", [("smooth", 2.5), ("rough", 1.5)])
def test_a_process_is_scikit_learns(residual: str, nu: float) -> None:
    kernel = ConstantKernel(4.0) + 1.7 * Matern([0.6, 1.3], nu=nu)
    expected = GaussianProcessRegressor(kernel, alpha=0.02 / WEIGHTS, optimizer=None).fit(POINTS, VALUES)
    mean, deviation = expected.predict(AT, return_std=True)
    found = surface.GaussianProcess.given(
        POINTS,
        VALUES,
        lengths=[0.6, 1.3],
        residual_variance=1.7,
        noise_variance=0.02,
        residual=residual,
        weights=WEIGHTS,
    )
    means, variances = found.predict(AT)
    np.testing.assert_allclose(means, mean, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(variances, deviation**2, rtol=1e-6)


def test_an_averaged_process_learns_what_the_simulation_lacks() -> None:
    def truth(points: "np.ndarray[tuple[int, int], np.dtype[np.float64]]") -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
        return np.asarray(np.sin(9 * points[:, 0]) + 0.3 * points[:, 1])

    simulated = np.sin(9 * POINTS[:, 0])
    with_it = surface.GaussianProcess(POINTS, truth(POINTS), simulated=simulated, seed=2)
    without = surface.GaussianProcess(POINTS, truth(POINTS), seed=2)
    mean, variance = with_it.predict(AT, simulated=np.sin(9 * AT[:, 0]))
    assert np.abs(mean - truth(AT)).max() < 0.02 < np.abs(without.predict(AT)[0] - truth(AT)).max()
    assert (variance >= 0).all() and with_it.noise is not None and with_it.noise < 0.1
    with pytest.raises(Error, match="simulated responses"):
        with_it.predict(AT)


def test_any_layout_of_an_array_will_do() -> None:
    fit = surface.Regression(np.asfortranarray(POINTS), VALUES)
    wide = np.zeros((50, 4))
    wide[:, ::2] = AT
    assert (fit(wide[:, ::2]) == fit(AT)).all()
    assert (fit(AT.tolist()) == fit(AT)).all()
    assert fit.minimum(AT) == (int(np.argmin(fit(AT))), fit(AT).min())


def test_what_is_wrong_is_said() -> None:
    cases: Refused = [
        (lambda: surface.Regression(POINTS, VALUES[:-1]), "number of values of data points: 19, expected 20"),
        (lambda: surface.Regression(POINTS[:4], VALUES[:4]), "4"),
        (lambda: surface.Regression(POINTS, VALUES)([[1.0]]), "factors|coordinates"),
        (lambda: surface.InverseDistance(POINTS, VALUES, power=-1), "power"),
        (lambda: surface.Regression(POINTS, VALUES * np.nan), "NaN"),
    ]
    for call, message in cases:
        with pytest.raises(Error, match=message):
            call()
