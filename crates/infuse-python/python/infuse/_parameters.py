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
Settings = Dict[str, Any]
"""A design: the value of each parameter by its name, a number in the parameter's unit or the name of a choice."""
ParameterTuple = Tuple[str, str, float, float, Optional[int], Optional[List[str]]]
Simulate = Callable[[Floats], ArrayLike]
"""Many designs at once (n × k, a row each, natural units) to n responses; NaN where there is none.

Of a choice a row has the place in its list, from 0; `with_frames` gives its name.
"""
Designs = Union[Mapping[str, Any], Sequence[Mapping[str, Any]], ArrayLike, "pandas.DataFrame"]
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
    choices: Optional[Tuple[str, ...]] = None
    """The names of what is no number; see `Parameter.choice`."""

    def __post_init__(self) -> None:
        _native.check_parameters([tuple_of(self)])

    @classmethod
    def choice(cls, name: str, choices: Sequence[str]) -> "Parameter":
        """What is no number but one of some names, whose order means nothing: a material, a supplier, a shape.

        Of the loops the pooled one takes it.

        >>> Parameter.choice("pad", ["foam", "film", "wood"]).choices
        ('foam', 'film', 'wood')
        >>> Parameter.choice("pad", ["foam", "foam"])
        Traceback (most recent call last):
        infuse.Error: parameter `pad`: the choice `foam` is not usable, expected each choice once
        """
        return cls(name, "", 0.0, float(max(len(choices) - 1, 0)), None, tuple(choices))


def tuple_of(parameter: Parameter) -> ParameterTuple:
    choices = None if parameter.choices is None else list(parameter.choices)
    return (parameter.name, parameter.unit, parameter.lower, parameter.upper, parameter.levels, choices)


def of_tuple(found: ParameterTuple) -> Parameter:
    name, unit, lower, upper, levels, choices = found
    return Parameter(name, unit, lower, upper, levels, None if choices is None else tuple(choices))


class Names(List[str]):
    """The names of parameters, and of the choices of those that are no numbers."""

    def __init__(self, parameters: Sequence[Parameter]) -> None:
        super().__init__(parameter.name for parameter in parameters)
        self.choices = {one.name: one.choices for one in parameters if one.choices is not None}

    def number(self, name: str, value: Any) -> float:
        """A setting as the compiled half takes it: of a choice its place in the list."""
        choices = self.choices.get(name)
        if choices is None:
            return float(value)
        if value not in choices:
            raise _native.Error(f"settings: `{name}` is {value!r}, expected one of {', '.join(choices)}")
        return float(choices.index(value))

    def setting(self, name: str, number: float) -> Any:
        """The reverse."""
        choices = self.choices.get(name)
        return number if choices is None else choices[round(number)]


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


def _row(names: Names, settings: Mapping[str, Any]) -> List[float]:
    unknown = [name for name in settings if name not in names]
    missing = [name for name in names if name not in settings]
    if unknown or missing:
        wrong = f"`{unknown[0]}` is no parameter" if unknown else f"`{missing[0]}` is missing"
        raise _native.Error(f"settings: {wrong}, expected {', '.join(names)}")
    return [names.number(name, settings[name]) for name in names]


def rows(names: Names, designs: Designs) -> Floats:
    """Designs in any form as an array of n × k numbers."""
    if isinstance(designs, Mapping):
        return np.array([_row(names, designs)])
    if hasattr(designs, "columns") and hasattr(designs, "to_numpy"):
        frame: Any = designs
        missing = [name for name in names if name not in frame.columns]
        if missing:
            raise _native.Error(f"data frame: no column `{missing[0]}`, expected {', '.join(names)}")
        columns = [[names.number(name, value) for value in frame[name]] for name in names]
        return np.ascontiguousarray(np.array(columns, dtype=np.float64).T.reshape(len(frame), len(names)))
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

    names = Names(parameters)

    def call(points: Floats) -> ArrayLike:
        table = pandas.DataFrame(points, columns=list(names))
        for name in names.choices:
            table[name] = [names.setting(name, number) for number in table[name]]
        return simulate(table)

    return call
