"""Batch prediction over 24^4 points from 54 data with numpy and scipy, then the Rust bench of the same task.

Each task is written twice: with scipy's distance matrix, and in slices that stay in the cache. scipy computes the
distances in one thread; numpy's matrix products are held to one thread as well.

    python3 crates/surface/benches/batch_numpy.py
"""

import os

for variable in ["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"]:
    os.environ[variable] = "1"

import itertools
import subprocess
import sys
import time

import numpy as np
import scipy
from scipy.spatial.distance import cdist

N_FACTORS, N_DATA, SCALE, REPEATS, SLICE = 4, 54, 1.5, 7, 512


def timed(function, x):
    start = time.perf_counter()
    function(x)
    return time.perf_counter() - start


def main():
    axis = np.linspace(-1.0, 1.0, 24)
    points = np.array(list(itertools.product(axis, repeat=N_FACTORS)))
    step = np.array([0.8566748838545029, 0.733891856627126, 0.6287067210413388, 0.5385972500655])
    data = 2.0 * np.modf((np.arange(N_DATA)[:, None] + 0.5) * step)[0] - 1.0
    values = 1.0 + data[:, 0] * data[:, 1] + np.sin(data[:, 2]) + data[:, 3] ** 2
    pairs = [(i, j) for i in range(N_FACTORS) for j in range(i, N_FACTORS)]

    def regressors(x):
        return np.column_stack([np.ones(len(x)), x] + [x[:, i] * x[:, j] for i, j in pairs])

    coefficients = np.linalg.lstsq(regressors(data), values, rcond=None)[0]

    def average(omega):
        return (omega @ values) / omega.sum(axis=1)

    def inverse_distance(x):
        return average(1.0 / cdist(x, data, "sqeuclidean"))

    def squared_exponential(x):
        return average(np.exp(-SCALE * SCALE * cdist(x, data, "sqeuclidean")))

    def regression(x):
        return regressors(x) @ coefficients

    def sliced(function):
        return lambda x: np.concatenate([function(x[i : i + SLICE]) for i in range(0, len(x), SLICE)])

    print(f"numpy {np.__version__}, scipy {scipy.__version__}, one thread, {len(points)} points, {N_DATA} data")
    for function in [inverse_distance, squared_exponential, regression]:
        for name, variant in [("whole", function), (f"slices of {SLICE}", sliced(function))]:
            times = []
            for _ in range(REPEATS):
                times.append(timed(variant, points))
            fastest, median = min(times), sorted(times)[REPEATS // 2]
            print(
                f"{function.__name__:20} {name:14} fastest {1e3 * fastest:7.2f} ms, median {1e3 * median:7.2f} ms, "
                f"{len(points) / median / 1e6:6.2f} Mpoint/s"
            )
        part = points[:2048]
        fastest = min(timed(function, part) for _ in range(300))
        print(f"{function.__name__:20} {'2048 points':14} fastest {1e6 * fastest:7.1f} us, {2048 / fastest / 1e6:6.2f} Mpoint/s")
    sys.stdout.flush()
    subprocess.run(["cargo", "bench", "-p", "infuse-surface", "--bench", "batch"], check=True)


if __name__ == "__main__":
    main()
