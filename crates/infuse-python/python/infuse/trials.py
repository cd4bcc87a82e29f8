"""Experiments and what came of them; what both loops share."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np

from infuse import _native
from infuse._checks import finite, missing, real, twice, whole, word
from infuse._parameters import Designs, Floats, Names, Parameter, Settings, label, rounded, rows

if TYPE_CHECKING:
    import pandas

Outcome = Union[float, BaseException, None]
"""A response, NaN for none, or an exception that says why there is none."""


@dataclass(frozen=True)
class Trial:
    """An experiment to run: tell its outcome by its `id`. Its settings are written with twelve digits, as in a sheet."""

    id: int
    batch: int
    settings: Settings


@dataclass(frozen=True)
class Record:
    """A trial with what is known of it; `actual` are the settings really made, if they were others."""

    id: int
    batch: int
    settings: Settings
    actual: Optional[Settings]
    value: Optional[float]
    failed: Optional[str]
    constrained: Dict[str, float] = field(default_factory=dict)
    """What was measured of the constraints, by their names."""


def outcome(value: Outcome, failed: Optional[str]) -> Tuple[Optional[float], Optional[str]]:
    """A response or a reason, as the compiled half takes them."""
    if failed is not None:
        if value is not None:
            raise _native.Error("both a value and a failure, expected one of them")
        if not word("`failed`", failed, "the reason in words").strip():
            raise _native.Error(f"`failed` is {failed!r}, expected the reason in words")
        return None, failed
    if isinstance(value, BaseException):
        return None, f"{type(value).__name__}: {value}"
    if missing(value) and not isinstance(value, (float, np.floating)):
        raise _native.Error("neither a value nor a failure, expected one of them")
    number = real("`value`", value)
    return (None, f"the experiment returned {number}") if math.isnan(number) else (number, None)


def named(names: Names, point: Iterable[float], *, exact: bool = False) -> Settings:
    return {name: names.setting(name, number, exact=exact) for name, number in zip(names, point)}


def trials(names: Names, text: str) -> List[Trial]:
    """Trials of either loop, from JSON."""
    return [Trial(one["id"], one["batch"], named(names, one["point"])) for one in json.loads(text)]


def records(
    names: Names,
    entries: Iterable[Dict[str, Any]],
    constraints: Sequence[str] = (),
    constrained: Mapping[int, Sequence[Optional[float]]] = {},
) -> List[Record]:
    """Records of either loop, from what JSON held; `constrained` has those of each trial in the order of the constraints."""

    def one(entry: Dict[str, Any]) -> Record:
        trial, actual, found = entry["trial"], entry["actual"], entry["outcome"] or {}
        pairs = zip(constraints, constrained.get(trial["id"], ()))
        return Record(
            id=trial["id"],
            batch=trial["batch"],
            settings=named(names, trial["point"]),
            actual=None if actual is None else named(names, actual, exact=True),
            value=found.get("value"),
            failed=found["failed"]["reason"] if "failed" in found else None,
            constrained={name: value for name, value in pairs if value is not None},
        )

    return [one(entry) for entry in entries]


def frame(names: Sequence[str], found: Sequence[Record], constraints: Sequence[str] = ()) -> "pandas.DataFrame":
    """One row per trial: `id`, `batch`, the settings made, `value`, a column per constraint, `failed`."""
    import pandas

    def one(trial: Record) -> Dict[str, Any]:
        value = math.nan if trial.value is None else trial.value
        others = {name: trial.constrained.get(name, math.nan) for name in constraints}
        made = trial.actual or trial.settings
        return {"id": trial.id, "batch": trial.batch, **made, "value": value, **others, "failed": trial.failed}

    columns = ["id", "batch", *names, "value", *constraints, "failed"]
    return pandas.DataFrame([one(trial) for trial in found], columns=columns)


@dataclass(frozen=True)
class Told:
    """What a row of a data frame says that was not known."""

    id: int
    outcome: Optional[Tuple[Optional[float], Optional[str]]]
    """A value or a reason; none if that was known."""
    actual: Optional[List[float]]
    constrained: Optional[List[Optional[float]]]
    """All that is known of the trial now; none if nothing came."""


class _Table:
    """A data frame with results."""

    def __init__(
        self, names: Names, constraints: Sequence[str], known: Sequence[Record], table: "pandas.DataFrame", value: str
    ) -> None:
        self.names, self.constraints, self.table, self.value = names, list(constraints), table, value
        self.known = {record.id: record for record in known}
        self._check()
        self.columns = {name: list(table[name]) for name in table.columns}
        self.has_settings = all(name in self.columns for name in names)

    def _check(self) -> None:
        columns = list(self.table.columns)
        if self.value in ("id", "batch", "failed", *self.names, *self.constraints):
            raise _native.Error(f"data frame: the column of values is `{self.value}`, expected one of its own")
        usual = ["id", "batch", *self.names, self.value, *self.constraints, "failed"]
        unknown = [column for column in columns if column not in usual and column != "value"]
        again = twice(columns)
        if again is not None:
            raise _native.Error(f"data frame: column `{again}` comes twice, expected {', '.join(usual)}")
        if unknown:
            raise _native.Error(f"data frame: column `{unknown[0]}` is unknown, expected {', '.join(usual)}")
        for column in ("id", self.value):
            if column not in columns:
                raise _native.Error(f"data frame: no column `{column}`, expected `id` and `{self.value}`")
        given = [name for name in self.names if name in columns]
        if given and len(given) < len(self.names):
            absent = next(name for name in self.names if name not in columns)
            raise _native.Error(f"data frame: no column `{absent}`, expected one for each parameter, or for none")

    def _number(self, row: int, column: str) -> Optional[float]:
        value = self.columns[column][row] if column in self.columns else None
        return None if missing(value) else real(f"{label(self.table, row)}: `{column}`", value, "a number, or nothing")

    def _reason(self, row: int) -> Optional[str]:
        found = self.columns["failed"][row] if "failed" in self.columns else None
        if missing(found):
            return None
        return word(f"{label(self.table, row)}: `failed`", found, "the reason in words, or nothing").strip() or None

    def _made(self, row: int, record: Optional[Record]) -> Optional[List[float]]:
        """The settings, if they are there and not those that are known."""
        if not self.has_settings:
            return None
        where = label(self.table, row)
        made = [self.names.number(name, self.columns[name][row], where) for name in self.names]
        for name, number in zip(self.names, made):
            finite(f"{where}: `{name}`", number)
        if record is None:
            return None
        known = [self.names.number(*one) for one in (record.actual or record.settings).items()]
        is_same = [rounded(number) for number in made] == [rounded(number) for number in known]
        return None if is_same else made

    def _others(self, row: int, record: Optional[Record]) -> Optional[List[Optional[float]]]:
        """The constrained responses, if some are new; what is known stands."""
        where, known = label(self.table, row), {} if record is None else record.constrained
        merged: List[Optional[float]] = []
        for name in self.constraints:
            number = self._number(row, name)
            if number is not None and name in known and known[name] != number:
                of = f"{known[name]} as before: `tell_constrained` corrects it"
                raise _native.Error(f"{where}: `{name}` is {number}, expected {of}")
            merged.append(known.get(name) if number is None else number)
        return None if sum(one is not None for one in merged) == len(known) else merged

    def row(self, row: int) -> Optional[Told]:
        """What a row says, if it says anything new."""
        where, number, reason = label(self.table, row), self._number(row, self.value), self._reason(row)
        is_empty = number is None and reason is None
        if is_empty and all(self._number(row, name) is None for name in self.constraints):
            return None
        if number is not None and reason is not None:
            raise _native.Error(f"{where}: both a value and a failure, expected one of them")
        if self.value != "value" and number is not None and self._number(row, "value") not in (None, number):
            raise _native.Error(f"{where}: `value` and `{self.value}` differ, expected one of them")
        id = whole(f"{where}: `id`", self.columns["id"][row], "the number of a trial")
        record = self.known.get(id)
        made, others = self._made(row, record), self._others(row, record)
        is_known = record is not None and made is None and (record.value, record.failed) == (number, reason)
        found = None if is_empty or is_known else (number, reason)
        if is_empty and made is not None:
            raise _native.Error(f"{where}: other settings than asked for, but neither `{self.value}` nor `failed`")
        return None if found is None and others is None else Told(id, found, made, others)


def told(
    names: Names, constraints: Sequence[str], known: Sequence[Record], table: "pandas.DataFrame", value: str
) -> List[Told]:
    """The rows that say something new; settings count as made where the frame has them and they are not those asked for."""
    if not (hasattr(table, "columns") and hasattr(table, "index")):
        raise _native.Error(f"a {type(table).__name__}, expected a data frame of pandas")
    rows_of = _Table(names, constraints, known, table, value)
    found = [rows_of.row(row) for row in range(len(table))]
    return [one for one in found if one is not None]


def settings_row(parameters: Sequence[Parameter], design: Designs) -> List[float]:
    """One design."""
    array: Floats = rows(Names(parameters), design)
    if len(array) != 1:
        raise _native.Error(f"{len(array)} designs, expected one")
    found: List[float] = array[0].tolist()
    return found
