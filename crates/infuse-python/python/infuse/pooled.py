"""The pooled loop: every experiment and the simulation in one surface."""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Mapping, Optional, Sequence, Type, TypeVar, Union

from numpy.typing import ArrayLike

from infuse import _native
from infuse._parameters import (
    Designs,
    Floats,
    Names,
    Parameter,
    Settings,
    Simulate,
    batched,
    numbers,
    of_tuple,
    rows,
    tuples_of,
)
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
    suffices: bool = True
    """Whether it keeps to every constraint with the probability that is asked for, and is likely to give a response."""
    constrained: List["Constrained"] = dataclasses.field(default_factory=list)
    """Each constrained response there, in the order of the constraints."""


@dataclass(frozen=True)
class Constrained:
    """What is known of a constrained response at one design."""

    mean: Optional[float]
    """What is expected; none before its first reading."""
    deviation: Optional[float]
    """Standard deviation of that, without the noise of a reading."""
    within: float
    """Probability that the design keeps to the bounds."""
    measured: Optional[float]
    """Mean of its readings there."""


@dataclass(frozen=True)
class Constraint:
    """A second response, which has to stay within bounds: at least one of them."""

    name: str
    lower: Optional[float] = None
    upper: Optional[float] = None
    probability: float = 0.9
    """A design is recommended if it keeps to the bounds with this probability."""
    noise: Optional[float] = None
    """Standard deviation of one reading, where it is known."""


@dataclass(frozen=True)
class LinearConstraint:
    """Settings that go together: a sum of parameters, each by its name with its factor, within bounds."""

    sum: Dict[str, float]
    lower: Optional[float] = None
    upper: Optional[float] = None


@dataclass(frozen=True)
class Plants:
    """Which parameters are built and not typed: a batch then has few plants, and the runs of each share an error."""

    parameters: List[str]
    most: Optional[int] = None
    """At most so many plants in a batch."""
    change_costs: List[float] = dataclasses.field(default_factory=list)
    """What it costs to change each of the parameters, in experiments."""


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
    assembly: Optional[float] = None
    """Standard deviation of the error that all runs of a plant share, where plants are told apart."""


def _of(kind: Type[T], entry: Dict[str, Any], **others: Any) -> T:
    """A dataclass from the entries that it knows."""
    fields = {field.name for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    return kind(**{**{key: value for key, value in entry.items() if key in fields}, **others})


def _constrained(entry: Dict[str, Any]) -> Constrained:
    mean, deviation = entry["expected"] or (None, None)
    return Constrained(mean, deviation, entry["within"], entry["measured"])


def _place(names: Sequence[str], name: str, of: str) -> int:
    if name not in names:
        raise _native.Error(f"{of}: `{name}` is no parameter, expected {', '.join(names)}")
    return list(names).index(name)


def _linear(names: Sequence[str], linear: LinearConstraint) -> List[Dict[str, Any]]:
    """One with two bounds makes two."""
    coefficients = [0.0] * len(names)
    for name, factor in linear.sum.items():
        coefficients[_place(names, name, "linear constraint")] = factor
    if linear.lower is None and linear.upper is None:
        raise _native.Error("linear constraint: neither `lower` nor `upper`, expected one of them or both")
    found: List[Dict[str, Any]] = []
    if linear.lower is not None:
        found.append({"coefficients": [-factor for factor in coefficients], "upper": -linear.lower})
    if linear.upper is not None:
        found.append({"coefficients": coefficients, "upper": linear.upper})
    return found


def _plants(names: Sequence[str], plants: Plants) -> Dict[str, Any]:
    places = [_place(names, name, "plants") for name in plants.parameters]
    return {"parameters": places, "most": plants.most, "change_costs": list(plants.change_costs)}


class PooledLoop:
    """Which experiments to run next, what they taught, and when to stop.

    A response is to be made small. `n_experiments` is the size of a batch. The simulation is run wherever it is needed;
    where it is dear, `simulations` limits how many there are per batch, and `due` says which. `noise` is the standard
    deviation of a reading, where it is known. With `worth` the campaign stops once no design is better than the
    recommended one by more than this, with the probability `confidence`.

    With `constraints` further responses have to stay within bounds; a simulation then gives n rows, the response first and
    one column for each constraint behind it. `linear_constraints` keep settings together, and `plants` says what is built.

    The same seed, outcomes and simulation give the same bits, in any order, on any number of threads, on one machine
    with one package. One thread at a time may use a loop; others run while it computes.

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
        constraints: Sequence[Constraint] = (),
        linear_constraints: Sequence[LinearConstraint] = (),
        plants: Optional[Plants] = None,
    ) -> None:
        names = [parameter.name for parameter in parameters]
        settings: Dict[str, Any] = {
            "n_experiments": n_experiments,
            "simulations": simulations,
            "max_batches": max_batches,
            "noise": noise,
            "worth": worth,
            "confidence": confidence,
            "particles": particles,
            "seed": seed,
            "constraints": [dataclasses.asdict(constraint) for constraint in constraints],
            "linear_constraints": [one for linear in linear_constraints for one in _linear(names, linear)],
            "plants": plants and _plants(names, plants),
        }
        self._loop = _native.PooledLoop(tuples_of(parameters), as_json(settings))
        self._parameters = list(parameters)

    @classmethod
    def _around(cls, loop: _native.PooledLoop) -> "PooledLoop":
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

    def tell(
        self,
        id: int,
        value: Outcome = None,
        *,
        failed: Optional[str] = None,
        constrained: Optional[Mapping[str, float]] = None,
    ) -> None:
        """The outcome of a trial: a response, or why there is none. NaN and an exception are failures.

        `constrained` holds what was measured of the constraints, by their names.

        >>> spring = Parameter("x", "mm", 0.0, 10.0, levels=11)
        >>> loop = PooledLoop([spring], n_experiments=3, constraints=[Constraint("travel", upper=12.0)])
        >>> trial = loop.ask()[0]
        >>> loop.tell(trial.id, 0.25, constrained={"travel": 11.5})
        >>> loop.assess().recommended.constrained[0].within > 0.5
        True
        """
        number, reason = outcome(value, failed)
        changed = self._loop.copy()
        changed.tell(id, number, reason, None, False)
        if constrained is not None:
            changed.tell_constrained(id, self._in_order(constrained))
        self._loop = changed

    def tell_constrained(self, id: int, values: Mapping[str, float]) -> None:
        """What was measured of the constraints of a trial, by their names: before or after its outcome, or to correct it."""
        self._loop.tell_constrained(id, self._in_order(values))

    def _in_order(self, values: Mapping[str, float]) -> List[Optional[float]]:
        names: List[str] = [constraint["name"] for constraint in self.settings.get("constraints", [])]
        unknown = [name for name in values if name not in names]
        if unknown:
            known = ", ".join(names) or "none: there is no constraint"
            raise _native.Error(f"constrained: `{unknown[0]}` is no constraint, expected {known}")
        return [float(values[name]) if name in values else None for name in names]

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
        of_each = [_constrained(one) for one in entry.get("constrained", [])]
        return _of(Standing, entry, settings=named(self._names, entry["point"]), constrained=of_each)

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
