"""A tuned value held against a published one, with one of six honest verdicts."""

import math
from dataclasses import dataclass
from enum import Enum


class Verdict(Enum):
    """The verdict of a comparison."""

    MATCH = "match"
    DIFFERS = "differs"
    HOLDS = "claim holds"
    FAILS = "claim fails"
    NOT_IDENTIFIABLE = "not identifiable"
    INCONSISTENT = "inconsistent in the paper"


_AS_WRITTEN = {"extra": "forbid"}
"""Read back from a result's JSON, it has these fields and no others."""


@dataclass(frozen=True)
class Comparison:
    """One row of a comparison with a paper.

    Attributes:
        quantity: what is compared, "gyro.q_over_r".
        where: the table, equation or sentence of the paper, or how its number was derived.
        paper: the published number; None where the paper gives none.
        ours: the number found here; None where there is none.
        unit: the unit of both, "" for none.
        tolerance: how far ours may lie from the paper's, relative; None for a verdict in words.
        verdict: what it came to.
        note: the reason, or what decides it.
    """

    __pydantic_config__ = _AS_WRITTEN

    quantity: str
    where: str
    paper: float | None
    ours: float | None
    unit: str
    tolerance: float | None
    verdict: Verdict
    note: str

    @property
    def deviation(self) -> float | None:
        """Ours over the paper's, minus one; None where either is missing or the paper's is 0."""
        if self.paper is None or self.ours is None or self.paper == 0:
            return None
        return self.ours / self.paper - 1

    def within(self, tolerance: float | None) -> bool:
        """Whether a number lies within a tolerance (its own if None); rows in words always do.

        Without a deviation (zero on paper, or infinite and so not on file) the verdict decides.
        """
        if self.tolerance is None:
            return True
        if self.deviation is None:
            return self.verdict is Verdict.MATCH
        return abs(self.deviation) <= (self.tolerance if tolerance is None else tolerance)


def number(
    quantity: str,
    where: str,
    paper: float,
    ours: float,
    *,
    tolerance: float,
    unit: str = "",
    note: str = "",
) -> Comparison:
    """Compare two numbers: a match within the relative tolerance, or a difference with its size.

    >>> row = number("gain", "Table 2", 2.0, 7.2, tolerance=0.05)
    >>> row.verdict.value, row.note
    ('differs', 'x 3.6')
    """
    matches = abs(ours / paper - 1) <= tolerance if paper else ours == paper
    verdict = Verdict.MATCH if matches else Verdict.DIFFERS
    parts = [part for part in (note, "" if matches else _size(paper, ours)) if part]
    return Comparison(quantity, where, paper, ours, unit, tolerance, verdict, "; ".join(parts))


def claim(
    quantity: str, where: str, holds: bool, *, ours: float | None, unit: str = "", note: str
) -> Comparison:
    """Judge a claim in words, with the number that decides it."""
    verdict = Verdict.HOLDS if holds else Verdict.FAILS
    return Comparison(quantity, where, None, ours, unit, None, verdict, note)


def undecided(
    quantity: str,
    where: str,
    *,
    paper: float | None = None,
    ours: float | None = None,
    unit: str = "",
    note: str,
) -> Comparison:
    """A quantity that cannot be compared, with the reason, and the numbers there are."""
    return Comparison(quantity, where, paper, ours, unit, None, Verdict.NOT_IDENTIFIABLE, note)


def _size(paper: float, ours: float) -> str:
    if paper == 0 or not math.isfinite(ours / paper):
        return f"{ours:.4g} against {paper:.4g}"
    ratio = ours / paper
    return f"x {ratio:.2g}" if ratio >= 2 or ratio <= 0.5 else f"{100 * (ratio - 1):+.1f} %"
