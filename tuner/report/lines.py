"""A run in five lines: use these numbers, how good, why to trust them, what is open, what next."""

from collections.abc import Iterator

from tuner.certificate.table import range_in_words
from tuner.names import counted
from tuner.report.answer import best, searched
from tuner.report.verdict import verdict
from tuner.run.comparison import Verdict
from tuner.run.result import ParameterRecord, Result

MOST = 6
"""So many things are named one by one."""


def five_lines(result: Result) -> list[str]:
    """The lines; RUN in the last stands for the run's folder."""
    if result.fit is not None:
        return result.fit.lines
    return [
        f"use       {_some([*_numbers(result)], ', ') or 'nothing: nothing is exported'}",
        f"how good  {_good(result)}",
        f"trust     {'; '.join(_trust(result))}",
        f"open      {_some([*_open(result)], '; ') or 'nothing: all is determined'}",
        f"next      {_next(result)}",
    ]


def _good(result: Result) -> str:
    """How many claims are met; without any, how many numbers were found."""
    if result.comparisons:
        words = verdict(result).sentence.rstrip(".")
        return f"{words[:1].lower()}{words[1:]}"
    none = "there is no reference to compare with"
    if not result.findings:
        return none
    limited = sum(bool(finding.limits) for finding in result.findings)
    return f"{counted(len(result.findings), 'number')} found, {limited} with 95 % limits; {none}"


def _next(result: Result) -> str:
    """The command that usually comes next."""
    if result.comparisons:
        return "tuner compare RUN --md"
    if len(result.tuned) == 1:
        return "tuner export RUN --to c"
    return "tuner report RUN"


def _some(parts: list[str], between: str) -> str:
    first = between.join(parts[:MOST])
    return first if len(parts) <= MOST else f"{first}{between}and {len(parts) - MOST} more"


def _numbers(result: Result) -> Iterator[str]:
    several = len(result.tuned) > 1
    for tuned in result.tuned:
        prefix = f"{tuned['name']}." if several else ""
        for name, parameter in searched(best(result, tuned["name"])).items():
            if isinstance(parameter.value, float):
                yield f"{prefix}{name} = {_number(parameter.value, parameter)}"


def _number(value: float, parameter: ParameterRecord) -> str:
    text = f"{value:.5g}"
    if parameter.interval is not None:
        text += f" {range_in_words(parameter.interval, parameter.interval_kind)}"
    return f"{text} {parameter.unit}".rstrip()


def _trust(result: Result) -> Iterator[str]:
    searches = result.solutions
    if not searches:
        yield "nothing was searched"
        return
    good = sum(solution.status.trusted for solution in searches)
    one = "the search converged" if good else "the search did not converge"
    yield one if len(searches) == 1 else f"{good} of {len(searches)} searches converged"
    started = [s for s in searches if s.certificate["starts"]["count"] > 1]
    if started:
        agree = sum(
            s.certificate["starts"]["agreeing"] == s.certificate["starts"]["count"] for s in started
        )
        every = "all starts agree" if agree else "the starts do not agree"
        yield every if len(searches) == 1 else f"all starts agree in {agree} of {len(started)}"
    yield from (f"{c.problem}: {c.warning}" for c in result.single_precision if c.warning)


def _open(result: Result) -> Iterator[str]:
    rows = [r.quantity for r in result.comparisons if r.verdict is Verdict.NOT_IDENTIFIABLE]
    if rows:
        yield f"{_some(rows, ', ')} cannot be identified"
    names = [tuned["name"] for tuned in result.tuned]
    directions = [
        f"{s.problem}: {words}"
        for s in result.solutions
        if s.problem in names
        for words in s.certificate["flat_directions"]
    ]
    yield from dict.fromkeys(directions)
