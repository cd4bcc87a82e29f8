"""The loop of the dissertation by ask and tell."""

from __future__ import annotations

from pathlib import Path
from typing import Any, List

import numpy as np
import pytest

import infuse
from conftest import SPRING_AND_DAMPER, rig, simulation
from infuse import Error, DissertationLoop


def test_the_best_cell_is_found_and_the_rest_dropped() -> None:
    loop = DissertationLoop(SPRING_AND_DAMPER, "quadratic", 9, 12, max_batches=4, seed=2, first_screening=2)
    assert loop.run(simulation, rig) in ("the limit on the batches was reached", "fewer than two cells are left")
    found = loop.assess()
    assert found is not None and found.n_left < 441
    # Both are quadratic, so the correction is exact but for its gain.
    assert rig(found.optimum) < 0.1 < rig(found.simulation_optimum)
    assert found.left == pytest.approx(found.n_left / 441)


def test_all_simulations_of_a_batch_are_one_call() -> None:
    shapes: List[Any] = []

    def simulate(points: Any) -> Any:
        shapes.append(points.shape)
        return simulation(points)

    loop = DissertationLoop(SPRING_AND_DAMPER, "quadratic", 9, 12, seed=2)
    loop.ask(simulate)
    loop.ask(simulate)
    assert shapes == [(12, 2)]


def test_an_exception_of_a_simulation_is_passed_on() -> None:
    def broken(points: Any) -> Any:
        raise KeyError("no license")

    loop = DissertationLoop(SPRING_AND_DAMPER, "quadratic", 9, 12)
    with pytest.raises(KeyError):
        loop.ask(broken)
    assert loop.outstanding() == [] and len(loop.ask(simulation)) == 9


def test_simulations_that_all_fail_are_an_error() -> None:
    loop = DissertationLoop(SPRING_AND_DAMPER, "quadratic", 9, 12)
    with pytest.raises(Error, match="all 12 simulations failed, the first at"):
        loop.ask(lambda points: np.full(len(points), np.nan))


def test_a_saved_campaign_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    loop = DissertationLoop(SPRING_AND_DAMPER, [[0, 0], [1, 0], [0, 1], [2, 0], [0, 2]], 8, 12, max_batches=3)
    for trial in loop.ask(simulation):
        loop.tell(trial.id, rig(trial.settings))
    batch = loop.ask(simulation)
    loop.tell_at(batch[0].id, {"spring": 30.0, "damper": 205.0}, 0.1)
    loop.save(tmp_path / "c.json")
    read = DissertationLoop.load(tmp_path / "c.json")
    assert read.outstanding() == loop.outstanding() and read.settings == loop.settings
    for one in (read, loop):
        one.run(simulation, rig)
    assert read.reports() == loop.reports() and read.assess() == loop.assess()
    with pytest.raises(Error, match='a campaign of kind "global" and format 1, expected "pooled" and 2'):
        infuse.PooledLoop.load(tmp_path / "c.json")


def test_settings_are_those_of_the_library() -> None:
    loop = DissertationLoop(SPRING_AND_DAMPER, "linear", 6, 8, careful=True, correction={"gain": "harmonic"})
    assert loop.settings["careful"] is True and loop.settings["correction"]["gain"] == "harmonic"
    with pytest.raises(Error, match="unknown field `carefull`"):
        DissertationLoop(SPRING_AND_DAMPER, "linear", 6, 8, carefull=True)
    with pytest.raises(Error, match="setting `confidence` is 1.5, expected 0.5 < confidence < 1"):
        DissertationLoop(SPRING_AND_DAMPER, "linear", 6, 8, confidence=1.5)


def test_data_frames_in_and_out() -> None:
    loop = DissertationLoop(SPRING_AND_DAMPER, "quadratic", 9, 12, max_batches=1)
    loop.ask(simulation)
    table: Any = loop.frame()
    table["value"] = [rig({"spring": row.spring, "damper": row.damper}) for row in table.itertuples()]
    assert loop.tell_frame(table) == 9
    assert loop.batch == 1 and list(loop.frame()["value"]) == list(table["value"])
