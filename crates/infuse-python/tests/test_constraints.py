"""Constraints and plants: what is recommended keeps to them, and a file holds them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict

import numpy as np
import pytest
from numpy.typing import NDArray

import infuse
from infuse import Assessment, Constraint, LinearConstraint, Parameter, Plants, PooledLoop

PARAMETERS = [Parameter("a", "mm", 0.0, 1.0, levels=21), Parameter("b", "mm", 0.0, 1.0, levels=21)]


def truth(settings: Dict[str, float]) -> float:
    return (settings["a"] - 0.9) ** 2 + (settings["b"] - 0.9) ** 2


def travel(settings: Dict[str, float]) -> float:
    return settings["a"] + settings["b"]


def simulate(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """The response, and behind it the travel."""
    return np.stack([((points - 0.7) ** 2).sum(axis=1), 0.8 * points.sum(axis=1)], axis=1)


def told(loop: PooledLoop, simulation: Any) -> Assessment:
    while loop.stopped is None:
        for trial in loop.ask(simulation):
            loop.tell(trial.id, truth(trial.settings), constrained={"travel": travel(trial.settings)})
    found = loop.assess(simulation)
    assert found is not None
    return found


def test_recommended_design_keeps_to_its_bound_and_is_near_the_best_that_does() -> None:
    loop = PooledLoop(PARAMETERS, 8, max_batches=3, constraints=[Constraint("travel", upper=1.02)])
    best = told(loop, simulate).recommended
    assert best.suffices and best.constrained[0].within >= 0.9
    # The best is at (0.5, 0.5), with 0.32.
    assert travel(best.settings) <= 1.02 and truth(best.settings) < 0.36


def test_a_file_holds_what_was_measured_of_the_constraints(tmp_path: Path) -> None:
    loop = PooledLoop(PARAMETERS, 8, max_batches=2, constraints=[Constraint("travel", upper=1.02)])
    before = told(loop, simulate)
    loop.save(tmp_path / "campaign.json")
    again = PooledLoop.load(tmp_path / "campaign.json")
    assert again.assess(simulate) == before


def test_linear_constraints_and_plants_are_kept_to() -> None:
    together = LinearConstraint({"a": 1.0, "b": 1.0}, lower=0.3, upper=0.9)
    loop = PooledLoop(PARAMETERS, 9, max_batches=2, linear_constraints=[together], plants=Plants(["a"], most=3))
    while loop.stopped is None:
        batch = loop.ask()
        assert len({trial.settings["a"] for trial in batch}) <= 3
        for trial in batch:
            assert 0.3 - 1e-9 <= travel(trial.settings) <= 0.9 + 1e-9
            loop.tell(trial.id, truth(trial.settings))
    found = loop.assess()
    assert found is not None and found.assembly is not None


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(infuse.Error, match="`c` is no parameter"):
        PooledLoop(PARAMETERS, 4, plants=Plants(["c"]))
    with pytest.raises(infuse.Error, match="neither `lower` nor `upper`"):
        PooledLoop(PARAMETERS, 4, linear_constraints=[LinearConstraint({"a": 1.0})])
    with pytest.raises(infuse.Error, match="at least one of the two bounds"):
        PooledLoop(PARAMETERS, 4, constraints=[Constraint("travel")])
    loop = PooledLoop(PARAMETERS, 4, constraints=[Constraint("travel", upper=1.0)])
    trial = loop.ask()[0]
    with pytest.raises(infuse.Error, match="`stroke` is no constraint, expected travel"):
        loop.tell(trial.id, 1.0, constrained={"stroke": 1.0})
    assert loop.records()[0].value is None, "nothing was taken"
