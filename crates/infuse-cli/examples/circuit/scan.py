#!/usr/bin/env python3
"""All designs of campaign.toml on the bench, without noise: scan.py > truth.csv. One ngspice per 2,000 designs."""

import itertools
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import bench

GRID = {
    "collector": range(150, 651, 50),
    "emitter": range(20, 101, 10),
    "capacitor": range(0, 401, 25),
    "bias": [round(1.2 + 0.1 * k, 1) for k in range(15)],
}


def block(design):
    """A transistor, a collector resistor and an emitter resistor, with all that is turned."""
    transistor, collector, emitter = design
    turned = list(itertools.product(GRID["capacitor"], GRID["bias"]))
    lines = []
    for number, (capacitor, bias) in enumerate(turned):
        lines += [f"echo design {number}", f"alter Cp = {capacitor}p", f"alter Vbias = {bias}", bench.ANALYSIS, "destroy all"]
    values = bench.parts(transistor, collector, emitter, 1, 1, 0)
    deck = bench.filled(values, "\n".join(lines))
    done = subprocess.run(["ngspice", "-b"], input=deck, text=True, capture_output=True)
    texts = re.split(r"^design (\d+)$", done.stdout.lower(), flags=re.M)[1:]
    rows = []
    for number, text in zip(texts[::2], texts[1::2]):
        found = bench.answer(bench.measured(text), 1.0)
        numbers = [found.get(name, "") for name in ("value", "gain", "peaking", "current", "failed")]
        rows.append([transistor, collector, emitter, *turned[int(number)], *numbers])
    assert len(rows) == len(turned), done.stderr[-500:]
    return rows


def main():
    print("transistor,collector,emitter,capacitor,bias,band,gain,peaking,current,failed")
    blocks = itertools.product(["2N3904", "BC547B", "2N2222A"], GRID["collector"], GRID["emitter"])
    with ThreadPoolExecutor(2) as pool:
        for rows in pool.map(block, blocks):
            for row in rows:
                print(*row, sep=",")


if __name__ == "__main__":
    sys.exit(main())
