"""A campaign that a person could run: the turbine's numerical model, and its stand-in for the water channel as the rig."""

from __future__ import annotations

import infuse
from infuse import Parameter, flights

PARAMETERS = [
    Parameter("center_of_mass", "% chord", 43.0, 53.0, levels=21),
    Parameter("pitch_set_point", "deg", 6.0, 16.0, levels=21),
]


def main() -> None:
    names = [parameter.name for parameter in PARAMETERS]
    channel = flights.Channel()
    simulate = channel.simulator(names)
    rig = channel.simulator(names, fidelity="stand-in")
    loop = infuse.PooledLoop(PARAMETERS, n_experiments=8, max_batches=3, seed=1)
    while trials := loop.ask(simulate):
        for trial in trials:
            loop.tell(trial.id, rig(trial.settings)[0])
        found = loop.assess(simulate)
        if found is not None:
            best, bound = found.recommended, found.certificate
            print(f"batch {loop.batch}: {best.settings} at {best.mean:.3f} s; with {bound.probability:.0%} no design is "
                  f"better by more than {bound.bound:.3f} s")


if __name__ == "__main__":
    main()
