"""A solution as a table, in text for a terminal and in HTML for a notebook."""

import math
from collections.abc import Iterator, Sequence
from html import escape
from typing import Any, TypeAlias

import numpy as np

from tuner.rounding import outward

Solved: TypeAlias = Any
"""A :class:`tuner.certificate.solution.Solution`, which displays itself by these functions."""
HEAD = ("parameter", "value", "interval", "unit")


def as_text(solution: Solved) -> str:
    """The status, and an aligned line for each parameter and derived number."""
    rows = [HEAD, *_rows(solution)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEAD))]
    lines = ["  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)) for row in rows]
    return "\n".join([*_ended(solution), *(line.rstrip() for line in lines)])


def as_html(solution: Solved) -> str:
    """The same as a table of HTML, with all text escaped."""
    first, *more = (escape(line) for line in _ended(solution))
    head = "".join(f"<th>{name}</th>" for name in HEAD)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in _rows(solution)
    )
    rest = "".join(f"<br>{line}" for line in more)
    return f"<p><b>{first}</b>{rest}</p><table><tr>{head}</tr>{body}</table>"


def _ended(solution: Solved) -> Iterator[str]:
    starts = solution.certificate.starts
    yield (
        f"{solution.problem} by {solution.solver}: {solution.status.value}, "
        f"{solution.status.sentence}"
    )
    agree = f"; {starts.agreeing} of {starts.count} starts agree" if starts.count > 1 else ""
    yield (
        f"value {solution.value:.6g} after {solution.evaluations} evaluations in "
        f"{solution.seconds:.2g} s{agree}"
    )
    if solution.gradient_by.startswith("C, "):
        yield f"gradients by {solution.gradient_by}"
    yield from solution.certificate.flat_directions


def _rows(solution: Solved) -> Iterator[Sequence[str]]:
    certificate = solution.certificate
    free = {label.split()[-1] for label in certificate.gradient}
    known = bool(certificate.curvatures or certificate.active_bounds)
    for name, parameter in solution.parameters.items():
        yield name, _number(parameter.value), _range(name, parameter, free, known), parameter.unit
    for name, value in solution.derived.items():
        yield name, f"{value:.6g}", "follows", ""


def _range(name: str, parameter: Any, free: set[str], known: bool) -> str:
    """The interval, or the reason for having none, as far as it is known."""
    if parameter.interval is not None:
        return range_in_words(parameter.interval, parameter.interval_kind)
    if parameter.value.ndim:
        return ""
    if name not in free:
        return "held"
    return "not determined" if known else ""


def _number(value: np.ndarray) -> str:
    if value.ndim == 0:
        return f"{float(value):.6g}"
    return np.array2string(value, precision=4, separator=", ").replace("\n", "")


def range_in_words(interval: tuple[float | None, float | None], kind: str) -> str:
    """An interval in brackets, or its one limit, with its kind; ends are rounded outward.

    Args:
        interval: lowest and highest value; None stands for infinite.
        kind: of the interval, as :class:`tuner.certificate.solution.TunedParameter` has it.

    >>> range_in_words((1.0, 2.5), "95 %, likelihood ratio")
    '[1, 2.5] (95 %)'
    >>> range_in_words((0.010525, 0.011029), "95 %, likelihood ratio")
    '[0.0105, 0.0111] (95 %)'
    >>> range_in_words((0.0, 2e-4), "95 %, sandwich")
    '[below 0.0002] (95 %)'
    >>> range_in_words((3.0, None), "1 % of the cost")
    '[above 3] (1 % of the cost)'
    """
    low, high = outward(*interval)
    short = kind.partition(",")[0]
    if high is None or high == math.inf:
        text = f"[above {low:.3g}]"
    elif low is None or low in (0.0, -math.inf):
        text = f"[below {high:.3g}]"
    else:
        text = f"[{low:.3g}, {high:.3g}]"
    return f"{text} ({short})" if short else text
