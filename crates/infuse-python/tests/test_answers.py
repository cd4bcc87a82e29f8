"""What a simulation answers: one shape, in one order, finite or NaN; anything else is refused, and the campaign is as before."""

from __future__ import annotations

from typing import Any, Callable, List

import numpy as np
import pandas
import pytest

import infuse
from conftest import SPRING_AND_DAMPER, simulation
from infuse import Constraint, Error, PooledLoop

TRAVEL = [Constraint("travel", upper=1.0)]


def travel(points: Any) -> Any:
    return points[:, 0] / 50.0


def refused(simulate: Callable[[Any], Any], message: str, **settings: Any) -> None:
    loop = PooledLoop(SPRING_AND_DAMPER, 5, **settings)
    with pytest.raises(Error, match=message):
        loop.ask(simulate)
    assert (loop.records(), loop.n_simulated) == ([], 0)


def test_two_responses_as_two_rows_are_refused_and_not_read_in_another_order() -> None:
    rows = r"shape \(2, 441\), expected \(441,\) or \(441, 2\)"
    refused(lambda p: np.array([simulation(p), travel(p)]), rows, constraints=TRAVEL)
    refused(lambda p: (simulation(p), travel(p)), rows, constraints=TRAVEL)
    refused(lambda p: (simulation(p), travel(p)), r"the simulation gave an array of shape \(2, 441\), expected \(441,\)$")
    refused(lambda p: np.stack([simulation(p), travel(p)], 1), r"shape \(441, 2\), expected \(441,\)$")
    refused(lambda p: np.stack([simulation(p)] * 3, 1), r"shape \(441, 3\), expected \(441,\) or", constraints=TRAVEL)
    refused(lambda p: 1.0, r"shape \(\), expected \(441,\)$")


def test_what_is_no_array_of_finite_numbers_is_refused() -> None:
    refused(lambda p: None, r"the simulation gave None, expected \(441,\)")
    refused(lambda p: simulation(p) + 0j, "the simulation: an array of complex numbers, expected numbers")
    refused(lambda p: ["1.0"] * len(p), "the simulation: an array of texts, expected numbers")
    refused(lambda p: np.where(p[:, 0] > 49, np.inf, 1.0), "gave inf for design [0-9]+, expected a finite number")
    refused(lambda p: np.full((len(p), 2), [1.0, -np.inf]), "gave -inf for design 0, expected", constraints=TRAVEL)
    with pytest.raises(Error, match="`simulate` is 5, expected a function"):
        PooledLoop(SPRING_AND_DAMPER, 5).ask(5)  # type: ignore[arg-type]


def asked(simulate: Callable[[Any], Any], **settings: Any) -> List[infuse.Trial]:
    loop = PooledLoop(SPRING_AND_DAMPER, 5, seed=2, **settings)
    for trial in loop.ask(simulate):
        loop.tell(trial.id, trial.settings["spring"])
    return loop.ask(simulate)


def test_columns_and_data_frames_say_the_same_as_arrays() -> None:
    both = asked(lambda p: np.stack([simulation(p), travel(p)], 1), constraints=TRAVEL)
    by_name = asked(lambda p: pandas.DataFrame({"travel": travel(p), "cost": simulation(p)}), constraints=TRAVEL)
    assert by_name == both
    assert asked(lambda p: simulation(p).reshape(-1, 1)) == asked(simulation) == asked(lambda p: simulation(p).tolist())

    def of_other_names(points: Any) -> Any:
        return pandas.DataFrame({"cost": simulation(points), "stroke": travel(points)})

    refused(of_other_names, "the simulation gave the columns cost, stroke, expected the response and travel", constraints=TRAVEL)


def test_a_series_in_another_order_goes_by_its_index() -> None:
    def cost(table: Any) -> Any:
        return ((table["spring"] - 25.0) / 20.0) ** 2 + ((table["damper"] - 150.0) / 200.0) ** 2

    def framed(shuffle: Callable[[Any], Any]) -> Callable[[Any], Any]:
        return infuse.with_frames(SPRING_AND_DAMPER, lambda table: shuffle(cost(table)))

    points = np.array([[30.0, 100.0], [10.0, 300.0], [50.0, 200.0]])
    expected = np.asarray(framed(lambda found: found)(points)).tolist()
    for shuffle in (lambda found: found.sort_values(), lambda found: found.sample(frac=1.0, random_state=1)):
        assert np.asarray(framed(shuffle)(points)).tolist() == expected
    with pytest.raises(Error, match="a Series with an index of its own, expected the index of the table"):
        framed(lambda found: found.set_axis(["a", "b", "c"]))(points)
    # A plain simulation that builds its own table: places from 0 in another order are put right as well.
    shuffled = asked(lambda p: pandas.Series(simulation(p)).sort_values())
    assert shuffled == asked(simulation)


def test_dear_simulations_are_told_in_the_same_shapes() -> None:
    loop = PooledLoop(SPRING_AND_DAMPER, 5, simulations=8, constraints=TRAVEL)
    loop.ask()
    due = loop.due
    wrong = np.array([simulation(due), travel(due)])
    with pytest.raises(Error, match=rf"`values` is an array of shape \(2, {len(due)}\), expected"):
        loop.tell_simulations(due, wrong)
    table = pandas.DataFrame(due, columns=["spring", "damper"])
    with pytest.raises(Error, match="values: another index than that of the designs"):
        loop.tell_simulations(table, pandas.Series(simulation(due), index=range(7, 7 + len(due))))
    loop.tell_simulations(table, wrong.T)
    assert len(loop.due) == 0 and len(loop.ask()) == 5
