"""The package as it is imported."""

from __future__ import annotations

import subprocess
import sys

import infuse

WITHOUT_PANDAS = """
import sys
sys.modules["pandas"] = None
import infuse
loop = infuse.PooledLoop([infuse.Parameter("x", "mm", 0.0, 10.0, levels=11)], n_experiments=3)
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
