"""The pooled loop: every experiment and the simulation in one surface."""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Mapping, Optional, Sequence, Tuple, Type, TypeVar, Union

import numpy as np
from numpy.typing import ArrayLike

from infuse import _native
from infuse._checks import doubles, finite, missing, plain, shown, whole, word, words
from infuse._parameters import (
    Designs,
    Floats,
    Names,
    Parameter,
    Settings,
    Simulate,
    answers,
    batched,
    check_names,
    is_frame,
    numbers,
    of_tuple,
    paired,
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
    """Standard deviation of that, without the noise of a reading: wider than the surface has it while results are few."""
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

    def __post_init__(self) -> None:
        of = f"constraint `{word('constraint: `name`', self.name)}`"
        for name in ("lower", "upper", "probability", "noise"):
            value = getattr(self, name)
            if value is not None or name == "probability":
                object.__setattr__(self, name, finite(f"{of}: `{name}`", value))
        if self.lower is None and self.upper is None:
            raise _native.Error(f"{of}: neither `lower` nor `upper`, expected at least one of the two bounds")


@dataclass(frozen=True)
class LinearConstraint:
    """Settings that go together: a sum of parameters, each by its name with its factor, within bounds."""

    sum: Dict[str, float]
    lower: Optional[float] = None
    upper: Optional[float] = None

    def __post_init__(self) -> None:
        if not isinstance(self.sum, Mapping):
            raise _native.Error(f"linear constraint: `sum` is {shown(self.sum)}, expected factors by names of parameters")
        factors = {name: finite(f"linear constraint: the factor of `{name}`", one) for name, one in self.sum.items()}
        object.__setattr__(self, "sum", factors)
        for name in ("lower", "upper"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, finite(f"linear constraint: `{name}`", value))
        if not any(factors.values()):
            raise _native.Error(f"linear constraint: `sum` is {shown(factors)}, expected one factor at least that is not 0")
        if self.lower is not None and self.upper is not None and self.lower > self.upper:
            raise _native.Error(f"linear constraint: `lower` is {self.lower}, expected at most `upper`, {self.upper}")


@dataclass(frozen=True)
class Plants:
    """Which parameters are built and not typed: a batch then has few plants, and the runs of each share an error."""

    parameters: List[str]
    most: Optional[int] = None
    """At most so many plants in a batch."""
    change_costs: List[float] = dataclasses.field(default_factory=list)
    """What it costs to change each of the parameters, in experiments."""

    def __post_init__(self) -> None:
        names = words("plants: `parameters`", self.parameters, "a list of names of parameters")
        object.__setattr__(self, "parameters", names)
        if self.most is not None:
            object.__setattr__(self, "most", whole("plants: `most`", self.most, "a whole number"))
        costs = doubles("plants: `change_costs`", self.change_costs)
        if costs.ndim != 1:
            raise _native.Error(f"plants: `change_costs` is {shown(self.change_costs)}, expected a number per parameter")
        object.__setattr__(self, "change_costs", [finite("plants: `change_costs`", one) for one in costs])


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
    is_inverted: bool
    """Whether what it calls better was worse."""
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
class Doubted:
    """A reading, run once, on which the recommended design stands though the others do not expect it: its position, and what they expect there."""

    reading: int
    mean_without: float


@dataclass(frozen=True)
class Needed:
    """What a certificate waits for: so many `readings`, readings of so many different `designs`, a design that is run again, a reading that differs, or readings that tell of the parameters."""

    what: str
    """`readings`, `designs`, `repeat`, `difference`: all readings so far are equal, or `signal`: they may be noise alone."""
    count: Optional[int] = None
    """How many there have to be."""


def _needed(entry: Union[None, str, Dict[str, int]]) -> Optional[Needed]:
    if entry is None:
        return None
    if isinstance(entry, str):
        return Needed(entry)
    [(what, count)] = entry.items()
    return Needed(what, count)


@dataclass(frozen=True)
class Registration:
    """What the readings tell of how far the simulation is displaced, whether they are sure of it or not."""

    displacement: Dict[str, float]
    """The most probable one, by parameter: an experiment gives what the simulation says of a design so much farther on."""
    deviations: Dict[str, float]
    """Standard deviation of that."""
    gain: float
    """The logarithm of its probability less that of none."""
    needed: float
    """From this on it is believed."""
    explained_in_place: float
    """Squared correlation of the readings of which it tells within the bounds with what the simulation says of their own designs."""
    refused: Optional[str] = None
    """Why it is not believed, however probable it is: `too_far`, `beyond_bounds` or `one_result`."""


@dataclass(frozen=True)
class Shift:
    """By how much the runs of a batch, or of a source of earlier experiments, read above what is expected of their settings, in the mean."""

    batch: Optional[int]
    """The batch; none where they were added as earlier experiments."""
    source: Optional[str]
    """Where earlier experiments come from."""
    n_readings: int
    """How many of them gave a response."""
    by: float
    """In the unit of the response."""


@dataclass(frozen=True)
class Drift:
    """What the readings say of runs of a batch that read otherwise than those of others, sure or not."""

    gain: float
    """The logarithm of how many times more probable the readings are if batches share an error; from 4 on it is believed."""
    deviation: float
    """Standard deviation of that error."""
    noise: float
    """Standard deviation of one run besides it."""
    shifts: List[Shift]
    """Of each batch and source."""


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
    """Batches until what the campaign stops by is expected to be as small as `worth`; none without `worth`, and beyond 100, where nothing can be foretold."""
    assembly: Optional[float] = None
    """Standard deviation of the error that all runs of a plant share, where plants are told apart."""
    own: Optional[float] = None
    """As much of that may be the plants' own, and no error: what plants that were put together again do not differ by."""
    n_again: Optional[int] = None
    """How often a plant was put together again."""
    is_exact: bool = False
    """Whether readings are taken to have no noise, because that was said or because repeats do not differ at all."""
    n_left: Optional[int] = None
    """Number of designs that may still be the best, where all were looked at: of many, `left` is told from a sample."""
    doubted: Optional[Doubted] = None
    """The outlier on which the recommended design stands, if its settings were run but once: a slip, it may be."""
    smooth_refuted: bool = False
    """Whether the response is said to have no narrow well, and is not believed to: several runs of one design are far better than all others say."""
    needed: Optional[Needed] = None
    """What the certificate waits for before it says anything."""
    displacement: Optional[Dict[str, float]] = None
    """How far the simulation is displaced, by parameter: an experiment gives what it says of a design so much farther on. None if it is not."""
    registration: Optional[Registration] = None
    """What the readings tell of that, sure or not."""
    drift: Optional[Drift] = None
    """Whether the rig drifts from batch to batch, as far as the readings tell; none with `blocks=True`, which takes it in whatever they say."""
    constrained_drifts: Dict[str, Drift] = dataclasses.field(default_factory=dict)
    """The same of the constraints whose readings tell of it."""
    shifts: List[Shift] = dataclasses.field(default_factory=list)
    """By how much the runs of each batch and source read above what is expected, where an error that they share is taken in."""
    find: Optional[Settings] = None
    """The best design that was measured to be far better than runs elsewhere say, and was not looked around on all sides yet."""


def _of(kind: Type[T], entry: Dict[str, Any], **others: Any) -> T:
    """A dataclass from the entries that it knows."""
    fields = {field.name for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    return kind(**{**{key: value for key, value in entry.items() if key in fields}, **others})


def _drift(entry: Optional[Dict[str, Any]]) -> Optional[Drift]:
    if entry is None:
        return None
    return Drift(entry["gain"], entry["deviation"], entry["noise"], _shifts(entry["shifts"]))


def _shifts(entries: List[Dict[str, Any]]) -> List[Shift]:
    return [
        Shift(one["block"].get("batch"), one["block"].get("source"), one["n_readings"], one["by"]) for one in entries
    ]


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


_SETTINGS = (
    "n_experiments",
    "simulations",
    "displaced",
    "blocks",
    "max_batches",
    "noise",
    "worth",
    "stop_by",
    "smooth",
    "least",
    "confidence",
    "particles",
    "seed",
    "structures",
    "constraints",
    "linear_constraints",
    "plants",
)


def _constraint(entry: Union[Constraint, Mapping[str, Any]]) -> Dict[str, Any]:
    if isinstance(entry, Mapping):
        entry = Constraint(**entry)
    if not isinstance(entry, Constraint):
        raise _native.Error(f"`constraints` has {shown(entry)}, expected a list of `Constraint`")
    return dataclasses.asdict(entry)


def _linears(names: Sequence[str], entry: Union[LinearConstraint, Mapping[str, Any]]) -> List[Dict[str, Any]]:
    if isinstance(entry, Mapping):
        return [plain("linear constraint", entry)]
    if not isinstance(entry, LinearConstraint):
        raise _native.Error(f"`linear_constraints` has {shown(entry)}, expected a list of `LinearConstraint`")
    return _linear(names, entry)


def _listed(what: str, values: Any) -> List[Any]:
    if isinstance(values, (str, Mapping, Constraint, LinearConstraint)) or not hasattr(values, "__iter__"):
        raise _native.Error(f"`{what}` is {shown(values)}, expected a list")
    return list(values)


def _settings(parameters: Sequence[Parameter], given: Mapping[str, Any]) -> Dict[str, Any]:
    """Settings as the compiled half takes them, of what stands in Python for constraints and plants."""
    names, found = [parameter.name for parameter in parameters], dict(given)
    unknown = [name for name in found if name not in _SETTINGS]
    if unknown:
        raise _native.Error(f"setting `{unknown[0]}` is unknown, expected one of {', '.join(_SETTINGS)}")
    if "constraints" in found:
        found["constraints"] = [_constraint(one) for one in _listed("constraints", found["constraints"])]
        check_names((), [one["name"] for one in found["constraints"]])
        taken = [one["name"] for one in found["constraints"] if one["name"] in names]
        if taken:
            raise _native.Error(f"constraint `{taken[0]}` is also the name of a parameter, expected another")
    if "linear_constraints" in found:
        each = _listed("linear_constraints", found["linear_constraints"])
        found["linear_constraints"] = [one for linear in each for one in _linears(names, linear)]
    plants = found.get("plants")
    if isinstance(plants, Plants):
        found["plants"] = _plants(names, plants)
    elif plants is not None and not isinstance(plants, Mapping):
        raise _native.Error(f"`plants` is {shown(plants)}, expected `Plants`")
    return found


class PooledLoop:
    """Which experiments to run next, what they taught, and when to stop.

    A response is to be made small. `n_experiments` is the size of a batch. The simulation is run wherever it is needed;
    where it is dear, `simulations` limits how many there are per batch, and `due` says which. It may be displaced: right of
    another design than of the one it is asked for. How far is learnt, unless `displaced` is false. Runs of a batch
    share an error, as where a rig drifts from day to day, with `blocks=True`, and without `blocks` as soon as the readings are sure of it.
    `noise` is the standard deviation of a reading, where it is known. With `worth` the campaign stops once no design is better than the
    recommended one by more than this, with the probability `confidence`; with `stop_by="surface"` once the surface alone says so,
    a batch or two earlier, and too early where the response has a narrow well that nobody has met. `smooth` says that the response surely has no
    narrow well, for which the certificate otherwise holds something in reserve, and `least` that no response can be less.

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
        displaced: bool = True,
        blocks: Optional[bool] = None,
        max_batches: int = 10,
        noise: Optional[float] = None,
        worth: Optional[float] = None,
        stop_by: str = "bound",
        smooth: bool = False,
        least: Optional[float] = None,
        confidence: float = 0.9,
        particles: int = 18,
        seed: int = 1,
        constraints: Sequence[Constraint] = (),
        linear_constraints: Sequence[LinearConstraint] = (),
        plants: Optional[Plants] = None,
    ) -> None:
        check_names(parameters)
        settings: Dict[str, Any] = {
            "n_experiments": n_experiments,
            "simulations": simulations,
            "displaced": displaced,
            "blocks": blocks,
            "max_batches": max_batches,
            "noise": noise,
            "worth": worth,
            "stop_by": stop_by,
            "smooth": smooth,
            "least": least,
            "confidence": confidence,
            "particles": particles,
            "seed": seed,
            "constraints": constraints,
            "linear_constraints": linear_constraints,
            "plants": plants,
        }
        self._loop = _native.PooledLoop(tuples_of(parameters), as_json(_settings(parameters, settings)))
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

    @property
    def _constraints(self) -> List[str]:
        return [constraint["name"] for constraint in self.settings.get("constraints", [])]

    def change(self, **settings: Any) -> None:
        """Other settings from the next batch on, as they are given to begin with: `constraints` as a list of `Constraint`.

        A constraint of which something was told or simulated stays, in its place; its bounds may change, and others may
        follow.

        >>> loop = PooledLoop([Parameter("x", "mm", 0.0, 10.0, levels=11)], n_experiments=3)
        >>> loop.change(n_experiments=5, worth=0.1)
        >>> loop.settings["n_experiments"]
        5
        """
        new = _settings(self._parameters, settings)
        if "constraints" in new:
            before, after = self._constraints, [one["name"] for one in new["constraints"]]
            if after[: len(before)] != before and self._loop.has_constrained():
                of = f"{', '.join(before)} first: values of them are known"
                raise _native.Error(f"constraints: {', '.join(after) or 'none'}, expected {of}")
        self._loop.set_settings(as_json({**self.settings, **new}))

    @property
    def batch(self) -> int:
        """Number of the last batch, 0 before the first."""
        return self._loop.batch()

    @property
    def stopped(self) -> Optional[str]:
        """Why the last `ask` gave nothing: `batch_limit` or `not_worth_it`."""
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

        `simulate` takes an array of n × k settings and returns n responses, or with c constraints n × (1 + c); NaN where
        there is none. If it raises, the campaign is as before; so it is after Ctrl-C, which ends the call at once. With `more`
        there is a new batch in any case, and its trials come last. Nothing to run means that simulations are `due`, or that
        the campaign has `stopped`.
        """
        if not isinstance(more, (bool, np.bool_)):
            raise _native.Error(f"`more` is {shown(more)}, expected True or False")
        return trials(self._names, self._loop.ask(self._batched(simulate), bool(more)))

    def _batched(self, simulate: Optional[Simulate]) -> Optional[Callable[[Floats], Floats]]:
        return batched(simulate, self._constraints)

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
        constrained: Optional[Mapping[str, Optional[float]]] = None,
    ) -> None:
        """The outcome of a trial: a response, or why there is none. NaN and an exception are failures.

        `constrained` holds what was measured of the constraints, by their names.

        >>> spring = Parameter("x", "mm", 0.0, 10.0, levels=11)
        >>> loop = PooledLoop([spring], n_experiments=3, constraints=[Constraint("travel", upper=12.0)])
        >>> for trial, travel in zip(loop.ask(), [11.5, 11.2, 10.9]):
        ...     loop.tell(trial.id, 0.25, constrained={"travel": travel})
        >>> loop.assess().recommended.constrained[0].within > 0.5
        True
        """
        self._tell(id, outcome(value, failed), None, constrained)

    def _tell(
        self,
        id: int,
        found: Tuple[Optional[float], Optional[str]],
        actual: Optional[List[float]],
        constrained: Optional[Mapping[str, Optional[float]]],
    ) -> None:
        """All or nothing."""
        number, (value, reason) = whole("`id`", id, "the number of a trial"), found
        changed = self._loop.copy()
        changed.tell(number, value, reason, actual, False)
        if constrained is not None:
            changed.tell_constrained(number, self._in_order(number, constrained))
        self._loop = changed

    def tell_constrained(self, id: int, values: Mapping[str, Optional[float]]) -> None:
        """What was measured of the constraints of a trial, by their names: before or after its outcome, or to correct it.

        What is not named stays as it was; NaN or `None` is nothing measured.
        """
        number = whole("`id`", id, "the number of a trial")
        self._loop.tell_constrained(number, self._in_order(number, values))

    def _in_order(self, id: int, values: Mapping[str, Optional[float]]) -> List[Optional[float]]:
        known = dict(zip(self._constraints, self._loop.constrained().get(id, [])))
        return [self._one(values, name, known.get(name)) for name in self._checked(values)]

    def _checked(self, values: Mapping[str, Any]) -> List[str]:
        """The names of the constraints, if those of the values are some of them."""
        if not isinstance(values, Mapping):
            raise _native.Error(f"constrained: {shown(values)}, expected numbers by the names of constraints")
        names = self._constraints
        unknown = [name for name in values if name not in names]
        if unknown:
            of = ", ".join(names) or "none: there is no constraint"
            raise _native.Error(f"constrained: `{unknown[0]}` is no constraint, expected {of}")
        return names

    @staticmethod
    def _one(values: Mapping[str, Optional[float]], name: str, known: Optional[float]) -> Optional[float]:
        if name not in values:
            return known
        return None if missing(values[name]) else finite(f"constrained: `{name}`", values[name])

    def tell_at(
        self,
        id: int,
        settings: Designs,
        value: Outcome = None,
        *,
        failed: Optional[str] = None,
        constrained: Optional[Mapping[str, Optional[float]]] = None,
    ) -> None:
        """The outcome of a trial that was made at other settings than those asked for."""
        self._tell(id, outcome(value, failed), settings_row(self._parameters, settings), constrained)

    def correct(
        self, id: int, value: Outcome = None, *, failed: Optional[str] = None, settings: Optional[Designs] = None
    ) -> None:
        """Another outcome for a trial that had one: it was misread."""
        number, reason = outcome(value, failed)
        actual = None if settings is None else settings_row(self._parameters, settings)
        self._loop.tell(whole("`id`", id, "the number of a trial"), number, reason, actual, True)

    def tell_frame(self, table: "pandas.DataFrame", value: str = "value") -> int:
        """Takes results from a data frame as `frame` gives it, all or nothing. How many rows said something new.

        It needs `id` and `value`, may have `failed`, a column per constraint, and one per parameter; settings that are not
        those asked for then count as made. Other columns are refused. Empty cells (NaN, `None`, what pandas has for them) say
        nothing, and rows that say what is known already are passed over.

        >>> loop = PooledLoop([Parameter("x", "mm", 0.0, 10.0, levels=11)], n_experiments=3, seed=4)
        >>> batch = loop.ask()
        >>> table = loop.frame()
        >>> table["value"] = [0.1, 0.2, 0.3]
        >>> loop.tell_frame(table)
        3
        """
        results = told(self._names, self._constraints, self.records(), table, value)
        changed = self._loop.copy()
        for one in results:
            if one.outcome is not None:
                changed.tell(one.id, *one.outcome, one.actual, False)
            if one.constrained is not None:
                changed.tell_constrained(one.id, one.constrained)
        self._loop = changed
        return len(results)

    def tell_simulations(self, designs: Designs, values: ArrayLike) -> None:
        """Simulated responses at designs of the grid, in the shapes of a simulation's answer; NaN where there is none."""
        points, found = rows(self._names, designs), paired(designs, values)
        each = [found] if len(points) == 1 and np.ndim(found) == 0 and found is not None else found
        self._loop.tell_simulations(points, answers(each, len(points), self._constraints, "`values` is").tolist())

    def forget_simulations(self) -> None:
        """Forgets every simulation: the simulator was changed."""
        self._loop.forget_simulations()

    def add_earlier(
        self,
        designs: Designs,
        values: Union[Outcome, ArrayLike] = None,
        *,
        failed: Optional[str] = None,
        constrained: Optional[Mapping[str, Optional[ArrayLike]]] = None,
        source: str = "",
    ) -> None:
        """Experiments made outside of the campaign, on the grid or off it: they count as much as any other.

        `constrained` has what was measured of the constraints, one value per design; NaN is nothing measured.

        >>> loop = PooledLoop([Parameter("x", "mm", 0.0, 10.0, levels=11)], n_experiments=3)
        >>> loop.add_earlier([{"x": 1.5}, {"x": 2.5}], [0.3, float("nan")], source="last year")
        >>> loop.withdraw_earlier("last year")
        2
        """
        points = rows(self._names, designs)
        if failed is not None or values is None or isinstance(values, BaseException):
            found = [outcome(values if isinstance(values, BaseException) else None, failed)] * len(points)
        else:
            found = [outcome(value, None) for value in numbers(paired(designs, values))]
        if len(found) != len(points):
            raise _native.Error(f"`values` has {len(found)} entries, expected {len(points)}: one per design")
        others = self._earlier(designs, len(points), constrained or {})
        changed = self._loop.copy()
        for point, (number, reason), of_one in zip(points.tolist(), found, others):
            if reason is not None and any(one is not None for one in of_one):
                raise _native.Error(f"constrained: {of_one}, expected nothing for an earlier experiment that failed")
            changed.add_earlier(point, number, reason, word("`source`", source), of_one)
        self._loop = changed

    def _earlier(
        self, designs: Designs, n: int, values: Mapping[str, Optional[ArrayLike]]
    ) -> List[List[Optional[float]]]:
        """Constrained values of n designs, each in the order of the constraints; none at all where none is given."""
        columns_of: Any = designs
        left = [name for name in self._constraints if is_frame(designs) and name in columns_of.columns]
        for name in left:
            if name not in values:
                raise _native.Error(f"data frame: column `{name}` is a constraint, expected its values in `constrained`")
        if not values:
            return [[] for _ in range(n)]
        columns: List[List[float]] = []
        for name in self._checked(values):
            of_one = values.get(name)
            column = [np.nan] * n if of_one is None else numbers(paired(designs, of_one), f"constrained: `{name}`")
            if len(column) != n:
                raise _native.Error(f"constrained: `{name}` has {len(column)} entries, expected {n}: one per design")
            columns.append(column)
        return [[None if missing(one) else one for one in of_one] for of_one in zip(*columns)]

    def withdraw_earlier(self, source: str) -> int:
        """Takes back the earlier experiments from this source. How many there were."""
        return self._loop.withdraw_earlier(word("`source`", source))

    def assess(self, simulate: Optional[Simulate] = None) -> Optional[Assessment]:
        """What the experiments so far come to; nothing before the first response."""
        text = self._loop.assess(self._batched(simulate))
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
            doubted=_of(Doubted, found["doubted"]) if "doubted" in found else None,
            needed=_needed(found.get("needed")),
            find=named(self._names, found["find"]) if "find" in found else None,
            displacement=self._displacement(found.get("displacement")),
            registration=self._registration(found.get("registration")),
            drift=_drift(found.get("drift")),
            constrained_drifts=self._constrained_drifts(found.get("constrained_drifts", [])),
            shifts=_shifts(found.get("shifts", [])),
        )

    def _displacement(self, found: Optional[List[float]]) -> Optional[Dict[str, float]]:
        return None if found is None else {name: by for name, by in zip(self._names, found) if by != 0.0}

    def _constrained_drifts(self, found: List[Optional[Dict[str, Any]]]) -> Dict[str, Drift]:
        drifts = ((name, _drift(one)) for name, one in zip(self._constraints, found))
        return {name: drift for name, drift in drifts if drift is not None}

    def _registration(self, found: Optional[Dict[str, Any]]) -> Optional[Registration]:
        if found is None:
            return None
        by_name = {key: named(self._names, found[key]) for key in ("displacement", "deviations")}
        return _of(Registration, found, **by_name)

    def _standing(self, entry: Dict[str, Any]) -> Standing:
        of_each = [_constrained(one) for one in entry.get("constrained", [])]
        return _of(Standing, entry, settings=named(self._names, entry["point"]), constrained=of_each)

    def standings(self, designs: Designs, simulate: Optional[Simulate] = None) -> Optional[List[Standing]]:
        """What is known of designs, beside the recommended one; nothing before the first response."""
        text = self._loop.standings(rows(self._names, designs), self._batched(simulate))
        return None if text is None else [self._standing(entry) for entry in json.loads(text)]

    def expectations(self, designs: Designs, simulate: Optional[Simulate] = None) -> Optional[Floats]:
        """n × 3: expected response, its standard deviation, and the probability that there is one, at many designs."""
        return self._loop.expectations(rows(self._names, designs), self._batched(simulate))

    def surprises(self, simulate: Optional[Simulate] = None) -> Optional[Floats]:
        """How far each reading is from what all others say, in standard deviations; earlier experiments first."""
        return self._loop.surprises(self._batched(simulate))

    def records(self) -> List[Record]:
        """Every trial so far with its outcome."""
        return records(self._names, json.loads(self._loop.records()), self._constraints, self._loop.constrained())

    def frame(self) -> "pandas.DataFrame":
        """Every trial so far as a data frame: `id`, `batch`, settings, `value`, a column per constraint, `failed`."""
        return frame(self._names, self.records(), self._constraints)

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
                call = batched(simulate, self._constraints)
                self._loop.tell_simulations(due, [] if call is None else call(due).tolist())
            for trial in batch:
                self.tell(trial.id, experiment(trial.settings))
        return self.stopped

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes all that the loop was told to a JSON file, which `load` reads."""
        replace(path, self._loop.to_json())

    @classmethod
    def load(cls, path: Union[str, "os.PathLike[str]"]) -> "PooledLoop":
        """A campaign from its file: it goes on with the same bits."""
        return read(path, cls._of_json)

    @classmethod
    def _of_json(cls, text: str) -> "PooledLoop":
        return cls._around(_native.PooledLoop.from_json(text))

    def __reduce__(self) -> Tuple[Any, ...]:
        return type(self)._of_json, (self._loop.to_json(),)

    def __copy__(self) -> "PooledLoop":
        return self._around(self._loop.copy())

    def __deepcopy__(self, memo: Any) -> "PooledLoop":
        return self._around(self._loop.copy())

    def __repr__(self) -> str:
        told_so_far = sum(record.value is not None or record.failed is not None for record in self.records())
        return f"PooledLoop({', '.join(self._names)}: batch {self.batch}, {told_so_far} outcomes)"


_WHOLE = (
    "n_experiments",
    "n_simulations",
    "simulations",
    "max_batches",
    "particles",
    "seed",
    "replicates",
    "first_screening",
    "design_starts",
    "candidate_limit",
)
_FINITE = ("noise", "worth", "confidence", "experiment_weight", "simulation_weight")
_OPTIONAL = ("simulations", "noise", "worth")


def as_json(settings: Mapping[str, Any]) -> str:
    """JSON of settings; numpy's numbers are numbers, NaN and infinities are none."""

    def one(name: str, value: Any) -> Any:
        if value is None and name in _OPTIONAL:
            return None
        if name in _WHOLE:
            return whole(f"setting `{name}`", value)
        return finite(f"setting `{name}`", value) if name in _FINITE else plain(f"setting `{name}`", value)

    return json.dumps({name: one(name, value) for name, value in settings.items()}, allow_nan=False)


def replace(path: Union[str, "os.PathLike[str]"], text: str) -> None:
    """The file is whole, or as before."""
    beside = Path(f"{os.fspath(path)}.new")
    beside.write_text(text + "\n", encoding="utf-8")
    beside.replace(path)


def read(path: Union[str, "os.PathLike[str]"], of_json: Callable[[str], T]) -> T:
    """A campaign from a file, which errors name."""
    try:
        return of_json(Path(path).read_text(encoding="utf-8"))
    except UnicodeDecodeError as error:
        raise _native.Error(f"{os.fspath(path)}: no text ({error.reason} at byte {error.start})") from None
    except _native.Error as error:
        raise _native.Error(f"{os.fspath(path)}: {error}") from None
