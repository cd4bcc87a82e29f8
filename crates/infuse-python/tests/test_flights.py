"""Flights in batches."""

from __future__ import annotations

from pathlib import Path
from typing import List

import numpy as np
import pytest

from conftest import Refused
from infuse import Error, flights

FIXTURES = Path(__file__).parents[3] / "fixtures" / "bat"
VARIABLES = ["center_of_mass", "pitch_set_point"]


def test_row_0_of_table_5_costs_what_the_shell_says() -> None:
    # `cargo run --release -p water-channel --example design_cost` prints both with nine decimals.
    for fidelity, cost in [("numerical", 1.312213858), ("stand-in", 2.771276470)]:
        found = flights.Channel().fly([45.7, 8.29], VARIABLES, fidelity=fidelity)
        assert round(found.cost[0], 9) == cost


def test_the_cost_is_the_quadratic_form_of_its_weights() -> None:
    found = flights.Channel().fly([[45.7, 8.29], [50.0, 12.0]], VARIABLES)
    weights = [float(line.split("value = ")[1].split(",")[0]) for line in weight_lines()]
    k, k7 = np.array(weights[:6]), weights[6]
    ballast = found.terms[:, 6]
    np.testing.assert_allclose(np.einsum("i,nij,j->n", k, found.gram, k) + ballast, found.cost, rtol=1e-12)
    np.testing.assert_allclose(found.terms.sum(axis=1), found.cost, rtol=1e-14)
    assert k7 == 0.0 or (ballast > 0).all()


def weight_lines() -> List[str]:
    lines = (FIXTURES / "cost-chapter7.toml").read_text().splitlines()
    return [line for line in lines if line.startswith("k") and not line.startswith("k8")]


def test_files_and_numbers_of_the_plant() -> None:
    shipped = flights.Channel().fly([[0.457, 1.0]], ["body.center_of_mass_x", "horizontal_stabilizer.area_factor"])
    read = flights.Channel(FIXTURES / "rig.toml", FIXTURES / "test-profile.toml", FIXTURES / "cost-chapter7.toml")
    assert read.fly([[45.7, 1.0]], ["center_of_mass", "horizontal_area"]).cost[0] == pytest.approx(shipped.cost[0], rel=1e-12)


def test_company_changes_no_bit_and_a_failure_spoils_nobody() -> None:
    designs = np.array([[45.7, 8.29], [99.0, 8.29], [50.0, 12.0]])
    together = flights.Channel().fly(designs, VARIABLES)
    assert np.isnan(together.cost).tolist() == [False, True, False]
    assert together.reasons[1] and together.reasons[0] is None
    for row in (0, 2):
        assert flights.Channel().fly(designs[row], VARIABLES).cost[0] == together.cost[row]
    assert flights.Channel().simulator(VARIABLES)(designs)[2] == together.cost[2]


def test_what_is_wrong_is_said() -> None:
    channel = flights.Channel()
    cases: Refused = [
        (lambda: channel.fly([[1.0]], VARIABLES), "a design has 1 numbers, expected 2"),
        (lambda: channel.fly([[1.0]], ["mass"]), "variable `mass`"),
        (lambda: channel.fly([[1.0]], VARIABLES[:1], fidelity="real"), "fidelity is `real`"),
        (lambda: channel.fly([[1.0]], VARIABLES[:1], steps_per_sample=0), "steps per sample = 0"),
        (lambda: flights.Channel(rig="absent.toml"), "absent.toml"),
    ]
    for call, message in cases:
        with pytest.raises(Error, match=message):
            call()
