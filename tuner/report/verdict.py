"""One sentence on a run: whether its numbers can be used, and why."""

from collections.abc import Iterator
from typing import Literal, NamedTuple, TypeAlias

from tuner.report.words import amount, between, joined, listed, sentence
from tuner.run.comparison import Verdict as Row
from tuner.run.fit_record import FitRecord, HeldOutRecord, ImprovementRecord
from tuner.run.result import Result, SolutionRecord

Grade: TypeAlias = Literal["use", "care", "refuse"]
HEADS: dict[Grade, str] = {
    "use": "Use it",
    "care": "Use it with care",
    "refuse": "Do not use it",
}
FAILURES = {
    "size": "the variances are not those of the innovations",
    "whiteness": "the innovations are correlated",
    "outliers": "some measurements are outliers",
    "full turns": "an angle jumps by full turns",
    "start": "the first innovations are too large",
    "over level": "the noise changes with the level",
    "over time": "the noise changes with time",
}
"""Tests of the innovations that failed, in words."""


class Verdict(NamedTuple):
    """The verdict on a run.

    Attributes:
        grade: of three.
        head: that, in a few words.
        sentence: why.
    """

    grade: Grade
    head: str
    sentence: str


def verdict(result: Result, *, published: bool = True) -> Verdict:
    """The verdict on a run.

    Args:
        result: what it found.
        published: whether its claims are those of a paper.
    """
    if result.fit is not None:
        return _of_fit(result, result.fit)
    return _of_rows(result, published) if result.comparisons else _of_solutions(result)


def main_solution(result: Result) -> SolutionRecord | None:
    """The solution that a fit is about: of what is exported, the lowest."""
    name = result.tuned[0]["name"] if result.tuned else None
    own = [s for s in result.solutions if s.problem == name] or result.solutions[:1]
    return min(own, key=lambda s: float("inf") if s.value is None else s.value, default=None)


def _of_fit(result: Result, fit: FitRecord) -> Verdict:
    solution = main_solution(result)
    against = [*_against(solution, fit)]
    doubts, good = [*_doubts(result, fit)], [*_good(fit)]
    if against:
        return Verdict("refuse", HEADS["refuse"], sentence(joined(against)))
    if doubts:
        but = f"; yet {good[0]}" if good else ""
        return Verdict("care", HEADS["care"], sentence(joined(doubts[:3]) + but))
    if solution is not None and _agree(solution):
        good.append("all starts agree")
    return Verdict("use", HEADS["use"], sentence(joined(good or ["no check failed"])))


def _agree(solution: SolutionRecord) -> bool:
    starts = solution.certificate["starts"]
    return bool(starts["count"] > 1 and starts["agreeing"] == starts["count"])


def _against(solution: SolutionRecord | None, fit: FitRecord) -> Iterator[str]:
    """The reasons not to use the numbers at all."""
    if solution is not None and not solution.status.trusted:
        yield f"the search ended {solution.status.value!r}: {solution.status.sentence}"
    held = fit.held_out
    if held is None:
        return
    if _sign(held.gain) < 0 and held.gain is not None:
        yield f"on {held.what}, not used for tuning, its error is larger than before"
    if _sign(held.over_unfiltered) < 0:
        yield f"on {held.what} its error is larger than without filter ({held.nothing})"


def _sign(gain: ImprovementRecord | None) -> int:
    """1 where it is better for certain, -1 where worse, 0 where nobody can tell."""
    if gain is None or gain.low is None or gain.high is None:
        return 0
    return 1 if gain.low > 0 else -1 if gain.high < 0 else 0


def _doubts(result: Result, fit: FitRecord) -> Iterator[str]:
    """The reasons for care with the numbers."""
    if fit.in_doubt:
        verb = "is" if len(fit.in_doubt) == 1 else "are"
        yield f"{listed(fit.in_doubt)} {verb} not determined by this recording"
    if len(fit.diagnostics) == 2:
        failed = [found.test for found in fit.diagnostics[1].findings if found.verdict == "failed"]
        yield from (FAILURES.get(test, test) for test in failed)
    if fit.held_out is None:
        yield "nothing was held out for judging"
    elif fit.held_out.gain is not None and _sign(fit.held_out.gain) == 0:
        yield f"on {fit.held_out.what} it is not clear whether tuning helps"
    if any(check.warning for check in result.single_precision):
        yield "its outputs deviate in single precision"


def _good(fit: FitRecord) -> Iterator[str]:
    """The reasons to trust the numbers."""
    held = fit.held_out
    if held is not None and _sign(held.gain) > 0 and held.gain is not None:
        share = between(held.gain.low or 0.0, held.gain.high or 0.0)
        yield f"on {held.what}, not used for tuning, its error is {share} smaller than before"
    elif held is not None and held.gain is None and _lower(held):
        yield f"on {held.what}, not used for tuning, its error is smaller than before"
    if len(fit.diagnostics) == 2:
        now = fit.diagnostics[1]
        if not any(found.verdict == "failed" for found in now.findings):
            yield "its innovations are consistent with its variances"


def _lower(held: HeldOutRecord) -> bool:
    return held.start is None or (held.tuned is not None and held.tuned < held.start)


def _of_rows(result: Result, published: bool) -> Verdict:
    """How many of a paper's numbers and claims are met."""
    rows = [row.verdict for row in result.comparisons]
    met = sum(row in (Row.MATCH, Row.HOLDS) for row in rows)
    others = [
        f"{count} {words if count > 1 else word}"
        for kinds, word, words in (
            ((Row.DIFFERS,), "differs", "differ"),
            ((Row.FAILS,), "claim fails", "claims fail"),
            ((Row.NOT_IDENTIFIABLE,), "cannot be identified", "cannot be identified"),
        )
        if (count := sum(row in kinds for row in rows))
    ]
    rest = len(rows) - met - sum(int(text.split()[0]) for text in others)
    others += [f"{rest} contradict{'s' if rest == 1 else ''} the paper itself"] if rest else []
    all_ = (
        "its one claim is met" if len(rows) == 1 else f"all {len(rows)} numbers and claims are met"
    )
    words = all_ if met == len(rows) else f"{met} of {len(rows)} numbers and claims are met"
    words += f"; {listed(others)}" if others else ""
    if met == len(rows):
        return Verdict("use", "Reproduced" if published else "All claims hold", sentence(words))
    head = "Reproduced in part" if published else "Not all claims hold"
    return Verdict("care", head, sentence(words))


def _of_solutions(result: Result) -> Verdict:
    bad = [s for s in result.solutions if not s.status.trusted]
    if not result.solutions:
        return Verdict("use", "Done", "There was no search.")
    if not bad:
        count = len(result.solutions)
        words = "its one search converged" if count == 1 else f"all {count} searches converged"
        return Verdict("use", "Done", sentence(words))
    ends = [f"{s.problem} ended {s.status.value!r}" for s in bad[:3]]
    return Verdict("care", "Done in part", sentence(joined(ends)))


def worth(fit: FitRecord) -> str:
    """Before and after on all data, in a sentence."""
    before, now = (amount(value, fit.unit) for value in (fit.start, fit.tuned))
    if fit.start is None:
        before = "without bound"
    if fit.objective in ("likelihood", "prediction"):
        return f"A measurement is predicted within {now}; before it was {before}."
    words = {"inclination": "of the inclination ", "heading": "of the heading "}
    return f"The error {words.get(fit.objective, '')}is {now} (rms); before it was {before}."
