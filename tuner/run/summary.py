"""A fit in five lines: use these numbers, how good, why to trust them, what is open, what next."""

from collections.abc import Iterator

import numpy as np

from tuner.certificate.solution import Parameter, Solution
from tuner.problem.parameters import Fixed
from tuner.run.judged import Judged
from tuner.run.posed import Posed

WORDS = {
    "likelihood": "a measurement is foretold within",
    "prediction": "a measurement is foretold within",
    "rmse": "error (rms)",
    "inclination": "error of the inclination (rms)",
    "heading": "error of the heading (rms)",
}


def five_lines(posed: Posed, solution: Solution, judged: Judged) -> list[str]:
    """The lines, each beginning with what it answers; RUN in the last stands for the run's folder.

    Args:
        posed: the problem.
        solution: what was found.
        judged: what it is worth.
    """
    return [
        "use       " + ", ".join(_numbers(posed, solution)),
        "how good  " + "; ".join(_worth(judged)),
        "trust     " + "; ".join(_trust(solution, judged)),
        "open      " + ("; ".join(_open(posed, solution)) or "nothing: all is determined"),
        f"next      tuner export RUN --to c -o {posed.problem.name}.h",
    ]


def _numbers(posed: Posed, solution: Solution) -> Iterator[str]:
    for name, kind in posed.problem.space.parameters:
        if not isinstance(kind, Fixed):
            yield f"{name} = {_number(solution.parameters[name])}"
    for name, value in solution.derived.items():
        yield f"{name} = {value:.5g}"


def _number(parameter: Parameter) -> str:
    told = f"{float(parameter.value):.5g}"
    if parameter.interval is not None:
        told += f" [{parameter.interval[0]:.3g}, {parameter.interval[1]:.3g}]"
    return f"{told} {parameter.unit}".rstrip()


def _worth(judged: Judged) -> Iterator[str]:
    unit = f" {judged.unit}" if judged.unit else ""
    words = WORDS.get(judged.objective, judged.objective)
    yield f"{words} {judged.tuned:.4g}{unit}, {_start(judged.start)}{unit} before"
    if judged.held_out is not None:
        held = judged.held_out
        better = "better" if held.tuned < held.start else "NOT better"
        yield (
            f"on {held.what}, tuned on the rest: {held.tuned:.4g}{unit} against "
            f"{_start(held.start)}{unit} before, {better}"
        )


def _start(value: float) -> str:
    return f"{value:.4g}" if np.isfinite(value) else "without bound"


def _trust(solution: Solution, judged: Judged) -> Iterator[str]:
    starts = solution.certificate.starts
    yield solution.status.value
    if starts.count > 1:
        yield f"{starts.agreeing} of {starts.count} starts agree"
    if judged.consistency is not None:
        for when, found in zip(("before", "now"), judged.consistency, strict=True):
            yield (
                f"{when}: NIS {found.nis:.4g} ({found.low:.3g} to {found.high:.3g} expected: "
                f"{found.verdict}), lag one {found.lag_one:+.2f}"
            )


def _open(posed: Posed, solution: Solution) -> Iterator[str]:
    yield from solution.certificate.flat_directions
    yield from (f"{label} lies at its bound" for label in solution.certificate.active_bounds)
