"""Data frames: by the names of their columns, with constraints, all or nothing, and errors that name row and column."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas
import pytest

from conftest import SPRING_AND_DAMPER, Refused, rig, simulation
from infuse import Constraint, Error, DissertationLoop, Parameter, PooledLoop, doe, flights, surface

VARIABLES = ["center_of_mass", "pitch_set_point"]
TRAVEL = [Constraint("travel", upper=5.0)]


def begun(**settings: Any) -> PooledLoop:
    loop = PooledLoop(SPRING_AND_DAMPER, 4, seed=2, **settings)
    loop.ask()
    return loop


def check(cases: Refused) -> None:
    for call, message in cases:
        with pytest.raises(Error, match=message):
            call()


def test_flights_take_columns_by_name() -> None:
    channel = flights.Channel()
    expected = channel.fly([[45.7, 8.3], [50.0, 12.0]], VARIABLES).cost
    table = pandas.DataFrame({"pitch_set_point": [8.3, 12.0], "center_of_mass": [45.7, 50.0]})
    assert (channel.fly(table, VARIABLES).cost == expected).all()
    assert (channel.simulator(VARIABLES)(table) == expected).all()
    dictionary = {"pitch_set_point": 8.3, "center_of_mass": 45.7}
    assert channel.fly(dictionary, VARIABLES).cost[0] == channel.fly(table.iloc[0], VARIABLES).cost[0] == expected[0]
    check([
        (lambda: channel.fly(table.assign(id=1), VARIABLES), "column `id` is unknown, expected center_of_mass, pitch_set"),
        (lambda: channel.simulator(VARIABLES)(table[["center_of_mass"]]), "no column `pitch_set_point`"),
        (lambda: channel.fly(table, ["center_of_mass", "center_of_mass"]), "`center_of_mass` comes twice"),
        (lambda: channel.fly([[48.0, 0.47]], ["center_of_mass", "body.center_of_mass_x"]), "by another name, too"),
        (lambda: channel.fly([[48.0]], "center_of_mass"), "`variables` is 'center_of_mass', expected a list"),
    ])


def test_designs_and_surfaces_take_columns_by_name() -> None:
    parameters = [Parameter("a", "mm", 0.0, 10.0), Parameter("b", "mm", 0.0, 1.0)]
    table = pandas.DataFrame({"b": [0.5, 1.0], "a": [2.5, 0.0]})
    assert doe.coded(parameters, table).tolist() == [[-0.5, 0.0], [-1.0, 1.0]]
    coded = pandas.DataFrame({"b": [0.0], "a": [-0.5]})
    assert doe.natural(parameters, coded).tolist() == [[2.5, 0.5]]
    found = doe.search(parameters, 8, starts=5, fixed=coded)
    assert found.runs[0].tolist() == [-0.5, 0.0]
    swapped = pandas.DataFrame(found.runs[:, ::-1], columns=["b", "a"])
    assert doe.efficiency(swapped, factors=parameters) == doe.efficiency(found.runs, factors=parameters)
    corners = pandas.DataFrame({"a": [-1.0, 1.0, -1.0, 1.0], "b": [-1.0, -1.0, 1.0, 1.0]})
    plane = surface.Regression(corners, [1.0, 2.0, 3.0, 4.0], model="linear")
    assert plane(corners[["b", "a"]]).round(9).tolist() == [1.0, 2.0, 3.0, 4.0]
    check([
        (lambda: doe.coded(parameters, table[["a"]]), "no column `b`, expected a, b"),
        (lambda: doe.coded(parameters, table.assign(c=1.0)), "column `c` is unknown"),
        (lambda: plane(corners.rename(columns={"a": "c"})), "no column `a`"),
    ])


def test_frames_carry_constraints_both_ways() -> None:
    loop = begun(constraints=TRAVEL)
    table = loop.frame()
    assert list(table.columns) == ["id", "batch", "spring", "damper", "value", "travel", "failed"]
    assert loop.tell_frame(table.assign(value=1.0, travel=[1.0, 2.0, 3.0, np.nan])) == 4
    assert [record.constrained for record in loop.records()] == [{"travel": 1.0}, {"travel": 2.0}, {"travel": 3.0}, {}]
    table = loop.frame()
    assert table["travel"].tolist()[:3] == [1.0, 2.0, 3.0] and np.isnan(table["travel"][3])
    assert loop.tell_frame(table) == 0, "nothing new"
    assert loop.tell_frame(table.assign(travel=[1.0, 2.0, 3.0, 9.0])) == 1, "what was measured later"
    check([(lambda: loop.tell_frame(table.assign(travel=7.0)), "row 0: `travel` is 7.0, expected 1.0 as before")])
    loop.tell_constrained(1, {"travel": 7.0})
    assert loop.records()[0].constrained == {"travel": 7.0}


def test_what_was_not_meant_is_refused_with_its_row_and_column() -> None:
    loop, table = begun(), begun().frame()
    hose: Any = [None, "hose", None, None]
    true: Any = [True, None, None, None]
    check([
        (lambda: loop.tell_frame(table.assign(value=1.0, travel=1.0)), "column `travel` is unknown, expected id, batch, spring"),
        (lambda: loop.tell_frame(table.assign(value=1.0, id=[1.5, 2, 3, 4])), "row 0: `id` is 1.5, expected the number of a"),
        (lambda: loop.tell_frame(table.assign(value=1.0, id=[1, 2, np.nan, 4])), "row 2: `id` is nan, expected the number"),
        (lambda: loop.tell_frame(table.assign(value=1.0, id=[1, 2, 2, 4])), "trial 2 has an outcome already"),
        (lambda: loop.tell_frame(table.assign(value=1.0, failed=hose)), "row 1: both a value and a"),
        (lambda: loop.tell_frame(table.assign(value=[1.0, 2.0, "1,5", 3.0])), "row 2: `value` is '1,5', expected a number"),
        (lambda: loop.tell_frame(table.assign(failed=true)), "row 0: `failed` is True, expected the reason"),
        (lambda: loop.tell_frame(table.assign(value=1.0, spring=[1.0, np.nan, 3.0, 4.0])), "row 1: `spring` is nan"),
        (lambda: loop.tell_frame(table.assign(value=1.0).drop(columns="damper")), "no column `damper`, expected one for each"),
        (lambda: loop.tell_frame(table.drop(columns="id")), "no column `id`"),
        (lambda: loop.tell_frame(table.assign(value=np.inf)), "the outcome of trial 1 is inf, expected a number of magnitude at most 1e100"),
        (lambda: loop.tell_frame(pandas.concat([table, table[["spring"]]], axis=1)), "column `spring` comes twice"),
        (lambda: loop.tell_frame({"id": 1}), "a dict, expected a data frame"),  # type: ignore[arg-type]
        (lambda: loop.tell_frame(table.assign(value=1.0, cost=2.0), "cost"), "row 0: `value` and `cost` differ"),
        (lambda: loop.tell_frame(table, "spring"), "the column of values is `spring`, expected one of its own"),
    ])
    assert all(record.value is None and record.failed is None for record in loop.records()), "all or nothing"
    assert loop.tell_frame(table.assign(cost=2.0), "cost") == 4


@pytest.mark.parametrize(
    "values",
    [
        pandas.array([1.0, None, 3.0, None], dtype="Float64"),
        np.array([1.0, None, 3.0, None], dtype=object),
        np.array([1.0, pandas.NA, 3, pandas.NaT], dtype=object),
        [1.0, np.nan, 3.0, np.nan],
    ],
)
def test_what_is_missing_says_nothing_in_whatever_way_it_is_missing(values: Any) -> None:
    loop = begun()
    assert loop.tell_frame(loop.frame().assign(value=values)) == 2
    assert [record.value for record in loop.records()] == [1.0, None, 3.0, None]
    nullable = loop.frame().convert_dtypes()
    nullable["failed"] = pandas.array([None, "hose", None, ""], dtype="string")
    assert loop.tell_frame(nullable) == 1 and loop.records()[1].failed == "hose"
    with pytest.raises(Error, match="neither a value nor a failure"):
        loop.tell(4, pandas.NA)  # type: ignore[arg-type]


def test_settings_are_written_as_in_a_sheet_and_still_count_as_asked() -> None:
    # 0.5 to 2.9 in 13 levels: the level 2.7 is 2.6999999999999997 as it is computed.
    parameters = [Parameter("damper", "N s/m", 0.5, 2.9, levels=13)]
    loop = PooledLoop(parameters, 13)
    trials = loop.hand_out([{"damper": round(0.5 + 0.2 * level, 1)} for level in range(13)])
    assert [trial.settings["damper"] for trial in trials] == [round(0.5 + 0.2 * level, 1) for level in range(13)]
    assert loop.tell_frame(loop.frame().assign(value=1.0)) == 13
    assert all(record.actual is None for record in loop.records())
    again = PooledLoop(parameters, 13)
    trial = again.hand_out([[2.7]])[0]
    again.tell_at(trial.id, trial.settings, 1.0)
    made = again.records()[0].actual
    assert made is not None and made["damper"] == 2.6999999999999997, "with all digits of the level"
    thirds = PooledLoop([Parameter("x", "mm", 1 / 3, 2 / 3, levels=2)], 3)
    both = [{"x": 0.333333333333}, {"x": 0.666666666667}]
    assert [trial.settings for trial in thirds.hand_out(both)] == both, "bounds as they are written are within"
    design = doe.search(parameters, 4, model="linear", starts=5)
    assert all(run == round(run, 1) for run in design.frame()["damper"])


def test_the_dissertations_loop_shows_every_trial_of_a_batch_that_is_open() -> None:
    loop = DissertationLoop(SPRING_AND_DAMPER, "quadratic", 9, 12, max_batches=2)
    for trial in loop.ask(simulation):
        loop.tell(trial.id, rig(trial.settings))
    first = loop.ask(simulation)[0]
    loop.tell(first.id, 1.0)
    table: Any = loop.frame()
    assert list(table.columns) == ["id", "batch", "spring", "damper", "value", "failed"]
    assert table["id"].tolist() == list(range(1, len(table) + 1)) and table["batch"].tolist()[:10] == [1] * 9 + [2]
    assert table["value"].notna().sum() == 10 and table["value"][9] == 1.0
    n_left = len(loop.outstanding())
    assert loop.tell_frame(table.assign(value=table["value"].fillna(2.0))) == n_left and loop.batch == 2
    with pytest.raises(AttributeError, match="`DissertationLoop` has no `correct`, `PooledLoop` has: the surfaces of a closed"):
        loop.correct(1, 2.0)  # type: ignore[attr-defined]
    assert not hasattr(loop, "change")
