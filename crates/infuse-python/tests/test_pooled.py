"""The pooled loop by ask and tell."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any, List

import numpy as np
import pandas
import pytest

import infuse
from conftest import SPRING_AND_DAMPER, Refused, rig, simulation
from infuse import Error, Parameter, PooledLoop

LEVELS = [Parameter("x", "mm", 0.0, 10.0, levels=11)]
MANY = [Parameter(name, "mm", 0.0, 1.0, levels=21) for name in "abcd"]


def after_batches(n: int, **settings: Any) -> PooledLoop:
    loop = PooledLoop(SPRING_AND_DAMPER, 5, seed=3, **settings)
    for _ in range(n):
        for trial in loop.ask(simulation):
            loop.tell(trial.id, rig(trial.settings))
    return loop


def test_settings_are_levels_of_the_parameters() -> None:
    for trial in PooledLoop(SPRING_AND_DAMPER, 9, seed=2).ask():
        assert trial.settings["spring"] in np.linspace(10, 50, 21)
        assert trial.settings["damper"] in np.linspace(0, 400, 21)
        assert trial.batch == 1


def test_a_batch_is_handed_out_until_it_is_told() -> None:
    loop = PooledLoop(LEVELS, 3)
    first = loop.ask()
    assert loop.ask() == first
    loop.tell(first[0].id, 1.0)
    assert loop.ask() == first[1:]
    assert len(loop.ask(more=True)) == 5


def test_a_simulation_is_called_in_batches_and_each_design_once() -> None:
    shapes: List[Any] = []
    seen: List[bytes] = []

    def simulate(points: Any) -> Any:
        shapes.append(points.shape)
        seen.extend(row.tobytes() for row in points)
        return points.sum(axis=1)

    loop = PooledLoop(MANY, 8, seed=5)
    for trial in loop.ask(simulate):
        loop.tell(trial.id, sum(trial.settings.values()))
    loop.ask(simulate)
    assert {k for _, k in shapes} == {4}
    assert max(n for n, _ in shapes) > 500 and len(shapes) < 60
    assert len(seen) == len(set(seen)) == loop.n_simulated


def test_an_exception_of_a_simulation_is_passed_on_and_changes_nothing() -> None:
    loop = after_batches(1)

    def broken(points: Any) -> Any:
        raise ZeroDivisionError("no license")

    # The first batch has simulated some designs already: only new ones are asked for.
    fresh = PooledLoop(MANY, 8)
    before = (fresh.records(), fresh.n_simulated)
    with pytest.raises(ZeroDivisionError, match="no license"):
        fresh.ask(broken)
    assert (fresh.records(), fresh.n_simulated) == before == ([], 0)
    assert loop.batch == 1


def test_a_simulation_with_too_few_answers_is_refused() -> None:
    with pytest.raises(Error, match=r"the simulation gave an array of shape \(4094,\), expected \(4095,\)"):
        PooledLoop(MANY, 8).ask(lambda points: points[:-1, 0])
    with pytest.raises(ValueError):
        PooledLoop(MANY, 8).ask(lambda points: ["a"] * len(points))


def test_nan_of_a_simulation_is_a_failure_there() -> None:
    def simulate(points: Any) -> Any:
        return np.where(points[:, 0] > 40, np.nan, simulation(points))

    loop = PooledLoop(SPRING_AND_DAMPER, 5, max_batches=2)
    loop.run(simulate, rig)
    found = loop.assess(simulate)
    assert found is not None and np.isfinite(found.recommended.mean)


def test_nan_and_exceptions_are_failures_and_infinity_is_refused() -> None:
    loop = PooledLoop(LEVELS, 4)
    ids = [trial.id for trial in loop.ask()]
    loop.tell(ids[0], np.float64("nan"))
    loop.tell(ids[1], RuntimeError("the belt slipped"))
    loop.tell(ids[2], failed="no power")
    reasons = [record.failed for record in loop.records()]
    assert reasons == ["the experiment returned nan", "RuntimeError: the belt slipped", "no power", None]
    with pytest.raises(Error, match=r"the outcome of trial 4 is inf, expected a number of magnitude at most 1e100"):
        loop.tell(ids[3], float("inf"))
    with pytest.raises(Error, match="neither a value nor a failure"):
        loop.tell(ids[3])
    with pytest.raises(Error, match="both a value and a failure"):
        loop.tell(ids[3], 1.0, failed="no power")


def test_errors_have_the_words_of_the_library() -> None:
    assert issubclass(Error, ValueError)
    loop = PooledLoop(LEVELS, 3)
    trial = loop.ask()[0]
    loop.tell(trial.id, 1.0)
    cases: Refused = [
        (lambda: loop.tell(trial.id, 2.0), "trial 1 has an outcome already, and it stands"),
        (lambda: loop.tell(99, 2.0), "trial 99 was never handed out, expected one of the outstanding trials"),
        (lambda: PooledLoop(LEVELS, 0), "setting `n_experiments` is 0, expected 1 to 1000"),
        (lambda: PooledLoop(LEVELS, 3, noise=-1.0), "setting `noise` is -1.0, expected a number from 0 to 1e100"),
        (lambda: loop.tell_at(2, {"y": 1.0}, 1.0), "settings: `y` is no parameter, expected x"),
        (
            lambda: loop.tell_at(2, {"x": 99.0}, 1.0),
            "trial 2: the actual setting of parameter `x` is 99.0, expected within half the parameter's width of its bounds",
        ),
    ]
    for call, message in cases:
        with pytest.raises(Error) as caught:
            call()
        assert str(caught.value) == message


def test_settings_really_made_count() -> None:
    loop = PooledLoop(LEVELS, 3)
    trial = loop.ask()[0]
    loop.tell_at(trial.id, {"x": 3.3}, 1.0)
    assert loop.records()[0].actual == {"x": 3.3}
    loop.correct(trial.id, 2.0)
    assert loop.records()[0].value == 2.0


def test_an_assessment_needs_a_response() -> None:
    loop = PooledLoop(LEVELS, 3)
    assert loop.assess() is None and loop.expectations([[1.0]]) is None and loop.surprises() is None


def test_the_certificate_shrinks_and_the_best_is_found() -> None:
    bounds = []
    loop = after_batches(0)
    # A quadratic explains this rig without the simulation: until 40 designs, a repeat counting half, something is held in reserve.
    for _ in range(8):
        for trial in loop.ask(simulation):
            loop.tell(trial.id, rig(trial.settings))
        found = loop.assess(simulation)
        assert found is not None
        bounds.append(found.certificate.bound)
    assert found is not None and bounds[-1] < 0.1 * bounds[0]
    grid = [(x, y) for x in np.linspace(10, 50, 21) for y in np.linspace(0, 400, 21)]
    best = min(grid, key=lambda p: rig({"spring": p[0], "damper": p[1]}))
    assert tuple(found.recommended.settings.values()) == best


def test_a_saved_campaign_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    loop = after_batches(1)
    loop.add_earlier({"spring": 33.3, "damper": 210.0}, 0.01, source="last year")
    loop.add_earlier({"spring": 12.0, "damper": 20.0}, failed="it broke", source="last year")
    batch = loop.ask(simulation)
    loop.tell(batch[0].id, rig(batch[0].settings))
    loop.tell_at(batch[1].id, [20.5, 100.0], failed="it broke")
    loop.save(tmp_path / "campaign.json")
    read = PooledLoop.load(tmp_path / "campaign.json")
    assert read.parameters == SPRING_AND_DAMPER and read.records() == loop.records()
    assert read.ask(simulation) == loop.ask(simulation) == batch[2:]
    for one in (read, loop):
        for trial in batch[2:]:
            one.tell(trial.id, rig(trial.settings))
    assert read.assess(simulation) == loop.assess(simulation)
    assert read.ask(simulation) == loop.ask(simulation)
    assert list(tmp_path.iterdir()) == [tmp_path / "campaign.json"]


def test_a_damaged_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "campaign.json"
    after_batches(1).save(path)
    text = path.read_text()
    for damage in (text[:-20], text.replace('"batch": 1', '"batch": 2', 1), text.replace('"kind"', '"sort"')):
        path.write_text(damage)
        with pytest.raises(Error):
            PooledLoop.load(path)


def test_dear_simulations_are_due(tmp_path: Path) -> None:
    loop = PooledLoop(SPRING_AND_DAMPER, 4, simulations=12, max_batches=2, seed=2)
    assert loop.ask() == []
    assert loop.due.shape[1] == 2 and 2 <= len(loop.due) <= 12
    loop.save(tmp_path / "c.json")
    assert (PooledLoop.load(tmp_path / "c.json").due == loop.due).all()
    loop.tell_simulations(loop.due, simulation(loop.due))
    assert len(loop.due) == 0 and len(loop.ask()) == 4
    assert loop.run(simulation, rig) == "batch_limit"


def test_data_frames_in_and_out() -> None:
    loop = PooledLoop(SPRING_AND_DAMPER, 5, seed=3)
    loop.ask(simulation)
    table: Any = loop.frame()
    assert list(table.columns) == ["id", "batch", "spring", "damper", "value", "failed"]
    table["value"] = [rig(dict(row)) for _, row in table[["spring", "damper"]].iterrows()]
    table.loc[1, "value"], table.loc[1, "failed"] = np.nan, "it broke"
    table.loc[2, "spring"] += 0.5
    table.loc[3, "value"] = np.nan
    bad = table.assign(id=[1, 2, 3, 4, 77])
    before = loop.records()
    with pytest.raises(Error, match="77"):
        loop.tell_frame(bad)
    assert loop.records() == before, "all or nothing"
    assert loop.tell_frame(table) == 4
    records = loop.records()
    assert records[1].failed == "it broke" and records[3].value is None
    assert records[2].actual == {"spring": table.loc[2, "spring"], "damper": table.loc[2, "damper"]}
    assert records[0].actual is None
    past = pandas.DataFrame({"damper": [100.0, 200.0], "note": ["a", "b"], "spring": [20.0, 30.0]})
    loop.add_earlier(past, [0.5, np.nan], source="last year")
    assert loop.withdraw_earlier("last year") == 2
    def simulate(table: Any) -> Any:
        return ((table["spring"] - 25) / 20) ** 2 + ((table["damper"] - 150) / 200) ** 2

    framed = infuse.with_frames(SPRING_AND_DAMPER, simulate)
    assert np.asarray(framed(np.array([[25.0, 150.0]]))).tolist() == [0.0]
    found = loop.expectations(past, framed)
    assert found is not None and found.shape == (2, 3)


def test_other_threads_run_meanwhile() -> None:
    loop, counted = after_batches(2), [0]
    done = threading.Event()

    def count() -> None:
        while not done.is_set():
            counted[0] += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    began = time.perf_counter()
    loop.assess(simulation)
    took, seen = time.perf_counter() - began, counted[0]
    done.set()
    thread.join()
    assert seen > 0.1 * took / 0.001


def test_wanted_experiments_are_handed_out() -> None:
    loop = PooledLoop(LEVELS, 3)
    trials = loop.hand_out([{"x": 2.9}, {"x": 10.0}])
    assert [trial.settings["x"] for trial in trials] == [3.0, 10.0]
    with pytest.raises(Error, match="`x`"):
        loop.hand_out([[11.0]])


def test_the_worth_ends_a_campaign() -> None:
    loop = PooledLoop(SPRING_AND_DAMPER, 6, worth=0.2, seed=1)
    assert loop.run(simulation, rig) == "not_worth_it"
    found = loop.assess(simulation)
    assert found is not None and found.certificate.bound <= 0.2 and found.further_batches == 0
    loop.change(worth=None)
    assert loop.stopped is None and len(loop.ask(simulation)) == 6


def test_by_the_surface_alone_a_campaign_ends_sooner() -> None:
    def ended(stop_by: str) -> PooledLoop:
        loop = PooledLoop(SPRING_AND_DAMPER, 6, worth=0.2, seed=1, stop_by=stop_by)
        assert loop.run(simulation, rig) == "not_worth_it"
        return loop

    loop = ended("surface")
    found = loop.assess(simulation)
    assert found is not None and found.certificate.quantile <= 0.2 and found.further_batches == 0
    assert found.certificate.bound > 0.2 and len(loop.records()) < len(ended("bound").records())
    with pytest.raises(Error, match="expected `bound` or `surface`"):
        PooledLoop(SPRING_AND_DAMPER, 6, stop_by="surfaces")


def test_a_copy_is_a_campaign_of_its_own() -> None:
    loop = after_batches(1)
    for other in (copy.copy(loop), copy.deepcopy(loop), pickle.loads(pickle.dumps(loop))):
        assert other.records() == loop.records() and other.parameters == loop.parameters
        assert other.ask(simulation) == copy.deepcopy(loop).ask(simulation)
        assert len(other.records()) > len(loop.records()), "the original is as before"


INTERRUPTED = """
import os, signal, threading, time
import infuse

loop = infuse.PooledLoop([infuse.Parameter(name, "", 0.0, 1.0, levels=21) for name in "abcdefg"], 100, particles=1000)
for trial in loop.ask():
    loop.tell(trial.id, sum(value * value for value in trial.settings.values()))
threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
began = time.perf_counter()
try:
    loop.ask()
    print("it was done before")
except KeyboardInterrupt:
    print("heard" if time.perf_counter() - began < 2.5 else "late", len(loop.outstanding()), loop.batch, flush=True)
os._exit(0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is sent otherwise there")
def test_ctrl_c_is_heard_while_rust_works_and_changes_nothing() -> None:
    found = subprocess.run([sys.executable, "-c", INTERRUPTED], check=True, capture_output=True, text=True)
    assert found.stdout == "heard 0 1\n"
