"""Identifiable parameters of a problem's noise, before anything is fitted."""

from dataclasses import dataclass, replace

import numpy as np

from objectives import HeavyTails, PartlyWrong, kind_of
from tuner.identifiability.least_squares import Estimate, estimate, estimate_of_most
from tuner.identifiability.linear_form import linear_problem
from tuner.identifiability.noise import Entry, NoModelError
from tuner.identifiability.rank import rank_of, sentences
from tuner.identifiability.windows import differences
from tuner.problem.parameters import Bounded, Covariance, Limited, Parameter, Positive
from tuner.problem.problem import Problem


@dataclass(frozen=True, eq=False)
class Determined:
    """The noise parameters that the differences of a record's measurements determine.

    Attributes:
        entries: the numbers that enter the noise, by name, as R, Q12 or sigma^2.
        rank: number of combinations that are determined; with as many as entries, all are.
        undetermined: combinations along which nothing that is measured changes,
            ``(len(entries) - rank, len(entries))``.
        sentences: the same in words; none where all is determined.
        values: the least-squares estimate of each, not negative.
        deviations: of these, if noise is normal and the model right; infinite if undetermined.
        start: the point z ``(size,)`` of the estimate, within the box; the other parameters at
            their initial values.
    """

    entries: tuple[str, ...]
    rank: int
    undetermined: np.ndarray
    sentences: tuple[str, ...]
    values: dict[str, float]
    deviations: dict[str, float]
    start: np.ndarray


def determined(problem: Problem) -> Determined:
    """Which entries of Q and R a linear model's measurements determine, and their estimates.

    Nothing is fitted and no likelihood is evaluated: differences of neighbouring measurements do
    not depend on the state, and their covariances are linear in those of the noise. Missing
    samples, varying steps, known inputs and several recordings are taken as they are. The start's
    own parameters (P0) are left out, for they concern the first samples alone. Where the problem
    expects measurements that are wrong (a gate, Student's t), the estimate is that of the better
    half of the record.

    Args:
        problem: of :class:`filters.LinearKalman`, or of a filter with the methods ``linear`` and
            ``measured``, judged by its innovations.

    Raises:
        ValueError: for other filters, free parameters beside the noise, and too few measurements.

    >>> from filters import LevelSample, LocalLevel
    >>> from objectives import Data, InnovationLikelihood
    >>> from tuner import Space
    >>> rng = np.random.default_rng(1)
    >>> z = np.cumsum(rng.standard_normal(400)) + 2.0 * rng.standard_normal(400)
    >>> space, data = Space.of_filter(LocalLevel), Data(LevelSample(z), np.zeros(400))
    >>> problem = Problem("level", space, LocalLevel(1.0), None, InnovationLikelihood(), data)
    >>> found = determined(problem)
    >>> found.rank, found.sentences
    (2, ())
    >>> all(abs(found.values[k] - v) < 3 * found.deviations[k] for k, v in {"q": 1, "R": 4}.items())
    True
    """
    if kind_of(problem.objective) != "likelihood":
        raise NoModelError(
            f"{problem.name} is not judged by the likelihood of its innovations, and "
            "identifiability by another objective is not known beforehand"
        )
    linear = linear_problem(problem)
    taken = differences(linear.recordings)
    rank = rank_of(taken)
    names = tuple(entry.name for entry in linear.entries)
    single = tuple("" if e.place else e.parameter for e in linear.entries)
    wrong = isinstance(getattr(problem.objective, "law", None), HeavyTails | PartlyWrong)
    found = (estimate_of_most if wrong else estimate)(taken, linear.entries)
    return Determined(
        names,
        rank.rank,
        rank.undetermined,
        sentences(rank, names, single),
        dict(zip(names, found.values.tolist(), strict=True)),
        dict(zip(names, found.deviations.tolist(), strict=True)),
        _start(problem, linear.entries, found),
    )


def with_known_start(problem: Problem) -> Problem:
    """The problem with the estimate of :func:`determined` before its other known starts.

    Raises:
        ValueError: as :func:`determined`.
    """
    first = determined(problem).start
    return replace(problem, known_starts=(first, *problem.known_starts))


def _start(problem: Problem, entries: tuple[Entry, ...], found: Estimate) -> np.ndarray:
    """The start at the estimate; an entry that may be 0 begins at its deviation."""
    values = problem.parameters(problem.space.start())
    given = {}
    for name, parameter in problem.space.parameters:
        mine = [i for i, e in enumerate(entries) if e.parameter == name]
        if not mine:
            continue
        value = np.array(values[name], float)
        for i in mine:
            number, spread, entry = found.values[i], found.deviations[i], entries[i]
            if len(set(entry.place)) < 2 and np.isfinite(spread):
                number = max(number, spread)
            for index in {entry.place, entry.place[::-1]}:
                value[index] = number ** (1 / entry.power)
        given[name] = _within_range(parameter, value)
    low, high = problem.space.box()
    return np.asarray(np.clip(problem.space.unconstrain(given), low, high))


def _within_range(parameter: Parameter, value: np.ndarray) -> np.ndarray:
    """The value, or the nearest one within the parameter's range."""
    if isinstance(parameter, Covariance):
        scale = np.sqrt(np.maximum(np.diag(value), parameter.low**2))
        values, V = np.linalg.eigh(value / np.outer(scale, scale))
        kept = (V * np.maximum(values, 1e-3)) @ V.T * np.outer(scale, scale)
        return np.asarray((kept + kept.T) / 2)
    if isinstance(parameter, Positive | Limited | Bounded):
        edge = 1e-3 * (parameter.high - parameter.low) if isinstance(parameter, Bounded) else 0.0
        return np.asarray(np.clip(value, parameter.low + edge, parameter.high - edge))
    return value
