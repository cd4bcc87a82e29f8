#!/usr/bin/env python3
"""The same amplifier by the formulas of a textbook: formula.py TRANSISTOR COLLECTOR EMITTER CAPACITOR BIAS

Ohm, ohm, pF and V. The transistor has 0.65 V from base to emitter, no base current, a transconductance of I / 26 mV,
and of its capacitances only the one from collector to base, as the data sheets say it.
"""

import json
import math
import sys

COLLECTOR_BASE = {"2N3904": 4e-12, "BC547B": 1.7e-12, "2N2222A": 8e-12}
SOURCE, FOOT, LOAD, PROBE, SUPPLY = 200.0, 150.0, 10e3, 10e-12, 9.0


def stage(transistor, collector, emitter, capacitor, bias):
    """The gain as a function of the frequency in Hz, the current in A, and the voltage left over the transistor in V."""
    current = (bias - 0.65) / (emitter + FOOT)
    left = SUPPLY - current * (collector + emitter + FOOT)

    def gain(frequency):
        s = 2j * math.pi * frequency
        output = 1.0 / (1.0 / collector + 1.0 / LOAD + s * (PROBE + COLLECTOR_BASE[transistor]))
        degeneration = 1.0 / (1.0 / emitter + s * capacitor * 1e-12)
        inner = output / (0.026 / current + degeneration)
        miller = 1.0 + s * SOURCE * COLLECTOR_BASE[transistor] * (1.0 + inner)
        return abs(inner / miller)

    return gain, current, left


def main():
    gain, current, left = stage(sys.argv[1], *map(float, sys.argv[2:6]))
    if current <= 0.0 or left < 0.3:
        print(json.dumps({"failed": "saturated"}))
        return
    low = gain(1e5)
    frequencies = [1e5 * 10.0 ** (k / 40.0) for k in range(161)]
    gains = [gain(frequency) for frequency in frequencies]
    last = max((k for k in range(161) if gains[k] >= low / math.sqrt(2.0)))
    if last == 160:
        print(json.dumps({"failed": "no upper end of the band below 1 GHz"}))
        return
    share = (gains[last] - low / math.sqrt(2.0)) / (gains[last] - gains[last + 1])
    band = frequencies[last] + share * (frequencies[last + 1] - frequencies[last])
    peaking = 20.0 * math.log10(max(gains) / low)
    print(json.dumps({"value": band / 1e6, "gain": low, "peaking": peaking, "current": current * 1e3}))


if __name__ == "__main__":
    main()
