"""Designs, against numpy and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from conftest import Refused
from infuse import Error, Parameter, doe


def test_the_g_efficiency_is_that_of_a_fine_lattice() -> None:
    found = doe.search(2, 8, starts=40, seed=1)
    axis = np.linspace(-1, 1, 201)
    lattice = np.array([(x, y) for x in axis for y in axis])
    r, all_rows = doe.regressor(found.runs), doe.regressor(lattice)
    largest = np.einsum("ij,jk,ik->i", all_rows, np.linalg.inv(r.T @ r), all_rows).max()
    assert found.efficiency == pytest.approx(100 * 6 / (8 * largest), abs=1e-3)
    assert found.sentence == f"G-efficiency {found.efficiency:.3f} % over the cube [-1, 1]^2"


def test_d_and_a_efficiencies_are_numpys() -> None:
    rng = np.random.default_rng(5)
    runs = rng.uniform(-1, 1, (12, 3))
    r = doe.regressor(runs)
    information = r.T @ r
    d = np.exp(np.linalg.slogdet(information)[1] / 10) / 12
    a = 10 / (12 * np.trace(np.linalg.inv(information)))
    assert doe.efficiency(runs, criterion="D") == pytest.approx(100 * d, rel=1e-10)
    assert doe.efficiency(runs, criterion="A") == pytest.approx(100 * a, rel=1e-8)


def test_the_regressor_is_a_product_of_powers() -> None:
    points = np.random.default_rng(1).uniform(-1, 1, (5, 2))
    x, y = points.T
    expected = np.column_stack([np.ones(5), x, y, x * y, x * x, y * y])
    np.testing.assert_allclose(doe.regressor(points), expected, rtol=1e-15)
    assert doe.term_names(["a", "b"]) == ["1", "a", "b", "a b", "a^2", "b^2"]
    np.testing.assert_array_equal(doe.regressor(points, model=[[0, 0], [2, 1]])[:, 1], x * x * y)


def test_levels_and_fixed_runs_are_kept() -> None:
    parameters = [Parameter("spring", "N/mm", 10, 50, levels=5), Parameter("damper", "N s/m", 0, 400, levels=3)]
    found = doe.search(parameters, 9, criterion="D", starts=10, fixed=[[0.0, 0.0]])
    assert found.runs[0].tolist() == [0.0, 0.0]
    assert set(found.runs[:, 0]) <= {-1.0, -0.5, 0.0, 0.5, 1.0} and set(found.runs[:, 1]) <= {-1.0, 0.0, 1.0}
    assert found.natural()[0].tolist() == [30.0, 200.0]
    assert list(found.frame().columns) == ["spring", "damper"]
    np.testing.assert_allclose(doe.coded(parameters, found.natural()), found.runs, atol=1e-15)


def test_a_seed_repeats_a_design() -> None:
    first, second = (doe.search(3, 12, starts=5, seed=9) for _ in range(2))
    assert (first.runs == second.runs).all() and first.efficiency == second.efficiency


def test_what_is_wrong_is_said() -> None:
    cases: Refused = [
        (lambda: doe.search(2, 8, criterion="Q"), "criterion is `Q`"),
        (lambda: doe.search(2, 8, model="cubic"), "cubic"),
        (lambda: doe.search(2, 8, starts=0), "starts"),
        (lambda: doe.search([2, 2], 8), "x1\\^2"),
        (lambda: doe.search(2, 8, time_limit_s=-1.0), "time_limit_s"),
    ]
    for call, message in cases:
        with pytest.raises(Error, match=message):
            call()
