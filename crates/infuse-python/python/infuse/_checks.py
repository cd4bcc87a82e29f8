"""What is taken where a number, a whole number or a word is expected; each refusal names the field and the value."""

from __future__ import annotations

import math
import operator
from typing import Any, Iterable, List, Mapping, Optional, Sequence

import numpy as np
from numpy.typing import NDArray

from infuse import _native

LARGEST = 1e100
"""The largest magnitude of a response."""


def shown(value: Any) -> str:
    """A value in an error: numpy's numbers as any other, nothing long."""
    text = repr(value.item() if isinstance(value, np.generic) else value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def missing(value: Any) -> bool:
    """Nothing at all: `None`, NaN, and what pandas has for them."""
    if value is None or type(value).__name__ in ("NAType", "NaTType"):
        return True
    return isinstance(value, (float, np.floating)) and math.isnan(value)


def real(what: str, value: Any, expected: str = "a number") -> float:
    """One number, NaN and infinities among them; no text, no truth value, no complex number, no array of one."""
    is_other = isinstance(value, (str, bytes, bool, np.bool_, complex, np.complexfloating))
    if not is_other and hasattr(value, "__float__") and getattr(value, "ndim", 0) == 0:
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    raise _native.Error(f"{what} is {shown(value)}, expected {expected}")


def finite(what: str, value: Any) -> float:
    """One finite number."""
    number = real(what, value, "a finite number")
    if not math.isfinite(number):
        raise _native.Error(f"{what} is {number}, expected a finite number")
    return number


def whole(what: str, value: Any, expected: str = "a whole number from 0 on", beyond: int = 2**64) -> int:
    """One whole number of those below `beyond`; 3.0 is one."""
    number: Optional[int] = None
    if isinstance(value, (float, np.floating)) and math.isfinite(value) and float(value).is_integer():
        number = int(value)
    elif not isinstance(value, (bool, np.bool_)):
        try:
            number = operator.index(value)
        except TypeError:
            pass
    if number is None or not 0 <= number < beyond:
        raise _native.Error(f"{what} is {shown(value)}, expected {expected}")
    return number


def word(what: str, value: Any, expected: str = "a text") -> str:
    """A text."""
    if not isinstance(value, str):
        raise _native.Error(f"{what} is {shown(value)}, expected {expected}")
    return str(value)


def words(what: str, values: Iterable[str], expected: str = "a list of texts") -> List[str]:
    """A list of texts; a bare text, which would be taken letter by letter, is none."""
    if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
        raise _native.Error(f"{what} is {shown(values)}, expected {expected}")
    return [word(f"{what}: entry {number}", value) for number, value in enumerate(values, 1)]


def twice(values: Iterable[Any]) -> Optional[Any]:
    """What comes twice, if anything does."""
    found = list(values)
    return next((value for place, value in enumerate(found) if value in found[:place]), None)


def doubles(what: str, values: Any) -> NDArray[np.float64]:
    """An array of doubles, NaN where there is nothing; what is no number is refused, complex numbers and texts among it."""
    if values is None:
        raise _native.Error(f"{what} is None, expected numbers")
    try:
        array = np.asarray(values)
    except ValueError:
        raise _native.Error(f"{what}: rows of different lengths, expected an array of numbers") from None
    if array.dtype.kind == "O":
        every = enumerate(array.reshape(-1))
        found = [math.nan if missing(one) else real(f"{what}: entry {place}", one) for place, one in every]
        return np.array(found, dtype=np.float64).reshape(array.shape)
    if array.dtype.kind not in "iuf":
        kind = {"c": "complex numbers", "U": "texts", "S": "texts", "b": "truth values"}.get(array.dtype.kind)
        raise _native.Error(f"{what}: an array of {kind or array.dtype}, expected numbers")
    return np.asarray(array, dtype=np.float64)


def plain(what: str, value: Any) -> Any:
    """A setting as a file holds it: numpy's numbers and arrays, tuples and lists, dictionaries; finite numbers alone."""
    if value is None or isinstance(value, (str, bool)):
        return value
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, Mapping):
        return {str(key): plain(f"{what}: `{key}`", one) for key, one in value.items()}
    if isinstance(value, np.ndarray):
        return plain(what, value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, bytes):
        return [plain(f"{what}: entry {number}", one) for number, one in enumerate(value, 1)]
    return finite(what, value)
