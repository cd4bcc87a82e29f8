"""Flights of the tethered turbine of the case study, many at once.

The rig, its test and the weights of its cost are those of Chapter 7 of the dissertation, unless files say otherwise.
Every number is synthetic: the stand-in for the water channel is the same equations with stall and added mass.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import List, Optional, Sequence, Union

import numpy as np

from infuse import _native
from infuse._checks import twice, whole, word, words
from infuse._parameters import Designs, Floats, Names, rows

TERM_NAMES = ("heading", "pitch", "roll", "altitude", "reel speed", "zenith", "ballast")
"""Names of the terms of the cost (21)."""

Path = Union[str, "os.PathLike[str]"]


@dataclass(frozen=True)
class Flights:
    """What n flights left; NaN where a flight has no result."""

    cost: Floats
    """J of (60), in s: n."""
    terms: Floats
    """What each of `TERM_NAMES` contributes to it, in s: n × 7."""
    gram: Floats
    """Integrals over time of all products of the first six terms without weights, SI units and radians: n × 6 × 6."""
    heading_squared: Floats
    """Integral of the squared heading, rad² s: n."""
    lateral_squared: Floats
    """Integral of the squared lateral position, m² s: n."""
    duration_s: Floats
    """How long the cost was counted, s: n."""
    reasons: List[Optional[str]]
    """Why a flight has no result."""


class Channel:
    """The rig with its test and its cost.

    A variable is `center_of_mass` (% chord), `pitch_set_point` (deg), `horizontal_area`, `vertical_area` (factors), or any
    number of the plant as `section.key` of the rig's file, in SI units and radians. `fidelity` is `numerical`, `stalled`,
    `added mass` or `stand-in`.

    >>> channel = Channel()
    >>> flights = channel.fly([[45.7, 8.29], [99.0, 8.29]], ["center_of_mass", "pitch_set_point"])
    >>> flights.cost.round(3)
    array([1.312,   nan])
    >>> flights.reasons[1]
    'line starboard went slack at t = 0 s: its tension would be -0.2555 N, allowed: zero or more'
    """

    def __init__(
        self, rig: Optional[Path] = None, profile: Optional[Path] = None, cost: Optional[Path] = None
    ) -> None:
        files = [None if path is None else os.fspath(path) for path in (rig, profile, cost)]
        self._channel = _native.Channel(*files)

    def fly(
        self,
        designs: Designs,
        variables: Sequence[str],
        *,
        fidelity: str = "numerical",
        steps_per_sample: int = 1,
    ) -> Flights:
        """Flies every design, a row with one number per variable, side by side on all cores.

        Dictionaries and data frames go by the names of the variables, and have no others.

        >>> designs = [{"pitch_set_point": 8.29, "center_of_mass": 45.7}]
        >>> Channel().fly(designs, ["center_of_mass", "pitch_set_point"]).cost.round(3)
        array([1.312])
        """
        names = _names(variables)
        points = rows(names, designs, others=False)
        steps = whole("`steps_per_sample`", steps_per_sample)
        return Flights(**self._channel.fly(points, names, word("`fidelity`", fidelity), steps))

    def simulator(self, variables: Sequence[str], *, fidelity: str = "numerical") -> "Simulator":
        """The costs alone, as a simulation for the loops."""
        return Simulator(self, list(_names(variables)), fidelity)


@dataclass(frozen=True)
class Simulator:
    """Designs in, costs out."""

    channel: Channel
    variables: List[str]
    fidelity: str

    def __call__(self, points: Designs) -> Floats:
        """n × k settings to n costs, NaN where a flight has none; data frames go by name."""
        costs: Floats = self.channel.fly(points, self.variables, fidelity=self.fidelity).cost
        return np.ascontiguousarray(costs)


def _names(variables: Sequence[str]) -> Names:
    names = words("`variables`", variables, "a list of names")
    again = twice(names)
    if again is not None:
        raise _native.Error(f"variable `{again}` comes twice, expected each once")
    return Names.of(names)
