"""The pooled loop: every experiment and the simulation in one surface."""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence, Type, TypeVar, Union

from numpy.typing import ArrayLike

from infuse import _native
from infuse._parameters import Designs, Floats, Parameter, Settings, Simulate, batched, numbers, rows, tuples_of
from infuse.trials import Outcome, Record, Trial, frame, named, outcome, records, settings_row, told, trials

if TYPE_CHECKING:
    import pandas

T = TypeVar("T")


@dataclass(frozen=True)
class Standing:
    """What is known of one design."""

    settings: Settings
    """The design."""
    mean: float
    """The response that is expected there."""
    deviation: float
    """Standard deviation of that, without the noise of a reading."""
    n_readings: int
    """Number of readings there."""
    measured: Optional[float]
    """Mean of those readings."""
    feasible: float
    """Probability that an experiment there gives a response."""
    probability_better: float
    """Probability that it is better than the recommended design; 0 for that one."""
    may_be_best: bool
    """Whether it may still be the best."""


@dataclass(frozen=True)
class Certificate:
    """With this `probability` no design is better than the recommended one by more than `bound`."""

    probability: float
    bound: float
    quantile: float
    """The bound as the surface has it, without an allowance for what nothing shows."""


@dataclass(frozen=True)
class SimulationWorth:
    """What the simulation is worth."""

    explained: float
    """Share of the variance of the readings that it explains."""
    ignored: float
    """Probability that the response is better learnt without it."""
    factor: float
    """Mean of the factor that it is multiplied by."""
    factor_deviation: float
    """Standard deviation of that."""


@dataclass(frozen=True)
class Contradiction:
    """Readings that contradict the recommendation, by so many of their standard errors."""

    standing: Standing
    deviations: float


@dataclass(frozen=True)
class Outlier:
    """A reading that the others do not expect: its position, earlier experiments first, and how far it is off."""

    reading: int
    deviations: float
    set_aside: bool


@dataclass(frozen=True)
class Assessment:
    """What the experiments so far come to."""

    recommended: Standing
    """The design to build."""
    certificate: Certificate
    """How much better another may be."""
    noise: float
    """Standard deviation of one reading, as given or as learnt."""
    n_repeats: int
    """Readings beyond one per setting."""
    left: float
    """Share of all designs that may still be the best."""
    simulation: Optional[SimulationWorth]
    """What the simulation is worth; none without one, or before three readings."""
    contradiction: Optional[Contradiction]
    """Readings that contradict the recommendation."""
    outliers: List[Outlier]
    """Readings that are far off, and those that are set aside."""
    further_batches: Optional[int]
    """Batches until the certificate is expected to be as small as `worth`."""


def _of(kind: Type[T], entry: Dict[str, Any], **others: Any) -> T:
    """A dataclass from the entries that it knows."""
    fields = {field.name for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    return kind(**{**{key: value for key, value in entry.items() if key in fields}, **others})


class PooledLoop:
    """Which experiments to run next, what they taught, and when to stop.

    A response is to be made small. `n_experiments` is the size of a batch. The simulation is run wherever it is needed;
    where it is dear, `simulations` limits how many there are per batch, and `due` says which. `noise` is the standard
    deviation of a reading, where it is known. With `worth` the campaign stops once no design is better than the
    recommended one by more than this, with the probability `confidence`.

    The same seed, outcomes and simulation give the same bits, in any order, on any number of threads. One thread at a
    time may use a loop; others run while it computes.

    >>> loop = PooledLoop([Parameter("x", "mm", 0.0, 10.0, levels=11)], n_experiments=3, seed=4)
    >>> batch = loop.ask()
    >>> [trial.id for trial in batch], sorted(batch[0].settings)
    ([1, 2, 3], ['x'])
    >>> loop.tell(1, 0.25)
    >>> loop.tell(2, failed="the belt slipped")
    >>> loop.tell(3, float("nan"))
    >>> [(record.value, record.failed) for record in loop.records()]
    [(0.25, None), (None, 'the belt slipped'), (None, 'the experiment returned nan')]
    >>> loop.tell(9, 1.0)
    Traceback (most recent call last):
    infuse.Error: trial 9 was never handed out, expected one of the outstanding trials
    """

    def __init__(
        self,
        parameters: Sequence[Parameter],
        n_experiments: int,
        *,
        simulations: Optional[int] = None,
        max_batches: int = 10,
        noise: Optional[float] = None,
        worth: Optional[float] = None,
        confidence: float = 0.9,
        particles: int = 18,
        seed: int = 1,
    ) -> None:
        settings = {
            "n_experiments": n_experiments,
            "simulations": simulations,
            "max_batches": max_batches,
            "noise": noise,
            "worth": worth,
            "confidence": confidence,
            "particles": particles,
            "seed": seed,
        }
        self._loop = _native.PooledLoop(tuples_of(parameters), as_json(settings))
        self._parameters = list(parameters)

    @classmethod
    def _around(cls, loop: _native.PooledLoop) -> "PooledLoop":
        self = cls.__new__(cls)
        self._loop = loop
        self._parameters = [Parameter(*parameter) for parameter in loop.parameters()]
        return self

    @property
    def parameters(self) -> List[Parameter]:
        """What can be set."""
        return list(self._parameters)

    @property
    def _names(self) -> List[str]:
        return [parameter.name for parameter in self._parameters]

    @property
    def settings(self) -> Dict[str, Any]:
        """The settings of the loop; `change` changes them."""
        found: Dict[str, Any] = json.loads(self._loop.settings())
        return found

    def change(self, **settings: Any) -> None:
        """Other settings from the next batch on.

        >>> loop = PooledLoop([Parameter("x", "mm", 0.0, 10.0, levels=11)], n_experiments=3)
        >>> loop.change(n_experiments=5, worth=0.1)
        >>> loop.settings["n_experiments"]
        5
        """
        self._loop.set_settings(as_json({**self.settings, **settings}))

    @property
    def batch(self) -> int:
        """Number of the last batch, 0 before the first."""
        return self._loop.batch()

    @property
    def stopped(self) -> Optional[str]:
        """Why the last `ask` gave nothing: `max_batches` or `not_worth_it`."""
        return self._loop.stopped()

    @property
    def n_simulated(self) -> int:
        """Number of designs that were simulated."""
        return self._loop.n_simulated()

    @property
    def due(self) -> Floats:
        """Where simulations are dear, the designs to simulate before the next batch: n × k."""
        return self._loop.due()

    def ask(self, simulate: Optional[Simulate] = None, *, more: bool = False) -> List[Trial]:
        """The experiments to run now: those without an outcome, or else a new batch.

        `simulate` takes an array of n × k settings and returns n responses, NaN where there is none. If it raises, the
        campaign is as before. With `more` there is a new batch in any case, and its trials come last. Nothing to run
        means that simulations are `due`, or that the campaign has `stopped`.
        """
        return trials(self._names, self._loop.ask(batched(simulate), more))

    def outstanding(self) -> List[Trial]:
        """The trials without an outcome."""
        return trials(self._names, self._loop.outstanding())

    def hand_out(self, designs: Designs) -> List[Trial]:
        """Experiments that you want, as one more batch: each at the design nearest to these settings."""
        return trials(self._names, self._loop.hand_out(rows(self._names, designs)))

    def tell(self, id: int, value: Outcome = None, *, failed: Optional[str] = None) -> None:
        """The outcome of a trial: a response, or why there is none. NaN and an exception are failures."""
        number, reason = outcome(value, failed)
        self._loop.tell(id, number, reason, None, False)

    def tell_at(self, id: int, settings: Designs, value: Outcome = None, *, failed: Optional[str] = None) -> None:
        """The outcome of a trial that was made at other settings than those asked for."""
        number, reason = outcome(value, failed)
        self._loop.tell(id, number, reason, settings_row(self._parameters, settings), False)

    def correct(
        self, id: int, value: Outcome = None, *, failed: Optional[str] = None, settings: Optional[Designs] = None
    ) -> None:
        """Another outcome for a trial that had one: it was misread."""
        number, reason = outcome(value, failed)
        actual = None if settings is None else settings_row(self._parameters, settings)
        self._loop.tell(id, number, reason, actual, True)

    def tell_frame(self, table: "pandas.DataFrame", value: str = "value") -> int:
        """Takes results from a data frame with `id`, `value` and perhaps `failed`, all or nothing. How many there were.

        Rows with neither value nor reason are left out. Where the frame has a column for each parameter, settings that
        are not those asked for count as made.

        >>> loop = PooledLoop([Parameter("x", "mm", 0.0, 10.0, levels=11)], n_experiments=3, seed=4)
        >>> batch = loop.ask()
        >>> table = loop.frame()
        >>> table["value"] = [0.1, 0.2, 0.3]
        >>> loop.tell_frame(table)
        3
        """
        results = told(self._names, self.outstanding(), table, value)
        changed = self._loop.copy()
        for one in results:
            changed.tell(one.id, one.value, one.failed, one.actual, False)
        self._loop = changed
        return len(results)

    def tell_simulations(self, designs: Designs, values: ArrayLike) -> None:
        """Simulated responses at designs of the grid; NaN where there is none."""
        self._loop.tell_simulations(rows(self._names, designs), numbers(values))

    def forget_simulations(self) -> None:
        """Forgets every simulation: the simulator was changed."""
        self._loop.forget_simulations()

    def add_earlier(
        self, designs: Designs, values: Union[Outcome, ArrayLike] = None, *, failed: Optional[str] = None, source: str = ""
    ) -> None:
        """Experiments made outside of the campaign, on the grid or off it: they count as much as any other.

        >>> loop = PooledLoop([Parameter("x", "mm", 0.0, 10.0, levels=11)], n_experiments=3)
        >>> loop.add_earlier([{"x": 1.5}, {"x": 2.5}], [0.3, float("nan")], source="last year")
        >>> loop.withdraw_earlier("last year")
        2
        """
        points = rows(self._names, designs)
        if failed is not None or values is None or isinstance(values, BaseException):
            found = [outcome(values if isinstance(values, BaseException) else None, failed)] * len(points)
        else:
            found = [outcome(value, None) for value in numbers(values)]
        if len(found) != len(points):
            raise _native.Error(f"`values` has {len(found)} entries, expected {len(points)}: one per design")
        changed = self._loop.copy()
        for point, (number, reason) in zip(points.tolist(), found):
            changed.add_earlier(point, number, reason, source)
        self._loop = changed

    def withdraw_earlier(self, source: str) -> int:
        """Takes back the earlier experiments from this source. How many there were."""
        return self._loop.withdraw_earlier(source)

    def assess(self, simulate: Optional[Simulate] = None) -> Optional[Assessment]:
        """What the experiments so far come to; nothing before the first response."""
        text = self._loop.assess(batched(simulate))
        if text is None:
            return None
        found = json.loads(text)
        worth, contradiction = found["simulation"], found["contradiction"]
        against = contradiction and Contradiction(self._standing(contradiction["standing"]), contradiction["deviations"])
        return _of(
            Assessment,
            found,
            recommended=self._standing(found["recommended"]),
            certificate=_of(Certificate, found["certificate"]),
            simulation=worth and _of(SimulationWorth, worth),
            contradiction=against,
            outliers=[_of(Outlier, outlier) for outlier in found["outliers"]],
        )

    def _standing(self, entry: Dict[str, Any]) -> Standing:
        return _of(Standing, entry, settings=named(self._names, entry["point"]))

    def standings(self, designs: Designs, simulate: Optional[Simulate] = None) -> Optional[List[Standing]]:
        """What is known of designs, beside the recommended one; nothing before the first response."""
        text = self._loop.standings(rows(self._names, designs), batched(simulate))
        return None if text is None else [self._standing(entry) for entry in json.loads(text)]

    def expectations(self, designs: Designs, simulate: Optional[Simulate] = None) -> Optional[Floats]:
        """n × 3: expected response, its standard deviation, and the probability that there is one, at many designs."""
        return self._loop.expectations(rows(self._names, designs), batched(simulate))

    def surprises(self, simulate: Optional[Simulate] = None) -> Optional[Floats]:
        """How far each reading is from what all others say, in standard deviations; earlier experiments first."""
        return self._loop.surprises(batched(simulate))

    def records(self) -> List[Record]:
        """Every trial so far with its outcome."""
        return records(self._names, json.loads(self._loop.records()))

    def frame(self) -> "pandas.DataFrame":
        """Every trial so far as a data frame: `id`, `batch`, settings, `value`, `failed`."""
        return frame(self._names, self.records())

    def run(self, simulate: Optional[Simulate], experiment: Callable[[Settings], Outcome]) -> str:
        """Asks and tells until the campaign stops, and says why.

        `experiment` takes settings by name. It returns NaN or an exception for a failure; what it raises is passed on.
        """
        while self.stopped is None:
            batch = self.ask(simulate)
            due = self.due
            if len(due) > 0:
                if simulate is None:
                    raise _native.Error("simulations are due, expected a simulation")
                self.tell_simulations(due, simulate(due))
            for trial in batch:
                self.tell(trial.id, experiment(trial.settings))
        return self.stopped

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes all that the loop was told to a JSON file, which `load` reads."""
        replace(path, self._loop.to_json())

    @classmethod
    def load(cls, path: Union[str, "os.PathLike[str]"]) -> "PooledLoop":
        """A campaign from its file: it goes on with the same bits."""
        return cls._around(_native.PooledLoop.from_json(Path(path).read_text(encoding="utf-8")))

    def __repr__(self) -> str:
        told_so_far = sum(record.value is not None or record.failed is not None for record in self.records())
        return f"PooledLoop({', '.join(self._names)}: batch {self.batch}, {told_so_far} outcomes)"


def as_json(settings: Dict[str, Any]) -> str:
    """JSON of settings; NaN has none."""
    try:
        return json.dumps(settings, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise _native.Error(f"settings: {error}") from None


def replace(path: Union[str, "os.PathLike[str]"], text: str) -> None:
    """The file is whole, or as before."""
    beside = Path(f"{os.fspath(path)}.new")
    beside.write_text(text + "\n", encoding="utf-8")
    beside.replace(path)
