"""What is wrong is said in words of Python: the field, the value, and what is allowed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas
import pytest

from conftest import SPRING_AND_DAMPER, Refused
from infuse import Constraint, Error, DissertationLoop, LinearConstraint, Parameter, Plants, PooledLoop, doe, surface

LEVELS = [Parameter("x", "mm", 0.0, 10.0, levels=11)]
PAD = [Parameter("spring", "N/mm", 10.0, 50.0, levels=9), Parameter.choice("pad", ["foam", "film", "wood"])]


def check(cases: Refused) -> None:
    for call, message in cases:
        with pytest.raises(Error) as caught:
            call()
        assert str(caught.value) == message


def pooled(n_experiments: Any = 3, **settings: Any) -> PooledLoop:
    return PooledLoop(LEVELS, n_experiments, **settings)


def dissertation(**settings: Any) -> DissertationLoop:
    return DissertationLoop(SPRING_AND_DAMPER, "linear", 6, 8, **settings)


def test_numbers_of_numpy_are_numbers() -> None:
    loop = pooled(np.int64(3), noise=np.float32(0.5), seed=np.uint8(7), max_batches=4.0, worth=np.float64(0.25))
    found = loop.settings
    assert (found["n_experiments"], found["noise"], found["seed"], found["max_batches"]) == (3, 0.5, 7, 4)
    assert dissertation(replicates=np.int32(2), careful=np.bool_(True)).settings["replicates"] == 2
    of_numpy: Any = (np.int64(0), np.float32(1.0), np.int16(5))
    assert Parameter("x", "mm", *of_numpy) == Parameter("x", "mm", 0.0, 1.0, 5)
    trial = loop.ask()[0]
    loop.tell(np.int64(trial.id), np.float32(2.0))  # type: ignore[arg-type]
    loop.tell(2.0, np.int64(3))  # type: ignore[arg-type]
    assert [record.value for record in loop.records()] == [2.0, 3.0, None]


def test_settings_are_refused_by_their_names() -> None:
    check([
        (lambda: pooled(3.5), "setting `n_experiments` is 3.5, expected a whole number from 0 on"),
        (lambda: pooled(-1), "setting `n_experiments` is -1, expected a whole number from 0 on"),
        (lambda: pooled("3"), "setting `n_experiments` is '3', expected a whole number from 0 on"),
        (lambda: pooled(True), "setting `n_experiments` is True, expected a whole number from 0 on"),
        (lambda: pooled(seed=-1), "setting `seed` is -1, expected a whole number from 0 on"),
        (lambda: pooled(seed=2**64), "setting `seed` is 18446744073709551616, expected a whole number from 0 on"),
        (lambda: pooled(noise=np.nan), "setting `noise` is nan, expected a finite number"),
        (lambda: pooled(confidence="0.9"), "setting `confidence` is '0.9', expected a finite number"),
        (lambda: Constraint("t", upper=np.nan), "constraint `t`: `upper` is nan, expected a finite number"),
        (lambda: Constraint("t", lower="1"), "constraint `t`: `lower` is '1', expected a finite number"),  # type: ignore[arg-type]
        (
            lambda: LinearConstraint({"x": 0.0}, upper=1.0),
            "linear constraint: `sum` is {'x': 0.0}, expected one factor at least that is not 0",
        ),
        (
            lambda: LinearConstraint({"x": 1.0}, lower=2.0, upper=1.0),
            "linear constraint: `lower` is 2.0, expected at most `upper`, 1.0",
        ),
        (
            lambda: Plants(["x"], change_costs=3.0),  # type: ignore[arg-type]
            "plants: `change_costs` is 3.0, expected a number per parameter",
        ),
        (lambda: Parameter("x", "", 0.0, 1.0, levels=2**40), "parameter `x`: `levels` is 1099511627776, expected a whole number"),
        (lambda: doe.coded(LEVELS, np.array([["1,5"]], dtype=object)), "points: entry 0 is '1,5', expected a number"),
        (lambda: dissertation(careful=3), "setting `careful`: it is `3`, expected True or False"),
        (lambda: dissertation(correction={"gain": 1}), "setting `correction`: it is `1`, expected a name or a dictionary"),
        (
            lambda: dissertation(surfaces="regression"),
            'setting `surfaces`: it is "regression", expected a dictionary, like { "combined": "inverse_distance" }',
        ),
        (
            lambda: doe.coded(SPRING_AND_DAMPER, [[1.0, 2.0, 3.0]]),
            "a design has 3 numbers, expected 2: spring, damper",
        ),
        (lambda: doe.coded(SPRING_AND_DAMPER, [[60.0, 0.0]]), "parameter `spring` is 60.0, expected 10.0 to 50.0 N/mm"),
        (lambda: doe.coded(SPRING_AND_DAMPER, [[np.nan, 0.0]]), "parameter `spring` is nan, expected 10.0 to 50.0 N/mm"),
        (lambda: doe.natural(SPRING_AND_DAMPER, [[np.nan, 0.0]]), "points: nan, expected finite coded numbers"),
        (lambda: doe.search(2, 8.5), "`runs` is 8.5, expected a whole number from 0 on"),  # type: ignore[arg-type]
        (
            lambda: doe.search(2, 8, model=[[0.5, 1]]),  # type: ignore[list-item]
            "`model` is [[0.5, 1]], expected whole exponents from 0 to 255",
        ),
        (
            lambda: surface.Regression([[1j]], [1.0]),
            "points: an array of complex numbers, expected numbers",
        ),
    ])


def test_names_are_refused_as_the_shell_refuses_them() -> None:
    travel = Constraint("travel", upper=1.0)
    heading = "is a column of data frames and sheets, expected another name for a parameter or constraint"
    check([
        (
            lambda: pooled(constraints=[travel, Constraint("travel", lower=0.0)]),
            "constraint `travel` comes twice; one constraint may have both bounds",
        ),
        (
            lambda: pooled(constraints=[Constraint("x", upper=1.0)]),
            "constraint `x` is also the name of a parameter, expected another",
        ),
        (lambda: pooled(constraints=[Constraint("value", upper=1.0)]), f"`value` {heading}"),
        (
            lambda: pooled(constraints=[Constraint("a, b", upper=1.0)]),
            "constraint: `name` is 'a, b', expected words without brackets, quotes, commas, semicolons or equals signs",
        ),
    ])
    with pytest.raises(Error, match="`x`"):
        PooledLoop(LEVELS * 2, 3)
    for name in ("id", "batch", "value", "failed", "actual x"):
        parameter = Parameter(name, "", 0.0, 1.0, levels=5)
        check([
            (lambda: PooledLoop([parameter], 3), f"`{name}` {heading}"),
            (lambda: DissertationLoop([parameter], "linear", 3, 3), f"`{name}` {heading}"),
        ])


def test_texts_are_neither_lists_nor_numbers() -> None:
    loop = PooledLoop(PAD, 3)
    loop.ask()
    check([
        (lambda: Parameter.choice("pad", "foam"), "parameter `pad`: `choices` is 'foam', expected a list of names"),
        (lambda: Parameter.choice("pad", ["a"]), "parameter `pad`: 1 choice, expected 2 to 1000"),
        (lambda: Parameter.choice("pad", [1, 2]), "parameter `pad`: `choices`: entry 1 is 1, expected a text"),  # type: ignore[list-item]
        (lambda: Plants("x"), "plants: `parameters` is 'x', expected a list of names of parameters"),  # type: ignore[arg-type]
        (lambda: loop.tell(1, "2.0"), "`value` is '2.0', expected a number"),  # type: ignore[arg-type]
        (lambda: loop.tell(1, np.array([2.0])), "`value` is array([2.]), expected a number"),  # type: ignore[arg-type]
        (lambda: loop.tell(1, failed=""), "`failed` is '', expected the reason in words"),
        (lambda: loop.tell(1.5, 2.0), "`id` is 1.5, expected the number of a trial"),  # type: ignore[arg-type]
        (lambda: loop.tell(-1, 2.0), "`id` is -1, expected the number of a trial"),
        (lambda: loop.add_earlier({"spring": "20", "pad": "foam"}, 1.0), "settings: `spring` is '20', expected a number"),
        (
            lambda: loop.add_earlier([[20.0, 0.5]], 1.0),
            "settings: `pad` is 0.5, expected a place in its list, 0 to 2, or in a dictionary or data frame its name",
        ),
        (
            lambda: loop.tell_at(1, [20.0, 5.0], 1.0),
            "settings: `pad` is 5.0, expected a place in its list, 0 to 2, or in a dictionary or data frame its name",
        ),
        (
            lambda: loop.add_earlier(pandas.DataFrame({"spring": [20.0], "pad": [None]}), 1.0),
            "data frame, row 0: `pad` is None, expected one of foam, film, wood",
        ),
    ])
    assert all(record.value is None for record in loop.records()) and loop.withdraw_earlier("") == 0


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    loop = pooled()
    loop.ask()
    loop.save(path)
    text = path.read_text()
    damages = [
        (text[:-20], "it ends too early, in line [0-9]+ at character [0-9]+, expected a campaign as `save` writes it"),
        (text.replace(":", ";", 1), "it is damaged, in line 2"),
        ("{}", "it names no kind or no format"),
        (text.replace('"trials"', '"trails"'), "changed by hand or is damaged: unknown field `trails`"),
    ]
    for damaged, message in damages:
        path.write_text(damaged)
        with pytest.raises(Error, match=message) as caught:
            PooledLoop.load(path)
        assert str(caught.value).startswith(f"{path}: ")


def test_a_change_takes_what_the_beginning_takes() -> None:
    loop = pooled(constraints=[Constraint("travel", upper=5.0)])
    loop.change(constraints=[Constraint("travel", upper=20.0)], plants=Plants(["x"], most=2), n_experiments=np.int64(4))
    loop.change(linear_constraints=[LinearConstraint({"x": 1.0}, upper=9.0)])
    assert loop.settings["constraints"][0]["upper"] == 20.0 and loop.settings["plants"]["parameters"] == [0]
    assert len(loop.ask()) == 4 and all(trial.settings["x"] <= 9.0 for trial in loop.outstanding())
    loop.tell(1, 1.0, constrained={"travel": 3.0})
    both = [Constraint("travel", lower=1.0), Constraint("heat", upper=2.0)]
    check([
        (lambda: loop.change(constraints=both[1:]), "constraints: heat, expected travel first: values of them are known"),
        (lambda: loop.change(constraints="travel"), "`constraints` is 'travel', expected a list"),
        (
            lambda: loop.change(constraints=[both[0], both[0]]),
            "constraint `travel` comes twice; one constraint may have both bounds",
        ),
        (lambda: loop.change(noise=np.inf), "setting `noise` is inf, expected a finite number"),
    ])
    with pytest.raises(Error, match="setting `n_experiment` is unknown, expected one of n_experiments, "):
        loop.change(n_experiment=3)
    loop.change(constraints=both)
    loop.tell_constrained(1, {"heat": 1.5})
    assert loop.records()[0].constrained == {"travel": 3.0, "heat": 1.5}, "what is not named stays"


def test_earlier_and_other_settings_bring_their_constrained_values(tmp_path: Path) -> None:
    def known(loop: PooledLoop) -> Any:
        found = loop.assess()
        assert found is not None
        return [(one.mean, one.within) for one in found.recommended.constrained]

    def begun() -> PooledLoop:
        return pooled(constraints=[Constraint("travel", upper=5.0)])

    at, values, travel = [[1.0], [4.0], [9.0]], [3.0, 2.0, 1.0], [1.0, 4.5, np.nan]
    earlier, told = begun(), begun()
    earlier.add_earlier(at, values, constrained={"travel": travel}, source="last year")
    for trial, point, value, other in zip(told.hand_out(at), at, values, travel):
        told.tell_at(trial.id, point, value, constrained={"travel": other})
    assert known(earlier) == known(told) and known(earlier)[0][0] is not None
    earlier.save(tmp_path / "c.json")
    assert known(PooledLoop.load(tmp_path / "c.json")) == known(earlier)
    check([
        (
            lambda: earlier.add_earlier(at, values, constrained={"stroke": travel}),
            "constrained: `stroke` is no constraint, expected travel",
        ),
        (
            lambda: earlier.add_earlier(at, values, constrained={"travel": [1.0]}),
            "constrained: `travel` has 1 entries, expected 3: one per design",
        ),
        (
            lambda: earlier.add_earlier(pandas.DataFrame({"x": [1.0], "travel": [2.0]}), [1.0]),
            "data frame: column `travel` is a constraint, expected its values in `constrained`",
        ),
        (
            lambda: earlier.add_earlier({"x": 1.0}, failed="it broke", constrained={"travel": 1.0}),
            "constrained: [1.0], expected nothing for an earlier experiment that failed",
        ),
    ])

