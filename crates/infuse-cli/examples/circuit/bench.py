#!/usr/bin/env python3
"""The amplifier in ngspice, with parts as they come out of the drawer: bench.py TRANSISTOR COLLECTOR EMITTER CAPACITOR BIAS RUN

Ohm, ohm, pF and V. RUN draws the tolerances of the parts and the error of the reading; run 0 has neither.
The last line is what `infuse` reads.
"""

import json
import math
import pathlib
import random
import re
import subprocess
import sys

DECK = (pathlib.Path(__file__).parent / "stage.cir").read_text()
ANALYSIS = """op
print -i(Vcc) v(c)-v(e)
ac dec 40 100k 1g
let m = mag(v(out))
meas ac low find m at=100k
meas ac top max m
let edge = low/sqrt(2)
meas ac band when m=$&edge fall=last
"""


def parts(transistor, collector, emitter, capacitor, bias, run):
    """What is soldered in: resistors 1 %, capacitors 5 %, the transistor's current at a given voltage 15 %."""
    drawn = random.Random(run)
    off = lambda share: 1.0 if run == 0 else 1.0 + share * drawn.gauss(0.0, 1.0) / 2.0
    return {
        "transistor": transistor,
        "collector": float(collector) * off(0.01),
        "emitter": float(emitter) * off(0.01),
        "capacitor": float(capacitor) * off(0.05),
        "bias": float(bias) * off(0.005),
        "foot": 150.0 * off(0.01),
        "load": 10.0 * off(0.05),
        "area": off(0.15),
        "reading": off(0.02),
    }


def filled(values, analysis):
    """The netlist of these parts."""
    deck = DECK
    for name, value in (values | {"analysis": analysis}).items():
        deck = deck.replace("{" + name + "}", str(value))
    return deck


def measured(printed):
    """Numbers by name, of what ngspice printed."""
    return {name: float(value) for name, value in re.findall(r"^([-\w()]+)\s+=\s+([-+\d.e]+)", printed, re.M)}


def answer(found, reading):
    """What the bench says: a value with its constraints, or why there is none."""
    if found.get("v(c)-v(e)", 0.0) < 0.3:
        return {"failed": "saturated: no undistorted sine at the output"}
    if "band" not in found or found["low"] <= 0.0:
        return {"failed": "no upper end of the band"}
    return {
        "value": found["band"] * reading / 1e6,
        "gain": found["low"] * math.sqrt(reading),
        "peaking": 20.0 * math.log10(found["top"] / found["low"]),
        "current": found["-i(vcc)"] * 1e3,
    }


def main():
    values = parts(*sys.argv[1:6], int(sys.argv[6]))
    done = subprocess.run(["ngspice", "-b"], input=filled(values, ANALYSIS), text=True, capture_output=True, timeout=60)
    if re.search(r"singular matrix|no convergence|timestep too small|aborted", done.stdout + done.stderr, re.I):
        print(json.dumps({"failed": "ngspice did not converge"}))
        return
    print(json.dumps(answer(measured(done.stdout.lower()), values["reading"])))


if __name__ == "__main__":
    main()
