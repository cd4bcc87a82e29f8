"""The loop of Deodhar's dissertation: surfaces, a correction, and a test that drops what is worse beyond doubt."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

from numpy.typing import ArrayLike

from infuse import _native
from infuse._checks import whole, word
from infuse._parameters import (
    Designs,
    Names,
    Parameter,
    Settings,
    Simulate,
    batched,
    check_names,
    numbers,
    of_tuple,
    paired,
    rows,
    tuples_of,
)
from infuse.doe import _model
from infuse.pooled import as_json, read, replace
from infuse.trials import Outcome, Record, Trial, frame, named, outcome, records, settings_row, told, trials

if TYPE_CHECKING:
    import pandas


@dataclass(frozen=True)
class RegretBound:
    """How much worse than the best design left the optimum can be, with errors of the surfaces as they were observed."""

    regret: float
    """The bound, in the unit of the response."""
    eps: float
    """The bound on the error of the corrected model that it rests on."""
    simulation: float
    """Largest error of a simulation surface at a run that was left out."""
    experiment: float
    """The same of an experiment surface."""


@dataclass(frozen=True)
class Outlook:
    """What more experiments could still bring."""

    mean_gain: float
    upper_gain: float
    misfit_gain: Optional[float]


@dataclass(frozen=True)
class Assessment:
    """What the last closed batch came to."""

    batch: int
    optimum: Settings
    """The design with the smallest combined surface."""
    optimum_value: float
    simulation_optimum: Settings
    """What the simulation alone would have chosen."""
    spread: Optional[float]
    """S of (40), in the unit of the response."""
    n_left: int
    """Designs that are left."""
    left: float
    """Their share of all."""
    noise: Optional[float]
    """Standard deviation of experiments at equal settings, if any were repeated."""
    certificate: Optional[RegretBound]
    outlook: Optional[Outlook]


class Loop:
    """The dissertation's loop over every combination of levels; `infuse.DissertationLoop` is this class.

    `model` is `"linear"`, `"additive quadratic"`, `"quadratic"`, or a list with the exponents of each term. Other
    settings of the Rust library, such as `replicates`, `confidence`, `first_screening`, `careful` or `correction`, go by
    their names.

    Of `PooledLoop` it has neither constraints nor plants nor choices, and none of `correct`, `hand_out`, `change`, `due`,
    `standings`, `expectations` and `surprises`: a batch is closed by its last outcome, and what follows from it stands.

    >>> loop = Loop([Parameter("x", "mm", 0.0, 10.0, levels=21)], "quadratic", 5, 8, max_batches=2)
    >>> loop.run(lambda points: (points[:, 0] - 3) ** 2, lambda settings: (settings["x"] - 4) ** 2 + 1)
    'the limit on the batches was reached'
    >>> loop.assess().optimum
    {'x': 4.0}
    """

    def __init__(
        self,
        parameters: Sequence[Parameter],
        model: Union[str, Sequence[Sequence[int]]],
        n_experiments: int,
        n_simulations: int,
        *,
        seed: int = 1,
        max_batches: int = 10,
        **settings: Any,
    ) -> None:
        check_names(parameters)
        every = {
            "n_experiments": n_experiments,
            "n_simulations": n_simulations,
            "seed": seed,
            "max_batches": max_batches,
            **settings,
        }
        self._loop = _native.DissertationLoop(tuples_of(parameters), _model(model), as_json(every))
        self._parameters = list(parameters)

    @classmethod
    def _around(cls, loop: _native.DissertationLoop) -> "Loop":
        self = cls.__new__(cls)
        self._loop = loop
        self._parameters = [of_tuple(parameter) for parameter in loop.parameters()]
        return self

    @property
    def parameters(self) -> List[Parameter]:
        """What can be set."""
        return list(self._parameters)

    @property
    def _names(self) -> Names:
        return Names(self._parameters)

    @property
    def settings(self) -> Dict[str, Any]:
        """The settings it was begun with."""
        found: Dict[str, Any] = json.loads(self._loop.settings())
        return found

    @property
    def batch(self) -> int:
        """Number of closed batches."""
        return self._loop.batch()

    @property
    def stopped(self) -> Optional[str]:
        """Why the campaign has ended, as a sentence."""
        reason = self._loop.stopped()
        return None if reason is None else reason[1]

    def ask(self, simulate: Simulate) -> List[Trial]:
        """The experiments to run now; none after the end. A new batch is simulated first, all designs in one call."""
        call = batched(simulate)
        if call is None:
            raise _native.Error("no simulation, expected a function: this loop is not without one")
        return trials(self._names, self._loop.ask(call))

    def outstanding(self) -> List[Trial]:
        """The trials without an outcome."""
        return trials(self._names, self._loop.outstanding())

    def tell(self, id: int, value: Outcome = None, *, failed: Optional[str] = None) -> None:
        """The outcome of a trial; the last one of a batch closes it. NaN and an exception are failures."""
        number, reason = outcome(value, failed)
        self._loop.tell(whole("`id`", id, "the number of a trial"), number, reason, None)

    def tell_at(self, id: int, settings: Designs, value: Outcome = None, *, failed: Optional[str] = None) -> None:
        """The outcome of a trial that was made at other settings than those asked for."""
        number, reason = outcome(value, failed)
        self._loop.tell(whole("`id`", id, "the number of a trial"), number, reason, settings_row(self._parameters, settings))

    def tell_frame(self, table: "pandas.DataFrame", value: str = "value") -> int:
        """Takes results from a data frame as `frame` gives it, all or nothing. How many rows said something new.

        It needs `id` and `value`, may have `failed` and a column per parameter; settings that are not those asked for then
        count as made. Other columns are refused. Empty cells say nothing, and rows that say what is known are passed over.
        """
        results = told(self._names, (), self.records(), table, value)
        changed = self._loop.copy()
        for one in results:
            if one.outcome is not None:
                changed.tell(one.id, *one.outcome, one.actual)
        self._loop = changed
        return len(results)

    def add_earlier(self, designs: Designs, values: ArrayLike, *, source: str = "") -> None:
        """Experiments made outside of the campaign: they train from the next batch on, and never validate."""
        points, responses = rows(self._names, designs), numbers(paired(designs, values))
        if len(responses) != len(points):
            raise _native.Error(f"`values` has {len(responses)} entries, expected {len(points)}: one per design")
        changed = self._loop.copy()
        for point, response in zip(points.tolist(), responses):
            changed.add_earlier(point, response, word("`source`", source))
        self._loop = changed

    def withdraw_earlier(self, source: str) -> int:
        """Takes back the earlier experiments from this source. How many there were."""
        return self._loop.withdraw_earlier(word("`source`", source))

    def assess(self) -> Optional[Assessment]:
        """What the last closed batch came to; nothing before the first."""
        text = self._loop.assess()
        if text is None:
            return None
        found = json.loads(text)
        for name in ("optimum", "simulation_optimum"):
            found[name] = named(self._names, found[name])
        found["certificate"] = found["certificate"] and RegretBound(**found["certificate"])
        found["outlook"] = found["outlook"] and Outlook(**found["outlook"])
        return Assessment(**found)

    def reports(self) -> List[Dict[str, Any]]:
        """The closed batches with all their numbers, as in a saved campaign."""
        found: List[Dict[str, Any]] = json.loads(self._loop.reports())
        return found

    def records(self) -> List[Record]:
        """Every trial so far with its outcome, those of the batch that is open last."""
        closed = [entry for report in self.reports() for entry in report["trials"]]
        return records(self._names, [*closed, *json.loads(self._loop.open_records())])

    def frame(self) -> "pandas.DataFrame":
        """Every trial so far as a data frame: `id`, `batch`, settings, `value`, `failed`."""
        return frame(self._names, self.records())

    def run(self, simulate: Simulate, experiment: Callable[[Settings], Outcome]) -> str:
        """Asks and tells until the campaign ends, and says why."""
        while self.stopped is None:
            for trial in self.ask(simulate):
                self.tell(trial.id, experiment(trial.settings))
        return self.stopped

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the campaign to a JSON file, which `load` reads."""
        replace(path, self._loop.to_json())

    @classmethod
    def load(cls, path: Union[str, "os.PathLike[str]"]) -> "Loop":
        """A campaign from its file. All but the outcomes and the choice of designs is computed again and must agree."""
        return read(path, cls._of_json)

    @classmethod
    def _of_json(cls, text: str) -> "Loop":
        return cls._around(_native.DissertationLoop.from_json(text))

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self)._of_json, (self._loop.to_json(),)

    def __copy__(self) -> "Loop":
        return self._around(self._loop.copy())

    def __deepcopy__(self, memo: Any) -> "Loop":
        return self._around(self._loop.copy())

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name in _LACKING:
                raise AttributeError(f"`DissertationLoop` has no `{name}`, `PooledLoop` has: {_LACKING[name]}")
            raise AttributeError(f"`DissertationLoop` has no `{name}`")

    def __repr__(self) -> str:
        return f"DissertationLoop({', '.join(self._names)}: {self.batch} batches closed)"


_LACKING = {
    "correct": "the surfaces of a closed batch stand, and an open one takes an outcome once",
    "hand_out": "the loop alone chooses the experiments of a batch; others are told by `add_earlier`",
    "change": "the settings are those that the campaign was begun with",
    "due": "all simulations of a batch are asked for at once by `ask`",
    "tell_simulations": "all simulations of a batch are asked for at once by `ask`",
    "forget_simulations": "the surfaces of a closed batch stand",
    "n_simulated": "the simulations are in `reports`",
    "tell_constrained": "this loop knows no constraints",
    "standings": "what it says of designs is in `assess` and `reports`",
    "expectations": "what it says of designs is in `assess` and `reports`",
    "surprises": "what it says of experiments is in `reports`",
}
