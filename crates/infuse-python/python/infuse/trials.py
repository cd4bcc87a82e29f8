"""Experiments and what came of them; what both loops share."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Optional, Sequence, Tuple, Union

from infuse import _native
from infuse._parameters import Designs, Floats, Names, Parameter, Settings, rows

if TYPE_CHECKING:
    import pandas

Outcome = Union[float, BaseException, None]
"""A response, NaN for none, or an exception that says why there is none."""


@dataclass(frozen=True)
class Trial:
    """An experiment to run: tell its outcome by its `id`."""

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


def outcome(value: Outcome, failed: Optional[str]) -> Tuple[Optional[float], Optional[str]]:
    """A response or a reason, as the compiled half takes them."""
    if failed is not None:
        if value is not None:
            raise _native.Error("both a value and a failure, expected one of them")
        return None, failed
    if value is None:
        raise _native.Error("neither a value nor a failure, expected one of them")
    if isinstance(value, BaseException):
        return None, f"{type(value).__name__}: {value}"
    number = float(value)
    return (None, f"the experiment returned {number}") if math.isnan(number) else (number, None)


def named(names: Names, point: Iterable[float]) -> Settings:
    return {name: names.setting(name, number) for name, number in zip(names, point)}


def trials(names: Names, text: str) -> List[Trial]:
    """Trials of either loop, from JSON."""
    batch = [one.get("batch", one.get("iteration")) for one in json.loads(text)]
    return [Trial(one["id"], number, named(names, one["point"])) for one, number in zip(json.loads(text), batch)]


def records(names: Names, entries: Iterable[Dict[str, Any]]) -> List[Record]:
    """Records of either loop, from what JSON held."""

    def one(entry: Dict[str, Any]) -> Record:
        trial, actual, found = entry["trial"], entry["actual"], entry["outcome"] or {}
        return Record(
            id=trial["id"],
            batch=trial.get("batch", trial.get("iteration")),
            settings=named(names, trial["point"]),
            actual=None if actual is None else named(names, actual),
            value=found.get("value"),
            failed=found["failed"]["reason"] if "failed" in found else None,
        )

    return [one(entry) for entry in entries]


def frame(names: Sequence[str], found: Sequence[Union[Trial, Record]]) -> "pandas.DataFrame":
    """One row per trial: `id`, `batch`, the settings made, and of records `value` and `failed`."""
    import pandas

    def one(trial: Union[Trial, Record]) -> Dict[str, Any]:
        row: Dict[str, Any] = {"id": trial.id, "batch": trial.batch}
        if isinstance(trial, Record):
            value = math.nan if trial.value is None else trial.value
            return {**row, **(trial.actual or trial.settings), "value": value, "failed": trial.failed}
        return {**row, **trial.settings}

    columns = ["id", "batch", *names] + ([] if found and isinstance(found[0], Trial) else ["value", "failed"])
    return pandas.DataFrame([one(trial) for trial in found], columns=columns)


@dataclass(frozen=True)
class Told:
    """A row of a data frame with results."""

    id: int
    value: Optional[float]
    failed: Optional[str]
    actual: Optional[List[float]]


def told(names: Names, asked: Sequence[Trial], table: "pandas.DataFrame", value: str) -> List[Told]:
    """The rows that say something; settings count as made where the frame has them and they are not those asked for."""
    for column in ("id", value):
        if column not in table.columns:
            raise _native.Error(f"data frame: no column `{column}`, expected `id` and `{value}`")
    by_id = {trial.id: trial for trial in asked}
    has_settings = all(name in table.columns for name in names)
    found = []
    for row in table.to_dict("records"):
        number, reason = float(row[value]), row.get("failed")
        reason = reason if isinstance(reason, str) and reason else None
        if math.isnan(number) and reason is None:
            continue
        trial = by_id.get(int(row["id"]))
        made = [names.number(name, row[name]) for name in names] if has_settings else None
        same = made is None or (trial is not None and made == [names.number(*one) for one in trial.settings.items()])
        found.append(Told(int(row["id"]), None if reason else number, reason, None if same else made))
    return found


def settings_row(parameters: Sequence[Parameter], design: Designs) -> List[float]:
    """One design."""
    array: Floats = rows(Names(parameters), design)
    if len(array) != 1:
        raise _native.Error(f"{len(array)} designs, expected one")
    found: List[float] = array[0].tolist()
    return found
