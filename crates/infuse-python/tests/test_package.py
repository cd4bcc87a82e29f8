"""The package as it is imported."""

from __future__ import annotations

import importlib.metadata
import subprocess
import sys
from pathlib import Path

import pytest

import infuse

WITHOUT_PANDAS = """
import sys
sys.modules["pandas"] = None
import infuse
loop = infuse.PooledLoop([infuse.Parameter("x", "mm", 0.0, 10.0, levels=11)], n_experiments=5)
for trial in loop.ask():
    loop.tell(trial.id, trial.settings["x"])
assert loop.assess().recommended.settings == {"x": 0.0}, loop.assess()
try:
    loop.frame()
except ImportError:
    print("no frames")
"""


def test_pandas_is_needed_for_data_frames_alone() -> None:
    found = subprocess.run([sys.executable, "-c", WITHOUT_PANDAS], check=True, capture_output=True, text=True)
    assert found.stdout == "no frames\n"


def test_importing_it_imports_nothing_large_but_numpy() -> None:
    code = "import sys, infuse; print(sorted({'pandas', 'scipy', 'matplotlib', 'sklearn'} & set(sys.modules)))"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert found.stdout == "[]\n"


def test_the_version_is_that_of_the_crate() -> None:
    assert infuse.__version__ == "0.1.0"
    assert all(hasattr(infuse, name) for name in infuse.__all__)


def test_the_wheel_carries_the_licenses_of_all_that_it_contains() -> None:
    try:
        found = importlib.metadata.files("infuse-bat") or []
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("there is no wheel: the library was put in place as it was compiled")
    kept = {path.name: path for path in found if "licenses" in path.parts}
    for name in ("LICENSE", "THIRD-PARTY-LICENSES.txt"):
        text = (Path(__file__).parents[3] / name).read_text(encoding="utf-8")
        assert kept[name].read_text(encoding="utf-8") == text
