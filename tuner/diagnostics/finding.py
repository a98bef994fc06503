"""The result of a test of the innovations, and the chance by which it counts as a failure."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

Verdict: TypeAlias = Literal["passed", "failed", "not tried"]
LEVEL = 0.01
"""A test fails where a consistent filter does as badly with a smaller probability."""


@dataclass(frozen=True)
class Finding:
    """One test.

    Attributes:
        test: its name.
        what: the statistic in words.
        statistic: NaN where it was not tried.
        p: probability of such a value with a consistent filter; NaN where it was not tried.
        verdict: failed below a chance of 1 %, or where a test says otherwise.
        sentence: where it failed, the fault and its remedy; where it was not tried, the reason.
        details: further numbers by name.
    """

    test: str
    what: str
    statistic: float
    p: float
    verdict: Verdict
    sentence: str = ""
    details: Mapping[str, float] = field(default_factory=dict)


def judged(
    test: str,
    what: str,
    statistic: float,
    p: float,
    sentence: str,
    details: Mapping[str, float] | None = None,
    level: float = LEVEL,
) -> Finding:
    """A finding, with the sentence where it failed.

    >>> judged("size", "NIS", 4.0, 1e-9, "NIS is 4").verdict
    'failed'
    """
    p = min(float(p), 1.0)
    if p < level:
        return Finding(test, what, float(statistic), p, "failed", sentence, details or {})
    return Finding(test, what, float(statistic), p, "passed", "", details or {})


def not_tried(test: str, what: str, why: str) -> Finding:
    """A test that does not apply to the recording."""
    return Finding(test, what, float("nan"), float("nan"), "not tried", why)
