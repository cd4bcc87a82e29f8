"""What can be set, and designs as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from infuse import _native

if TYPE_CHECKING:
    import pandas

Floats = NDArray[np.float64]
Settings = Dict[str, float]
"""A design: the value of each parameter by its name, in the parameter's unit."""
ParameterTuple = Tuple[str, str, float, float, Optional[int]]
Simulate = Callable[[Floats], ArrayLike]
"""Many designs at once (n × k, a row each, natural units) to n responses; NaN where there is none."""
Designs = Union[Mapping[str, float], Sequence[Mapping[str, float]], ArrayLike, "pandas.DataFrame"]
"""One design or many: dictionaries, rows of numbers in the order of the parameters, or a data frame with their names."""


@dataclass(frozen=True)
class Parameter:
    """Something that is set before an experiment.

    `levels` values from `lower` to `upper` at equal distances are allowed; without them it is continuous.

    >>> Parameter("spring", "N/mm", 10.0, 50.0, levels=21).unit
    'N/mm'
    >>> Parameter("spring", "N/mm", 50.0, 10.0)
    Traceback (most recent call last):
    infuse.Error: parameter `spring`: the lower bound 50.0 is above the upper bound 10.0, expected lower < upper
    """

    name: str
    unit: str
    lower: float
    upper: float
    levels: Optional[int] = None

    def __post_init__(self) -> None:
        _native.check_parameters([tuple_of(self)])


def tuple_of(parameter: Parameter) -> ParameterTuple:
    return (parameter.name, parameter.unit, parameter.lower, parameter.upper, parameter.levels)


def tuples_of(parameters: Sequence[Parameter]) -> List[ParameterTuple]:
    return [tuple_of(parameter) for parameter in parameters]


def matrix(points: ArrayLike) -> Floats:
    """An array of n × k doubles; one point alone is a row."""
    array = np.asarray(points, dtype=np.float64)
    if array.ndim > 2:
        raise _native.Error(f"an array of {array.ndim} dimensions, expected points as rows")
    return np.atleast_2d(array)


def numbers(values: ArrayLike) -> List[float]:
    """n doubles."""
    found: List[float] = np.asarray(values, dtype=np.float64).reshape(-1).tolist()
    return found


def _row(names: Sequence[str], settings: Mapping[str, float]) -> List[float]:
    unknown = [name for name in settings if name not in names]
    missing = [name for name in names if name not in settings]
    if unknown or missing:
        wrong = f"`{unknown[0]}` is no parameter" if unknown else f"`{missing[0]}` is missing"
        raise _native.Error(f"settings: {wrong}, expected {', '.join(names)}")
    return [float(settings[name]) for name in names]


def rows(names: Sequence[str], designs: Designs) -> Floats:
    """Designs in any form as an array of n × k numbers."""
    if isinstance(designs, Mapping):
        return np.array([_row(names, designs)])
    if hasattr(designs, "columns") and hasattr(designs, "to_numpy"):
        frame: Any = designs
        missing = [name for name in names if name not in frame.columns]
        if missing:
            raise _native.Error(f"data frame: no column `{missing[0]}`, expected {', '.join(names)}")
        return np.ascontiguousarray(frame[list(names)].to_numpy(dtype=np.float64))
    if isinstance(designs, Sequence) and designs and isinstance(designs[0], Mapping):
        return np.array([_row(names, one) for one in designs if isinstance(one, Mapping)])
    array = matrix(designs)  # type: ignore[arg-type]
    if array.shape[1] != len(names):
        raise _native.Error(f"a design has {array.shape[1]} numbers, expected {len(names)}: {', '.join(names)}")
    return array


def batched(simulate: Optional[Simulate]) -> Optional[Callable[[Floats], Floats]]:
    """The simulation with answers as the compiled half takes them."""
    if simulate is None:
        return None

    def call(points: Floats) -> Floats:
        return np.ascontiguousarray(np.asarray(simulate(points), dtype=np.float64).reshape(-1))

    return call


def with_frames(parameters: Sequence[Parameter], simulate: Callable[["pandas.DataFrame"], ArrayLike]) -> Simulate:
    """A simulation that takes data frames, a column per parameter, as one that takes arrays.

    >>> parameters = [Parameter("spring", "N/mm", 10.0, 50.0, levels=5)]
    >>> simulate = with_frames(parameters, lambda frame: (frame["spring"] - 30) ** 2)
    >>> np.asarray(simulate(np.array([[30.0], [40.0]])))
    array([  0., 100.])
    """
    import pandas

    names = [parameter.name for parameter in parameters]
    return lambda points: simulate(pandas.DataFrame(points, columns=names))
