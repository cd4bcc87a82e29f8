"""What can be set, and designs as arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from infuse import _native
from infuse._checks import LARGEST, doubles, real, shown, twice, whole, word, words

if TYPE_CHECKING:
    import pandas

Floats = NDArray[np.float64]
Settings = Dict[str, Any]
"""A design: the value of each parameter by its name, a number in the parameter's unit or the name of a choice."""
ParameterTuple = Tuple[str, str, float, float, Optional[int], Optional[List[str]]]
Simulate = Callable[[Floats], ArrayLike]
"""Many designs at once (n × k, a row each, natural units) to an array of n responses; NaN where there is none.

With c constraints it may be n × (1 + c): the response first, then a column for each of them. Any other shape is refused, and
so are infinities. Of a choice a row has the place in its list, from 0; `with_frames` gives its name.
"""
Designs = Union[Mapping[str, Any], Sequence[Mapping[str, Any]], ArrayLike, "pandas.DataFrame"]
"""One design or many: dictionaries, rows of numbers in the order of the parameters, or a data frame with their names.

Dictionaries and data frames are taken by name, in whatever order they have the names.
"""


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
        of = f"parameter `{word('parameter: `name`', self.name)}`"
        word(f"{of}: `unit`", self.unit)
        for bound in ("lower", "upper"):
            object.__setattr__(self, bound, real(f"{of}: `{bound}`", getattr(self, bound)))
        if self.levels is not None:
            object.__setattr__(self, "levels", whole(f"{of}: `levels`", self.levels, "a whole number", 2**32))
        if self.choices is not None:
            names = words(f"{of}: `choices`", self.choices, "a list of names")
            if len(names) < 2:
                raise _native.Error(f"{of}: {len(names)} {'choice' if len(names) == 1 else 'choices'}, expected 2 to 1000")
            object.__setattr__(self, "choices", tuple(names))
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
        >>> Parameter.choice("pad", "foam")
        Traceback (most recent call last):
        infuse.Error: parameter `pad`: `choices` is 'foam', expected a list of names
        """
        names = tuple(words(f"parameter `{word('parameter: `name`', name)}`: `choices`", choices, "a list of names"))
        return cls(name, "", 0.0, float(max(len(names) - 1, 0)), None, names)


def tuple_of(parameter: Parameter) -> ParameterTuple:
    choices = None if parameter.choices is None else list(parameter.choices)
    return (parameter.name, parameter.unit, parameter.lower, parameter.upper, parameter.levels, choices)


def of_tuple(found: ParameterTuple) -> Parameter:
    name, unit, lower, upper, levels, choices = found
    return Parameter(name, unit, lower, upper, levels, None if choices is None else tuple(choices))


def rounded(number: float) -> float:
    """Twelve digits, as in the sheets of the shell: 2.7 and not 2.6999999999999997."""
    return float(f"{number:.11e}") + 0.0


class Names(List[str]):
    """The names of parameters, and of the choices of those that are no numbers."""

    def __init__(self, parameters: Sequence[Parameter] = ()) -> None:
        super().__init__(parameter.name for parameter in parameters)
        self.choices = {one.name: one.choices for one in parameters if one.choices is not None}

    @classmethod
    def of(cls, names: Sequence[str]) -> "Names":
        """The names of numbers."""
        self = cls()
        self.extend(names)
        return self

    def number(self, name: str, value: Any, where: str = "settings") -> float:
        """A setting as the compiled half takes it: of a choice its place in the list."""
        choices = self.choices.get(name)
        if choices is None:
            return real(f"{where}: `{name}`", value)
        if not isinstance(value, str) or value not in choices:
            raise _native.Error(f"{where}: `{name}` is {shown(value)}, expected one of {', '.join(choices)}")
        return float(choices.index(value))

    def setting(self, name: str, number: float, *, exact: bool = False) -> Any:
        """The reverse, as a person would write it."""
        choices = self.choices.get(name)
        if choices is not None:
            return choices[round(number)]
        return number if exact else rounded(number)


def tuples_of(parameters: Sequence[Parameter]) -> List[ParameterTuple]:
    return [tuple_of(parameter) for parameter in parameters]


RESERVED = ("id", "batch", "value", "failed", "run", "repeats", "note", "source", "actual")
"""Columns of data frames and of the sheets of the shell."""


def check_names(parameters: Sequence[Parameter], constraints: Sequence[str] = ()) -> None:
    """Refuses what would come twice in a data frame, and what the shell refuses."""
    if isinstance(parameters, (str, Parameter)) or not all(isinstance(one, Parameter) for one in parameters):
        raise _native.Error(f"`parameters` is {shown(parameters)}, expected a list of `Parameter`")
    for name in [*(one.name for one in parameters), *constraints]:
        if name in RESERVED or name.startswith("actual "):
            of = "a parameter or constraint"
            raise _native.Error(f"`{name}` is a column of data frames and sheets, expected another name for {of}")
    names = {one.name for one in parameters}
    for name in constraints:
        if not name or name.strip() != name or any(sign in name for sign in '[],;"\n={}'):
            of = "words without brackets, quotes, commas, semicolons or equals signs"
            raise _native.Error(f"constraint: `name` is {name!r}, expected {of}")
        if name in names:
            raise _native.Error(f"constraint `{name}` is also the name of a parameter, expected another")
    again = twice(constraints)
    if again is not None:
        raise _native.Error(f"constraint `{again}` comes twice; one constraint may have both bounds")


def is_frame(values: Any) -> bool:
    """A data frame, of pandas or another library."""
    return hasattr(values, "columns") and hasattr(values, "to_numpy")


def matrix(points: ArrayLike) -> Floats:
    """An array of n × k doubles; one point alone is a row."""
    array = doubles("points", points)
    if array.ndim > 2:
        raise _native.Error(f"an array of {array.ndim} dimensions, expected points as rows")
    return np.atleast_2d(array)


def numbers(values: ArrayLike, what: str = "`values`") -> List[float]:
    """n doubles."""
    array = doubles(what, values)
    if array.ndim > 1 and array.size != max(array.shape):
        raise _native.Error(f"{what}: an array of shape {array.shape}, expected one number for each point")
    found: List[float] = array.reshape(-1).tolist()
    return found


def _row(names: Names, settings: Mapping[str, Any]) -> List[float]:
    unknown = [name for name in settings if name not in names]
    absent = [name for name in names if name not in settings]
    if unknown or absent:
        wrong = f"`{unknown[0]}` is no parameter" if unknown else f"`{absent[0]}` is missing"
        raise _native.Error(f"settings: {wrong}, expected {', '.join(names)}")
    return [names.number(name, settings[name]) for name in names]


def _mapping(design: Any) -> Optional[Mapping[str, Any]]:
    """A design by names: a dictionary, or a row of a data frame."""
    if isinstance(design, Mapping):
        return design
    if hasattr(design, "to_dict") and not is_frame(design) and all(isinstance(key, str) for key in design.index):
        found: Mapping[str, Any] = design.to_dict()
        return found
    return None


def check_columns(names: Sequence[str], frame: Any, *, others: bool) -> None:
    """Refuses a data frame without one of these columns, with one of them twice, or with others."""
    columns = list(frame.columns)
    absent = [name for name in names if name not in columns]
    unknown = [] if others else [column for column in columns if column not in names]
    again = twice(column for column in columns if column in names)
    expected = f"expected {', '.join(names)}"
    if absent:
        raise _native.Error(f"data frame: no column `{absent[0]}`, {expected}")
    if unknown:
        raise _native.Error(f"data frame: column `{unknown[0]}` is unknown, {expected}")
    if again is not None:
        raise _native.Error(f"data frame: column `{again}` comes twice, {expected}")


def label(frame: Any, row: int) -> str:
    """How a row of a data frame is called in errors: as it is printed."""
    return f"data frame, row {shown(frame.index[row]) if hasattr(frame, 'index') else row}"


def _of_frame(names: Names, frame: Any) -> Floats:
    def column(name: str) -> List[float]:
        return [names.number(name, value, label(frame, row)) for row, value in enumerate(frame[name])]

    columns = [column(name) for name in names]
    return np.ascontiguousarray(np.array(columns, dtype=np.float64).T.reshape(len(frame), len(names)))


def rows(names: Names, designs: Designs, *, others: bool = True) -> Floats:
    """Designs in any form as an array of n × k numbers; `others` are columns of data frames that mean nothing here."""
    of_one = _mapping(designs)
    if of_one is not None:
        return np.array([_row(names, of_one)])
    if is_frame(designs):
        check_columns(names, designs, others=others)
        return _of_frame(names, designs)
    if isinstance(designs, Sequence) and any(_mapping(one) is not None for one in designs):
        each = [_mapping(one) for one in designs]
        if any(one is None for one in each):
            raise _native.Error("designs: dictionaries and other things, expected all of one kind")
        return np.array([_row(names, one) for one in each if one is not None])
    array = matrix(designs)  # type: ignore[arg-type]
    if array.shape[1] != len(names):
        raise _native.Error(f"a design has {array.shape[1]} numbers, expected {len(names)}: {', '.join(names)}")
    for name, choices in names.choices.items():
        for place in array[:, names.index(name)]:
            if place not in range(len(choices)):
                of = f"a place in its list, 0 to {len(choices) - 1}, or in a dictionary or data frame its name"
                raise _native.Error(f"settings: `{name}` is {place}, expected {of}")
    return array


def _in_place(found: Any, n: int) -> Any:
    """A series or data frame whose index says that its rows are in another order, in the order of the designs."""
    index = getattr(found, "index", None)
    if index is None or not hasattr(found, "reindex") or len(found) != n:
        return found
    places = list(range(n))
    labels = list(index)
    is_other = labels != places and all(isinstance(one, (int, np.integer)) for one in labels)
    return found.reindex(places) if is_other and sorted(labels) == places else found


def _in_order(found: Any, constraints: Sequence[str], what: str) -> Any:
    """A data frame with the response before the constraints, whose columns go by their names."""
    if not is_frame(found) or not constraints or not any(isinstance(column, str) for column in found.columns):
        return found
    columns = list(found.columns)
    if len(columns) == 1 and columns[0] not in constraints:
        return found[columns[0]]
    responses = [column for column in columns if column not in constraints]
    if len(responses) != 1 or len(columns) != 1 + len(constraints) or twice(columns) is not None:
        of = ", ".join(map(str, columns))
        raise _native.Error(f"{what} the columns {of}, expected the response and {', '.join(constraints)}")
    return found[[*responses, *constraints]]


def paired(designs: Designs, values: Any) -> Any:
    """Values in the order of the designs, where both have an index that says so."""
    if not is_frame(designs) or not hasattr(values, "reindex"):
        return values
    index: Any = getattr(designs, "index", None)
    if index is None or values.index.equals(index):
        return values
    if len(values) == len(index) and index.is_unique and set(values.index) == set(index):
        return values.reindex(index)
    raise _native.Error("values: another index than that of the designs, expected the same, in any order")


def answers(found: Any, n: int, constraints: Sequence[str] = (), what: str = "the simulation gave") -> Floats:
    """Responses at n designs, and constrained ones behind each, one after the other."""
    shapes = [(n,), (n, 1 + len(constraints))]
    expected = f"expected {' or '.join(str(shape) for shape in (shapes if constraints else shapes[:1]))}"
    if found is None:
        raise _native.Error(f"{what} None, {expected}")
    array = doubles(what.rsplit(" ", 1)[0], _in_order(_in_place(found, n), constraints, what))
    if array.shape not in shapes:
        raise _native.Error(f"{what} an array of shape {array.shape}, {expected}")
    flat = np.ascontiguousarray(array.reshape(-1))
    beyond = np.flatnonzero(np.abs(flat) > LARGEST)
    if len(beyond) > 0:
        design, value = beyond[0] // (len(flat) // n), flat[beyond[0]]
        allowed = "a finite number, at most 1e100 in magnitude, or NaN where there is none"
        raise _native.Error(f"{what} {value} for design {design}, expected {allowed}")
    return flat


def batched(simulate: Optional[Simulate], constraints: Sequence[str] = ()) -> Optional[Callable[[Floats], Floats]]:
    """The simulation with answers as the compiled half takes them."""
    if simulate is None:
        return None
    if not callable(simulate):
        raise _native.Error(f"`simulate` is {shown(simulate)}, expected a function of an array of designs")

    def call(points: Floats) -> Floats:
        return answers(simulate(points), len(points), constraints)

    return call


def with_frames(parameters: Sequence[Parameter], simulate: Callable[["pandas.DataFrame"], ArrayLike]) -> Simulate:
    """A simulation that takes data frames, a column per parameter, as one that takes arrays.

    A series or data frame that it returns goes by its index: rows in another order are put back into that of the table, and
    an index that is not the table's is refused. What has no index, or one that was made anew (`reset_index`), is taken in the
    order of the table.

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
        found: Any = simulate(table.copy())
        if not hasattr(found, "reindex") or found.index.equals(table.index):
            return found  # type: ignore[no-any-return]
        if len(found) == len(table) and set(found.index) == set(table.index):
            return found.reindex(table.index)  # type: ignore[no-any-return]
        allowed = "the index of the table it was given, in any order, or an array in the order of the table"
        raise _native.Error(f"the simulation gave a {type(found).__name__} with an index of its own, expected {allowed}")

    return call
