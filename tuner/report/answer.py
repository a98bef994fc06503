"""The answer of a run: tuned numbers, and what they are worth on held-out data."""

import math
from collections.abc import Iterable, Iterator

from tuner.report.blocks import Bar, Bars, Value
from tuner.report.verdict import main_solution
from tuner.report.words import amount, between, interval, label, number, percent, sentence, unit
from tuner.run.fit_record import HeldOutRecord
from tuner.run.result import ParameterRecord, Result, SolutionRecord

WIDEST = 30.0
"""Intervals are shown on one scale from the value over this to the value times this, at most."""


def values(result: Result) -> list[Value]:
    """The tuned numbers of a fit; of a study those that are exported."""
    if result.fit is not None:
        solution = main_solution(result)
        return [] if solution is None else [*_values(result, solution, result.fit.in_doubt)]
    names = [tuned["name"] for tuned in result.tuned]
    several = len(names) > 1
    return [
        value
        for name in names
        if (solution := best(result, name)) is not None
        for value in _values(result, solution, [], f"{name}." if several else "")
    ]


def _values(
    result: Result, solution: SolutionRecord, doubtful: Iterable[str], prefix: str = ""
) -> Iterator[Value]:
    meanings = _meanings(result, solution.problem)
    tuned = {n: p for n, p in searched(solution).items() if isinstance(p.value, float)}
    scale = _scale(tuned.values())
    for name, parameter in tuned.items():
        assert isinstance(parameter.value, float)
        low, high = _ends(parameter, scale)
        yield Value(
            name=prefix + name,
            value=number(parameter.value, 5),
            unit=unit(parameter.unit),
            interval=interval(parameter.interval),
            kind=parameter.interval_kind.partition(",")[0],
            meaning=label(meanings.get(name, "")),
            doubt="not determined" if name in doubtful else "",
            low=low,
            high=high,
        )


def best(result: Result, problem: str) -> SolutionRecord | None:
    """The lowest solution of a problem."""
    own = [s for s in result.solutions if s.problem == problem and s.value is not None]
    return min(own, key=lambda s: s.value or 0.0, default=None)


def searched(solution: SolutionRecord | None) -> dict[str, ParameterRecord]:
    """The parameters that were searched, by name."""
    if solution is None:
        return {}
    free = _free(solution)
    return {name: p for name, p in solution.parameters.items() if name in free}


def _free(solution: SolutionRecord) -> set[str]:
    """Names of what was searched: a coordinate is called ln or logit of one."""
    return {label.split()[-1].partition("[")[0] for label in solution.certificate["gradient"]}


def _meanings(result: Result, problem: str) -> dict[str, str]:
    for tuned in result.tuned:
        if tuned["name"] == problem:
            return {each["name"]: each["meaning"] for each in tuned.get("quantities", [])}
    return {}


def _scale(parameters: Iterable[ParameterRecord]) -> float:
    """By which factor the scale of all intervals goes up and down."""
    ratios = [
        max(high / p.value, p.value / low)
        for p in parameters
        if p.interval is not None and isinstance(p.value, float) and p.value > 0
        for low, high in [p.interval]
        if low is not None and high is not None and low > 0 and math.isfinite(high)
    ]
    return float(min(max(ratios, default=1.5) ** 1.15, WIDEST))


def _ends(parameter: ParameterRecord, scale: float) -> tuple[float | None, float | None]:
    """Where an interval lies on the scale; open ends go to its ends."""
    value = parameter.value
    if parameter.interval is None or not isinstance(value, float) or value <= 0 or scale <= 1:
        return None, None
    low, high = parameter.interval
    below = 0.0 if not low or low < 0 else _place(low / value, scale)
    above = 1.0 if high is None or not math.isfinite(high) else _place(high / value, scale)
    return below, above


def _place(ratio: float, scale: float) -> float:
    return min(max(0.5 + 0.5 * math.log(ratio) / math.log(scale), 0.0), 1.0)


def follows(result: Result) -> list[tuple[str, str, str]]:
    """Numbers that follow from the tuned ones."""
    found = []
    for tuned in result.tuned:
        prefix = f"{tuned['name']}." if len(result.tuned) > 1 else ""
        free = searched(best(result, tuned["name"]))
        for each in tuned.get("quantities", []):
            if each["name"] in free or not isinstance(each["value"], float):
                continue
            name = each["name"].removesuffix("_derived")
            text = amount(each["value"], each["unit"], 5)
            found.append((prefix + name, text, label(each["meaning"])))
    return found


def bars(result: Result) -> Bars | None:
    """Before and after on what was held out."""
    fit = result.fit
    if fit is None or fit.held_out is None:
        return None
    held = fit.held_out
    given = [
        ("before", held.start, "before"),
        ("tuned on the rest", held.tuned, "tuned"),
        (f"no filter: {held.nothing}", held.unfiltered, "none"),
        ("tuned on it itself", held.best, "best"),
    ]
    there = [(n, v, look) for n, v, look in given if v is not None and math.isfinite(v)]
    longest = max((value for _, value, _ in there), default=1.0) or 1.0
    return Bars(
        title=_finding(held),
        bars=[
            Bar(name, amount(value, fit.unit), value / longest, look) for name, value, look in there
        ],
        note=sentence(
            f"judged on {held.what}, with numbers that were tuned on the rest; {_gap(held)}"
        ),
    )


def _finding(held: HeldOutRecord) -> str:
    gain = held.gain
    if gain is None or gain.low is None or gain.high is None:
        return "On data that tuning did not see"
    if gain.low > 0:
        return f"On data that tuning did not see: {between(gain.low, gain.high)} better"
    if gain.high < 0:
        return f"On data that tuning did not see: {between(-gain.high, -gain.low)} worse"
    return (
        f"On data that tuning did not see: between {percent(-gain.low)} worse and "
        f"{percent(gain.high)} better"
    )


def _gap(held: HeldOutRecord) -> str:
    if held.gap is None:
        return "shorter is better"
    return f"{percent(held.gap)} above what tuning on it would reach; shorter is better"
