"""What several tests share."""

from __future__ import annotations

import json
import os
import subprocess
from typing import Any, Callable, Dict, List, Tuple

import numpy as np
import pytest

import infuse
from infuse import Parameter

Refused = List[Tuple[Callable[[], object], str]]

SPRING_AND_DAMPER = [
    Parameter("spring", "N/mm", 10.0, 50.0, levels=21),
    Parameter("damper", "N s/m", 0.0, 400.0, levels=21),
]


def simulation(points: "np.ndarray[Any, np.dtype[np.float64]]") -> "np.ndarray[Any, np.dtype[np.float64]]":
    x, y = (points[:, 0] - 25.0) / 20.0, (points[:, 1] - 150.0) / 200.0
    return np.asarray(x * x + y * y)


def rig(settings: infuse.Settings) -> float:
    x, y = (settings["spring"] - 34.0) / 20.0, (settings["damper"] - 220.0) / 200.0
    return float(x * x + y * y + 0.25 * x * y)


@pytest.fixture(scope="session")
def rust() -> Dict[str, Any]:
    """What the example `same_bits` of this crate prints; `SAME_BITS` says where that program is."""
    program = os.environ.get("SAME_BITS")
    if program is None:
        pytest.skip("SAME_BITS does not name the program of `cargo build --release -p infuse-python --example same_bits`")
    found: Dict[str, Any] = json.loads(subprocess.run([program], check=True, capture_output=True).stdout)
    return found
