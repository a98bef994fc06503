"""All tests of a filter's innovations, in one pass."""

from dataclasses import dataclass

from tuner.diagnostics.beginning import of_start
from tuner.diagnostics.column import PARTS, Varying
from tuner.diagnostics.finding import Finding
from tuner.diagnostics.innovations import Innovations
from tuner.diagnostics.outliers import of_outliers
from tuner.diagnostics.size import NOTHING, of_size, size
from tuner.diagnostics.spread import over_level, over_time
from tuner.diagnostics.turns import of_turns
from tuner.diagnostics.whiteness import lag_one, of_whiteness


@dataclass(frozen=True)
class Remedies:
    """The remedy for each failure, in words that end a sentence.

    Attributes:
        outliers, turns, start, level, time, whiteness: of the tests by these names.
    """

    outliers: str = "fit with --set gate=4, which rejects them"
    turns: str = "unwrap it first (numpy.unwrap)"
    start: str = "begin where the data begin, or with a larger variance"
    level: str = "give each measurement's own deviation"
    time: str = "tune the parts separately (--from, --to)"
    whiteness: str = (
        "the model lacks a motion, or the noise of the measurement is coloured; try a model of one "
        "state more"
    )


@dataclass(frozen=True)
class Diagnostics:
    """The consistency of a filter with its innovations.

    Attributes:
        nis: mean of y^2 / s over the numbers that count; 1 where the filter is right.
        low, high: in which 95 of 100 right filters have it.
        factor: by which all noise variances would have to be multiplied, by likelihood.
        factor_low, factor_high: its 95 % interval.
        lag_one: correlation of each normalised innovation with the one before; 0 if white.
        numbers: how many numbers count.
        findings: every test, causes before their effects.
    """

    nis: float
    low: float
    high: float
    factor: float
    factor_low: float
    factor_high: float
    lag_one: float
    numbers: int
    findings: tuple[Finding, ...]

    @property
    def failed(self) -> tuple[Finding, ...]:
        """The tests that failed."""
        return tuple(found for found in self.findings if found.verdict == "failed")

    def __getitem__(self, test: str) -> Finding:
        return next(found for found in self.findings if found.test == test)

    @property
    def verdict(self) -> str:
        """The NIS in a few words."""
        if self["size"].verdict == "not tried":
            return "nothing counts"
        if not self.nis > 0:
            return "everything is predicted: too little noise for a test"
        if self["size"].verdict == "passed" or self.low <= self.nis <= self.high:
            return "consistent"
        words = "too large" if self.nis < 1 else "too small"
        return f"noise variances {words} by a factor {max(self.nis, 1 / self.nis):.3g}"


def diagnose(
    innovations: Innovations, remedies: Remedies | None = None, *, fitted: int = 0
) -> Diagnostics:
    """Test the innovations of a run.

    Where the noise changes with time or level, the other tests are made on what is left without
    this change, so that they do not fail for the same reason.

    Args:
        innovations: of the run.
        remedies: the remedy for each failure, in words.
        fitted: how many parameters were tuned on these innovations.

    >>> import numpy as np
    >>> e = np.random.default_rng(0).standard_normal(500)
    >>> [found.test for found in diagnose(Innovations.of(e, np.ones(500))).failed]
    []
    >>> found = diagnose(Innovations.of(3 * e, np.ones(500)))
    >>> [each.test for each in found.failed], round(found.factor)
    (['size'], 9)
    """
    remedies, lag = Remedies() if remedies is None else remedies, lag_one(innovations.normalised)
    level, time, varying = _changes(innovations, remedies)
    columns = tuple(column.evened(varying) for column in innovations.columns)
    turns = of_turns(innovations, columns, remedies.turns)
    refused = remedies.turns if turns.verdict == "failed" else remedies.outliers
    findings = (
        turns,
        of_outliers(innovations, columns, PARTS if varying else 1, refused),
        of_start(columns, remedies.start),
        level,
        time,
        of_whiteness(columns, lag, fitted, remedies.whiteness),
        of_size(innovations),
    )
    whole = size(innovations.columns) if innovations.predicted else NOTHING
    return Diagnostics(*whole, lag, sum(map(len, columns)), findings)


def _changes(innovations: Innovations, remedies: Remedies) -> tuple[Finding, Finding, Varying]:
    """Whether the noise changes with the level and with time, and which of them explains it better.

    Where one change explains the other, and not the other way round, it is told alone.
    """
    calm = tuple(column.only(column.calm) for column in innovations.columns)
    level, time = over_level(calm, innovations.unit, remedies.level), over_time(calm, remedies.time)
    if level.verdict != "failed" or time.verdict != "failed":
        failed: Varying = "time" if time.verdict == "failed" else ""
        return level, time, "level" if level.verdict == "failed" else failed
    by_level = tuple(column.evened("level") for column in calm)
    by_time = tuple(column.evened("time") for column in calm)
    time_left = over_time(by_level, remedies.time)
    level_left = over_level(by_time, innovations.unit, remedies.level)
    if time_left.verdict != level_left.verdict:
        if time_left.verdict == "failed":
            return level_left, time, "time"
        return level, time_left, "level"
    return level, time, "level" if level.p < time.p else "time"
