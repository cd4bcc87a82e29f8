"""Optimal designs: which runs to make when every run costs a day.

Points are coded: -1 and 1 are the bounds of each factor. `Design.natural` gives them in units.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike

from infuse import _native
from infuse._checks import doubles, real, shown, whole, word, words
from infuse._parameters import Designs, Floats, Names, Parameter, is_frame, matrix, rounded, rows, tuples_of

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
        """The runs in units, as a data frame; twelve digits, as in a sheet."""
        import pandas

        runs = [[rounded(number) for number in run] for run in self.natural().tolist()]
        return pandas.DataFrame(runs, columns=[one.name for one in self.parameters or ()])


def _axes(factors: Factors) -> List[Optional[int]]:
    if isinstance(factors, (int, float, np.integer)):
        return [None] * whole("`factors`", factors, "a number of factors, or a list of them")
    if isinstance(factors, (str, Parameter)) or not hasattr(factors, "__iter__"):
        raise _native.Error(f"`factors` is {shown(factors)}, expected a number of factors, or a list of them")
    choice = next((one.name for one in factors if isinstance(one, Parameter) and one.choices is not None), None)
    if choice is not None:
        raise _native.Error(f"factor `{choice}` has choices, expected numbers")
    of = "`factors`: a number of levels"
    counts = [one.levels if isinstance(one, Parameter) else one for one in factors]
    return [None if one is None else whole(of, one, "a whole number, or None", 2**32) for one in counts]


def _names(factors: Optional[Factors]) -> Optional[Names]:
    """The names of parameters, if all factors are some."""
    if factors is None or isinstance(factors, (int, float, np.integer)):
        return None
    given = [one.name for one in factors if isinstance(one, Parameter)]
    return Names.of(given) if len(given) == len(factors) else None


def _points(factors: Optional[Factors], runs: Designs) -> Floats:
    """Coded points; where the factors have names, data frames and dictionaries go by them."""
    names = _names(factors)
    if names is not None and (is_frame(runs) or not hasattr(runs, "shape")):
        return rows(names, runs, others=False)
    return matrix(runs)  # type: ignore[arg-type]


def _model(model: Model) -> Union[str, List[List[int]]]:
    """A name, or the exponents of each term."""
    if isinstance(model, str):
        return model
    terms = doubles("model", model if hasattr(model, "__len__") else [])
    if terms.ndim != 2:
        raise _native.Error(f"`model` is {shown(model)}, expected a name, or a list with the exponents of each term")
    if not np.isin(terms, np.arange(256)).all():
        raise _native.Error(f"`model` is {shown(model)}, expected whole exponents from 0 to 255")
    found: List[List[int]] = terms.astype(int).tolist()
    return found


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
    fixed: Optional[Designs] = None,
) -> Design:
    """A design of so many runs for a model, good by a criterion: D, A, G, E, T or I.

    The same seed and number of starts give the same design on any number of threads. `fixed` runs (coded) come first and
    count in `runs`; `replicates` of the others are second runs. A data frame of fixed runs goes by the names of the
    parameters.

    >>> design = search(2, 8, starts=50)
    >>> design.runs.shape, round(design.efficiency, 2)
    ((8, 2), 87.94)
    >>> search(2, 5)
    Traceback (most recent call last):
    infuse.Error: 5 runs cannot determine 6 terms, expected at least 6 runs
    """
    options = {
        "seed": whole("`seed`", seed),
        "starts": whole("`starts`", starts),
        "time_limit_s": None if time_limit_s is None else real("`time_limit_s`", time_limit_s),
        "target_percent": None if target_percent is None else real("`target_percent`", target_percent),
        "thorough": bool(thorough),
        "replicates": None if replicates is None else whole("`replicates`", replicates),
    }
    axes, n_runs = _axes(factors), whole("`runs`", runs)
    kept = None if fixed is None else _points(factors, fixed)
    found = _native.search(axes, _model(model), n_runs, word("`criterion`", criterion), kept, options)
    parameters = None
    if _names(factors) is not None and not isinstance(factors, int):
        parameters = [one for one in factors if isinstance(one, Parameter)]
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
    runs: Designs, *, model: Model = "quadratic", criterion: str = "G", factors: Optional[Factors] = None
) -> float:
    """Efficiency of any design in per cent; predictions are asked for in the cube, or over the levels of `factors`.

    A data frame goes by the names of the factors, where these are parameters.

    >>> round(efficiency([[-1.0], [0.0], [1.0]]), 6)
    100.0
    """
    points = _points(factors, runs)
    axes = _axes(points.shape[1] if factors is None else factors)
    return _native.efficiency(points, axes, _model(model), word("`criterion`", criterion))[0]


def evaluate(
    runs: Designs, *, model: Model = "quadratic", factors: Optional[Factors] = None
) -> Tuple[Dict[str, Any], str]:
    """All that is known of a design: a dictionary, and a table to print.

    >>> found, table = evaluate([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]], model="linear")
    >>> found["precision"]["leverages"]
    [0.75, 0.75, 0.75, 0.75]
    """
    points = _points(factors, runs)
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
    return _native.term_names(_model(model), words("`factors`", factors, "a list of names"))


def coded(parameters: Sequence[Parameter], points: Designs) -> Floats:
    """Points in units as coded ones, from -1 to 1; what is outside of the bounds is refused.

    Dictionaries and data frames go by the names of the parameters.

    >>> coded([Parameter("x", "mm", 0.0, 10.0)], [[7.5]])
    array([[0.5]])
    >>> coded([Parameter("x", "mm", 0.0, 10.0)], [{"x": 12.0}])
    Traceback (most recent call last):
    infuse.Error: parameter `x` is 12.0, expected 0.0 to 10.0 mm
    """
    found = rows(Names(parameters), points, others=False)
    for parameter, column in zip(parameters, found.T):
        slack = 1e-9 * (parameter.upper - parameter.lower)
        outside = column[~((column >= parameter.lower - slack) & (column <= parameter.upper + slack))]
        if len(outside) > 0:
            bounds = f"{parameter.lower} to {parameter.upper} {parameter.unit}".rstrip()
            raise _native.Error(f"parameter `{parameter.name}` is {outside[0]}, expected {bounds}")
    return _native.coded(tuples_of(parameters), found)


def natural(parameters: Sequence[Parameter], points: Designs) -> Floats:
    """Coded points in units; beyond -1 and 1 they are outside of the bounds.

    >>> natural([Parameter("x", "mm", 0.0, 10.0)], [[0.5]])
    array([[7.5]])
    """
    found = rows(Names.of([parameter.name for parameter in parameters]), points, others=False)
    if not np.isfinite(found).all():
        raise _native.Error(f"points: {found[~np.isfinite(found)][0]}, expected finite coded numbers")
    return _native.natural(tuples_of(parameters), found)
