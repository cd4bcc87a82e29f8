"""What is no number: named in settings and frames, a place in the list where a row of numbers is asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, List

import numpy as np
import pandas
import pytest
from numpy.typing import NDArray

import infuse
from infuse import DissertationLoop, Parameter, PooledLoop

PARAMETERS = [Parameter("spring", "N/mm", 0.0, 10.0, levels=11), Parameter.choice("pad", ["foam", "film", "wood"])]
OFFSET = {"foam": 2.0, "film": 0.0, "wood": 5.0}


def truth(settings: Dict[str, Any]) -> float:
    return float((settings["spring"] - 7.0) ** 2 / 10.0 + OFFSET[settings["pad"]])


def simulate(points: NDArray[np.float64]) -> NDArray[np.float64]:
    offsets = np.array([2.0, 0.0, 5.0])[points[:, 1].astype(int)]
    found: NDArray[np.float64] = (points[:, 0] - 5.0) ** 2 / 10.0 + offsets
    return found


def test_the_best_choice_is_found_and_goes_by_its_name(tmp_path: Path) -> None:
    loop = PooledLoop(PARAMETERS, 8, max_batches=2)
    seen: List[str] = []
    while loop.stopped is None:
        for trial in loop.ask(simulate):
            seen.append(trial.settings["pad"])
            loop.tell(trial.id, truth(trial.settings))
    found = loop.assess(simulate)
    assert found is not None and set(seen) <= set(OFFSET)
    assert found.recommended.settings == {"spring": 7.0, "pad": "film"}
    table = loop.frame()
    assert sorted(set(table["pad"])) == sorted(set(seen))
    loop.save(tmp_path / "campaign.json")
    again = PooledLoop.load(tmp_path / "campaign.json")
    assert again.parameters == PARAMETERS and again.assess(simulate) == found
    standings = again.standings([{"spring": 7.0, "pad": "wood"}], simulate)
    assert standings is not None and standings[0].mean > 2.0


def test_data_frames_hold_names() -> None:
    def of_frame(frame: "pandas.DataFrame") -> "pandas.Series[Any]":
        return frame["spring"] + frame["pad"].map(OFFSET)

    named = infuse.with_frames(PARAMETERS, of_frame)
    assert np.asarray(named(np.array([[1.0, 2.0], [4.0, 1.0]]))).tolist() == [6.0, 4.0]
    loop = PooledLoop(PARAMETERS, 6)
    loop.add_earlier(pandas.DataFrame({"spring": [1.0, 2.0], "pad": ["film", "wood"]}), [3.6, 7.5])
    with pytest.raises(infuse.Error, match="`pad` is 'iron', expected one of foam, film, wood"):
        loop.add_earlier({"spring": 1.0, "pad": "iron"}, 1.0)


def test_what_needs_numbers_refuses_choices() -> None:
    with pytest.raises(infuse.Error, match="pad"):
        DissertationLoop(PARAMETERS, "linear", 6, 8)
    with pytest.raises(infuse.Error, match="pad"):
        infuse.doe.search(PARAMETERS, 8)
