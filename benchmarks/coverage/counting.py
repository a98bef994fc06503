"""Coverage of the intervals of a setting's records."""

import warnings
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from benchmarks.coverage.oracle import covers, fit, limits, sandwich
from benchmarks.coverage.settings import SETTINGS, Setting, level_problem
from benchmarks.coverage.simulated import NILE
from tuner import Gradient, Positive, Solution, Space

LOW, HIGH = 0.92, 0.98
LAGS = 5
"""Samples over which the oracle's scores are taken to be correlated."""
Interval: TypeAlias = tuple[float, float] | None


@dataclass(frozen=True)
class Covered:
    """One parameter of one setting.

    Attributes:
        setting, parameter: which.
        truth: the value to contain.
        interval, robust: shares of the records whose interval contains it; a missing interval
            does not.
        oracle: the same by the oracle's likelihood ratios and by its robust limits; None where
            it has no filter.
        missing: records without one of them.
        one_sided: records whose interval is open to one side.
        kinds: the declared kinds of the intervals.
        holds: whether the shares are as promised, where there is a promise.
    """

    setting: str
    parameter: str
    truth: float
    interval: float
    robust: float
    oracle: tuple[float, float] | None
    missing: int
    one_sided: int
    kinds: str
    holds: bool


def covered(setting: Setting, seed: int, count: int) -> list[Covered]:
    """Fit every record of a setting."""
    solver, truth = Gradient("l-bfgs-b", seed=0, starts=1), setting.truth()
    records = setting.records(seed, count)
    solutions = [solver(setting.problem(record)) for record in records]
    return [
        _covered(setting, solutions, name, true, oracle)
        for (name, true), oracle in zip(truth.items(), _by_oracle(setting, records), strict=True)
    ]


def _by_oracle(setting: Setting, records: np.ndarray) -> list[tuple[float, float] | None]:
    if setting.filter != "level":
        return [None, None]
    true = np.log(list(setting.truth().values()))
    fitted = fit(records, np.tile(true, (len(records), 1)))
    within = np.abs(fitted.at - true) <= sandwich(records, fitted, LAGS)
    shares = np.stack([covers(records, fitted, true), within]).mean(axis=1)
    return [(float(plain), float(robust)) for plain, robust in shares.T]


def counted(part: tuple[int, int, int]) -> list[Covered]:
    """:func:`covered` of the setting with an index, seed and count: one process's work."""
    index, seed, count = part
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return covered(SETTINGS[index], seed, count)


def _covered(
    setting: Setting,
    solutions: list[Solution],
    name: str,
    true: float,
    oracle: tuple[float, float] | None,
) -> Covered:
    found = [solution.parameters[name] for solution in solutions]
    plain, robust = [p.interval for p in found], [p.robust for p in found]
    kinds = Counter(p.interval_kind for p in found)
    shares = share(plain, true), share(robust, true)
    judged = shares if setting.noise == "white" else shares[1:]
    return Covered(
        setting.name,
        name,
        true,
        *shares,
        oracle,
        missing=sum(a is None or b is None for a, b in zip(plain, robust, strict=True)),
        one_sided=sum(i is not None and (i[0] == 0 or np.isinf(i[1])) for i in plain),
        kinds=", ".join(f"{n} {kind}" for kind, n in kinds.items()),
        holds=setting.noise == "student 4" or all(LOW <= s <= HIGH for s in judged),
    )


def share(intervals: Sequence[Interval], true: float) -> float:
    """The share of intervals that contain a value.

    >>> share([(0.0, 2.0), (3.0, 4.0), None, (1.0, float("inf"))], 1.0)
    0.5
    """
    held = [i is not None and i[0] <= true <= i[1] for i in intervals]
    return float(np.mean(held))


def off_profile(seed: int, count: int) -> float:
    """Largest deviation of local levels' limits from their profile's, as a share."""
    if not count:
        return 0.0
    setting = SETTINGS[0]
    solver = Gradient("l-bfgs-b", seed=0, starts=1)
    return max(
        _off(solver(setting.problem(record)), record) for record in setting.records(seed, count)
    )


@dataclass(frozen=True)
class Flow:
    """The Nile's limits in words, and their deviation from the profile's, as a share."""

    words: str
    off: float


def nile() -> Flow:
    """A local level of the Nile's flow."""
    space = Space.of(q=Positive(100.0, 1e-6, 1e8), R=Positive(100.0, 1e-6, 1e8))
    solution = Gradient("l-bfgs-b", seed=0, starts=4)(level_problem(NILE, space))
    words = ", ".join(
        f"{name} = {float(p.value):.5g} {p.interval}" for name, p in solution.parameters.items()
    )
    return Flow(words, _off(solution, NILE))


def _off(solution: Solution, record: np.ndarray) -> float:
    """The largest relative difference between a solution's limits and the profile's.

    Both at 0 or without end agree; where one of them is, the other is off by all.
    """
    _, expected = limits(record)
    actual = [solution.parameters[name].interval or (np.nan, np.nan) for name in ("q", "R")]
    a, b = np.ravel(actual), np.ravel(expected)
    open_ = (b == 0) | np.isinf(b)
    apart = np.where(open_, np.where(a == b, 0.0, 1.0), np.abs(a / np.where(open_, 1.0, b) - 1))
    return float(np.where(np.isnan(apart), 1.0, apart).max())
