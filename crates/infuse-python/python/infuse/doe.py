"""Optimal designs: which runs to make when every run costs a day.

Points are coded: -1 and 1 are the bounds of each factor. `Design.natural` gives them in units.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple, Union

from numpy.typing import ArrayLike

from infuse import _native
from infuse._parameters import Floats, Parameter, matrix, tuples_of

if TYPE_CHECKING:
    import pandas

Model = Union[str, Sequence[Sequence[int]]]
"""`"linear"`, `"additive quadratic"`, `"quadratic"`, or a list with the exponents of each term."""
Factors = Union[int, Sequence[Parameter], Sequence[Optional[int]]]
"""So many continuous factors; or parameters, whose levels count; or the number of levels of each, `None` for continuous."""


@dataclass(frozen=True)
class Design:
    """The best design that a search found."""

    runs: Floats
    """n × k, coded."""
    criterion: str
    efficiency: float
    """Per cent, by the criterion, over the set that `sentence` names."""
    sentence: str
    stop: str
    """Why the search ended: `starts done`, `time limit` or `target reached`."""
    starts: int
    times_found: int
    """Starts that came within one part in a million of the best."""
    parameters: Optional[List[Parameter]] = field(default=None, repr=False)

    def natural(self) -> Floats:
        """n × k, in the units of the parameters."""
        if self.parameters is None:
            raise _native.Error("a design over numbers of levels has no units: search it over parameters")
        return natural(self.parameters, self.runs)

    def frame(self) -> "pandas.DataFrame":
        """The runs in units, as a data frame."""
        import pandas

        return pandas.DataFrame(self.natural(), columns=[one.name for one in self.parameters or ()])


def _axes(factors: Factors) -> List[Optional[int]]:
    if isinstance(factors, int):
        return [None] * factors
    choice = next((one.name for one in factors if isinstance(one, Parameter) and one.choices is not None), None)
    if choice is not None:
        raise _native.Error(f"factor `{choice}` has choices, expected numbers")
    return [one.levels if isinstance(one, Parameter) else one for one in factors]


def _model(model: Model) -> Union[str, List[List[int]]]:
    return model if isinstance(model, str) else [list(term) for term in model]


def search(
    factors: Factors,
    runs: int,
    *,
    model: Model = "quadratic",
    criterion: str = "G",
    seed: int = 1,
    starts: int = 200,
    time_limit_s: Optional[float] = None,
    target_percent: Optional[float] = None,
    thorough: bool = True,
    replicates: Optional[int] = None,
    fixed: Optional[ArrayLike] = None,
) -> Design:
    """A design of so many runs for a model, good by a criterion: D, A, G, E, T or I.

    The same seed and number of starts give the same design on any number of threads. `fixed` runs (coded) come first and
    count in `runs`; `replicates` of the others are second runs.

    >>> design = search(2, 8, starts=50)
    >>> design.runs.shape, round(design.efficiency, 2)
    ((8, 2), 87.94)
    >>> search(2, 5)
    Traceback (most recent call last):
    infuse.Error: 5 runs cannot determine 6 terms, expected at least 6 runs
    """
    options = {
        "seed": seed,
        "starts": starts,
        "time_limit_s": time_limit_s,
        "target_percent": target_percent,
        "thorough": thorough,
        "replicates": replicates,
    }
    kept = None if fixed is None else matrix(fixed)
    found = _native.search(_axes(factors), _model(model), runs, criterion, kept, options)
    parameters = None
    if not isinstance(factors, int):
        given = [one for one in factors if isinstance(one, Parameter)]
        parameters = given if len(given) == len(factors) else None
    return Design(
        runs=found["runs"],
        criterion=criterion,
        efficiency=found["percent"],
        sentence=found["sentence"],
        stop=found["stop"],
        starts=found["starts"],
        times_found=found["times_found"],
        parameters=parameters,
    )


def efficiency(
    runs: ArrayLike, *, model: Model = "quadratic", criterion: str = "G", factors: Optional[Factors] = None
) -> float:
    """Efficiency of any design in per cent; predictions are asked for in the cube, or over the levels of `factors`.

    >>> round(efficiency([[-1.0], [0.0], [1.0]]), 6)
    100.0
    """
    points = matrix(runs)
    axes = _axes(points.shape[1] if factors is None else factors)
    return _native.efficiency(points, axes, _model(model), criterion)[0]


def evaluate(
    runs: ArrayLike, *, model: Model = "quadratic", factors: Optional[Factors] = None
) -> Tuple[Dict[str, Any], str]:
    """All that is known of a design: a dictionary, and a table to print.

    >>> found, table = evaluate([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]], model="linear")
    >>> found["precision"]["leverages"]
    [0.75, 0.75, 0.75, 0.75]
    """
    points = matrix(runs)
    chosen: Factors = points.shape[1] if factors is None else factors
    names = [] if isinstance(chosen, int) else [one.name for one in chosen if isinstance(one, Parameter)]
    text, table = _native.evaluate(points, _axes(chosen), _model(model), names)
    found: Dict[str, Any] = json.loads(text)
    return found, table


def regressor(points: ArrayLike, *, model: Model = "quadratic") -> Floats:
    """The terms of a model at coded points: n × p.

    >>> regressor([[0.5, -1.0]], model="linear")
    array([[ 1. ,  0.5, -1. ]])
    """
    return _native.regressor(_model(model), matrix(points))


def term_names(factors: Sequence[str], *, model: Model = "quadratic") -> List[str]:
    """Names of the terms of a model.

    >>> term_names(["a", "b"])
    ['1', 'a', 'b', 'a b', 'a^2', 'b^2']
    """
    return _native.term_names(_model(model), list(factors))


def coded(parameters: Sequence[Parameter], points: ArrayLike) -> Floats:
    """Points in units as coded ones.

    >>> coded([Parameter("x", "mm", 0.0, 10.0)], [[7.5]])
    array([[0.5]])
    """
    return _native.coded(tuples_of(parameters), matrix(points))


def natural(parameters: Sequence[Parameter], points: ArrayLike) -> Floats:
    """Coded points in units.

    >>> natural([Parameter("x", "mm", 0.0, 10.0)], [[0.5]])
    array([[7.5]])
    """
    return _native.natural(tuples_of(parameters), matrix(points))
