"""A fit in five lines: use these numbers, how good, why to trust them, what is open, what next."""

import re
from collections.abc import Iterator

import numpy as np

from tuner.certificate.solution import Solution, Status, TunedParameter
from tuner.certificate.table import range_in_words
from tuner.problem.parameters import Fixed
from tuner.run.fit_problem import Posed
from tuner.run.front import words as traded
from tuner.run.held_out import HeldOut
from tuner.run.judgement import Judged
from tuner.run.variance_scaling import VarianceScaling

WORDS = {
    "likelihood": "a measurement is predicted within",
    "prediction": "a measurement is predicted within",
    "rmse": "error (rms)",
    "inclination": "error of the inclination (rms)",
    "heading": "error of the heading (rms)",
}


def five_lines(
    posed: Posed, solution: Solution, judged: Judged, *, folder: bool = True
) -> list[str]:
    """The lines, each beginning with what it answers; RUN in the last stands for the run's folder.

    Args:
        posed: the problem.
        solution: what was found.
        judged: what it is worth.
        folder: whether there is a folder of the run.
    """
    return [
        "use       " + ", ".join(_numbers(posed, solution, judged)),
        "how good  " + "; ".join(_worth(posed, judged)),
        "trust     " + "; ".join(_trust(solution, judged)),
        "open      " + ("; ".join(_open(posed, solution, judged)) or "nothing: all is determined"),
        "next      " + _next(posed, solution, folder=folder),
    ]


def _numbers(posed: Posed, solution: Solution, judged: Judged) -> Iterator[str]:
    doubtful = in_doubt(posed, solution, judged)
    for name, kind in posed.problem.space.parameters:
        if not isinstance(kind, Fixed):
            doubt = " (not determined)" if name in doubtful else ""
            yield f"{name} = {_number(solution.parameters[name])}{doubt}"
    for name, value in solution.derived.items():
        yield f"{name} = {value:.5g}"


def in_doubt(posed: Posed, solution: Solution, judged: Judged) -> list[str]:
    """The free parameters that are not determined, by name."""
    open_ = (*posed.undetermined, *solution.certificate.flat_directions)
    named = {
        name for sentence in open_ if not _scaled(sentence, judged) for name in words(sentence)
    }
    free = (n for n, kind in posed.problem.space.parameters if not isinstance(kind, Fixed))
    return [name for name in free if name in named]


def _scaled(sentence: str, judged: Judged) -> bool:
    """Whether what the error leaves open is the common factor, which the innovations settle."""
    found = judged.rescaled
    if found is None or found.reason:
        return False
    return found.powers.keys() == set(words(sentence)) & found.powers.keys()


def words(text: str) -> list[str]:
    """The names in a sentence.

    >>> words("only R*q^0.64 is determined")
    ['only', 'R', 'q', 'is', 'determined']
    """
    return re.findall(r"[A-Za-z_]\w*", text)


def _number(parameter: TunedParameter) -> str:
    text = f"{float(parameter.value):.5g}"
    if parameter.interval is not None:
        text += f" {range_in_words(parameter.interval, parameter.interval_kind)}"
    return f"{text} {parameter.unit}".rstrip()


def _worth(posed: Posed, judged: Judged) -> Iterator[str]:
    unit = f" {judged.unit}" if judged.unit else ""
    words = WORDS.get(judged.objective, judged.objective)
    yield f"{words} {judged.tuned:.4g}{unit}, {_start(judged.start)}{unit} before"
    if judged.held_out is not None:
        yield ", ".join(_held_out(judged.held_out, unit))
    if judged.rescaled is not None:
        yield _rescaled(judged.rescaled)
    if judged.trade is not None:
        yield traded(posed, judged.trade)


def _rescaled(found: VarianceScaling) -> str:
    """The common factor of all variances, which accuracy leaves open."""
    if found.reason:
        return f"NIS {found.nis[0]:.3g}, variances not scaled: {found.reason}"
    return (
        f"{', '.join(found.powers)} scaled together by {found.factor:.3g}, estimates "
        f"unchanged: NIS {found.nis[1]:.3g}, {found.nis[0]:.3g} before"
    )


def _held_out(held: HeldOut, unit: str) -> Iterator[str]:
    """On what was not used: against the start, against nothing, and against the best there."""
    against = f"{held.tuned:.4g}{unit} against {_start(held.start)}{unit} before"
    yield f"on {held.what}, tuned on the rest: {against} ({_gain(held)})"
    if held.unfiltered is not None and held.over_unfiltered is not None:
        verdict = held.over_unfiltered.verdict
        words = "" if verdict == "better" else f": the filter is {verdict} than that"
        yield f"{_start(held.unfiltered)}{unit} without filter ({held.nothing}{words})"
    if held.gap is not None:
        none = abs(held.gap) < 1e-6
        more = "no more than" if none else f"{percent(held.gap)} above what"
        yield f"{more} tuning on it would reach"


def _gain(held: HeldOut) -> str:
    """Whether tuning helps there, as far as it can be told."""
    if held.gain is None:
        return "better" if held.tuned < held.start else "tuning does not help here"
    gain = held.gain
    if not np.isfinite([gain.low, gain.high]).all():
        return "too few samples to tell whether tuning helps"
    spread = f"{percent(gain.low)} to {percent(gain.high)} better"
    if gain.low < 0:
        worse = "" if gain.high < 0 else " worse"
        spread = f"{percent(-gain.low)}{worse} to {percent(abs(gain.high))} "
        spread += "worse" if gain.high < 0 else "better"
    if gain.verdict == "better":
        return spread
    word = "harms" if gain.verdict == "worse" else "does not help"
    return f"tuning {word} here: {spread}"


def percent(share: float) -> str:
    """A share in per cent, to two digits.

    >>> percent(0.1234), percent(-0.001), percent(0.999)
    ('12 %', '-0.1 %', '100 %')
    """
    value = 100 * share
    return f"{value:.0f} %" if abs(value) >= 10 else f"{value:.2g} %"


def _start(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "without bound"


def _trust(solution: Solution, judged: Judged) -> Iterator[str]:
    starts = solution.certificate.starts
    yield solution.status.value
    if starts.count > 1:
        yield f"{starts.agreeing} of {starts.count} starts agree"
    if judged.left_out is not None:
        yield judged.left_out.words
    if judged.rejected is not None:
        yield judged.rejected.words
    if judged.diagnostics is None:
        return
    for when, found in zip(("before", "now"), judged.diagnostics, strict=True):
        if found["size"].verdict != "not tried":
            yield (
                f"{when}: NIS {found.nis:.4g} ({found.low:.3g} to {found.high:.3g} expected: "
                f"{found.verdict}){_lag(found.lag_one)}"
            )
    now = judged.diagnostics[1]
    explained = {"size"} if now.verdict != "consistent" else set()
    if now["full turns"].verdict == "failed":  # they are the outliers
        explained.add("outliers")
    yield from (found.sentence for found in now.failed if found.test not in explained)


def _lag(correlation: float) -> str:
    return f", lag one {correlation:+.2f}" if np.isfinite(correlation) else ""


def _open(posed: Posed, solution: Solution, judged: Judged) -> Iterator[str]:
    if solution.status is Status.FAILED:
        yield "all: nothing was found"
        return
    yield from posed.undetermined
    for sentence in solution.certificate.flat_directions:
        by = " by the error, and the common factor by the innovations (NIS 1)"
        yield sentence + by * _scaled(sentence, judged)
    yield from (f"{name} lies at its bound" for name in _at_bound(solution))


def _at_bound(solution: Solution) -> list[str]:
    """The parameters by name: a coordinate is called ln or logit of one."""
    return [label.split()[-1] for label in solution.certificate.active_bounds]


def _next(posed: Posed, solution: Solution, *, folder: bool) -> str:
    if solution.status.trusted:
        file = f"tuner export RUN --to c -o {posed.problem.name}.h"
        python = 'fit.export("c"), or fit.save(FOLDER) with all formats and pictures'
        return file if folder else python
    if bounds := _at_bound(solution):
        return f"search again with a wider --bound, or --fix, for {' and '.join(bounds)}"
    return "search again from another --start, with more --starts, or by --solver nelder-mead"
