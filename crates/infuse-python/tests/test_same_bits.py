"""The same seed gives the same bits in Rust and in Python: every comparison is of equality."""

from __future__ import annotations

from typing import Any, Dict

import numpy as np

import infuse
from conftest import SPRING_AND_DAMPER, rig, simulation
from infuse import doe, flights, surface


def test_pooled_campaign(rust: Dict[str, Any]) -> None:
    def experiment(settings: infuse.Settings) -> float:
        return float("nan") if settings["damper"] > 380.0 else rig(settings)

    loop = infuse.PooledLoop(SPRING_AND_DAMPER, 6, max_batches=3, seed=7)
    assert loop.run(simulation, experiment) == "batch_limit"
    assert [list(record.settings.values()) for record in loop.records()] == rust["pooled"]["points"]
    assert any(record.failed for record in loop.records())
    found, expected = loop.assess(simulation), rust["pooled"]["assessment"]
    assert found is not None and found.simulation is not None
    assert list(found.recommended.settings.values()) == expected["recommended"]["point"]
    for name in ("mean", "deviation", "n_readings", "feasible"):
        assert getattr(found.recommended, name) == expected["recommended"][name]
    assert vars(found.certificate) == expected["certificate"]
    assert vars(found.simulation) == expected["simulation"]
    assert (found.noise, found.left) == (expected["noise"], expected["left"])


def test_global_campaign(rust: Dict[str, Any]) -> None:
    loop = infuse.DissertationLoop(SPRING_AND_DAMPER, "quadratic", 9, 12, max_batches=2, seed=7)
    loop.run(simulation, rig)
    assert loop.reports() == rust["global"]


def test_design(rust: Dict[str, Any]) -> None:
    found = doe.search(2, 8, criterion="I", starts=20, seed=3)
    assert found.runs.ravel().tolist() == rust["design"]["runs"]
    assert found.efficiency == rust["design"]["percent"]


def test_surfaces(rust: Dict[str, Any]) -> None:
    points = np.array([i * 7 % 23 / 11.5 - 1.0 for i in range(24)]).reshape(-1, 2)
    values = points[:, 0] * points[:, 0] - points[:, 1]
    at, expected = [[0.3, -0.4]], rust["surfaces"]
    assert surface.InverseDistance(points, values, power=3.0)(at)[0] == expected["inverse distance"]
    assert surface.SquaredExponential(points, values)(at)[0] == expected["squared exponential"]
    mean, variance = surface.GaussianProcess(points, values, seed=5).predict(at)
    assert [mean[0], variance[0]] == expected["process"]


def test_flights(rust: Dict[str, Any]) -> None:
    designs = [[45.7, 8.29], [47.0, 10.0], [50.0, 12.5]]
    found = flights.Channel().fly(designs, ["center_of_mass", "pitch_set_point"], fidelity="stand-in")
    assert found.cost.tolist() == rust["flights"]
