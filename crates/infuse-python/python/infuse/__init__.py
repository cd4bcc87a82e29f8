"""Experimentally infused optimization: a wrong model, few experiments, and a loop that corrects the one by the other.

`PooledLoop` says which experiments to run next, which design to build, and how much better another may be.
`DissertationLoop` is the loop of Deodhar's dissertation. `infuse.doe` finds optimal designs, `infuse.surface` fits
response surfaces, `infuse.flights` flies the tethered turbine of the case study. The work is done by the Rust libraries
of the same names; the same seed gives the same bits here and there.

>>> import infuse
>>> loop = infuse.PooledLoop(
...     [
...         infuse.Parameter("spring", "N/mm", 10.0, 50.0, levels=21),
...         infuse.Parameter("damper", "N s/m", 0.0, 400.0, levels=21),
...     ],
...     n_experiments=8,
...     max_batches=3,
... )
>>> def simulate(points):  # many designs at once, a row each
...     return ((points[:, 0] - 25) / 20) ** 2 + ((points[:, 1] - 150) / 200) ** 2
>>> def rig(settings):  # the best is elsewhere
...     return ((settings["spring"] - 34) / 20) ** 2 + ((settings["damper"] - 220) / 200) ** 2
>>> loop.run(simulate, rig)
'batch_limit'
>>> loop.assess(simulate).recommended.settings
{'spring': 34.0, 'damper': 220.0}
"""

from infuse import doe, flights, surface
from infuse._native import Error, __version__
from infuse._parameters import Parameter, Settings, with_frames
from infuse.dissertation import Assessment as DissertationAssessment
from infuse.dissertation import Loop as DissertationLoop
from infuse.dissertation import Outlook, RegretBound
from infuse.pooled import (
    Assessment,
    Certificate,
    Constrained,
    Constraint,
    Contradiction,
    Doubted,
    Drift,
    LinearConstraint,
    Needed,
    Outlier,
    Plants,
    PooledLoop,
    Registration,
    Shift,
    SimulationWorth,
    Standing,
)
from infuse.trials import Record, Trial

__all__ = [
    "Assessment",
    "Certificate",
    "Constrained",
    "Constraint",
    "Contradiction",
    "DissertationAssessment",
    "DissertationLoop",
    "Doubted",
    "Drift",
    "Error",
    "LinearConstraint",
    "Needed",
    "Outlier",
    "Outlook",
    "Parameter",
    "Plants",
    "PooledLoop",
    "Record",
    "RegretBound",
    "Settings",
    "Registration",
    "Shift",
    "SimulationWorth",
    "Standing",
    "Trial",
    "__version__",
    "doe",
    "flights",
    "surface",
    "with_frames",
]
