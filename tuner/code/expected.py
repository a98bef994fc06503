"""The results of steps, by how much rounding changes them, and what of it is allowed."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tuner.code.array_step import Step
from tuner.code.evaluation import Given, Values
from tuner.code.rounding_errors import Noise

EPS = {"double": 2.0**-52, "float": 2.0**-23}
SHARE = 4
"""Tolerance of a number after one step over its size and the precision, beside that of rounding."""
STRAYS, IN_LOOPS = 4, 16
"""Tolerance over the largest effect of random rounding errors; in C with loops, whose operations
are in another order."""
LONG = 6000
"""Operations of a step beyond which its C has loops, and constants are judged by derivatives, which
one pass gives for all of them, and changed one by one only in the end."""
_REPEATS = 6
_MARGIN, SAFE = 8.0, 16.0
"""Distance of two numbers that are compared, over the largest effect of rounding on it, from which
other rounding errors decide alike; and in a search of short steps, which are judged once more."""
WELL_WITHIN, SAFELY = 4.0, 6.0
"""The tolerance over what another implementation may use up of it in a long step; and in a search,
whose steps are judged once more, with other errors."""
_LARGEST = {"double": 1e60, "float": 1e12}


@dataclass(frozen=True, eq=False)
class Expected:
    """Roots of steps without and with rounding errors.

    Attributes:
        exact: without, ``(roots, B)``.
        strays: by how much rounding changes them.
        steady: whether rounding is far from changing a decision, ``(B,)``.
        values: all nodes without rounding errors, ``(B,)`` or ``(1,)`` each.
    """

    exact: np.ndarray
    strays: np.ndarray
    steady: np.ndarray
    values: Values

    def of(self, which: np.ndarray) -> "Expected":
        """Those of some of the steps."""
        exact, strays = self.exact[:, which], self.strays[:, which]
        return Expected(exact, strays, self.steady[which], self.values.of(which))


def plain(step: Step, given: Given) -> Expected:
    """The results of steps, without rounding errors."""
    count = max(map(len, given.values()), default=1)
    values = step.all_values(given)
    exact = _rows(values, step.roots, count)
    return Expected(exact, np.zeros(exact.shape), np.ones(count, bool), values)


def expected(
    step: Step, given: Given, draw: np.random.Generator, margin: float = _MARGIN
) -> Expected:
    """The results of steps, and by how much rounding errors change them.

    Args:
        step: the filter's.
        given: states and samples.
        draw: a generator.
        margin: distance of two numbers that are compared, over the largest effect of rounding on
            it, from which a step is steady.
    """
    right = plain(step, given)
    exact = right.exact
    noise = Noise(draw, EPS[step.program.precision], _REPEATS)
    decided = {k for pair in step.decisions for k in pair} | {*step.to_whole}
    noisy = step.whole.noisy(given, noise, list(dict.fromkeys([*step.roots, *sorted(decided)])))
    count = exact.shape[1]
    with np.errstate(all="ignore"):
        strays = np.abs(_rows(noisy, step.roots, _REPEATS, count) - exact[:, None]).max(axis=1)
    steady = _steady(step, right.values, noisy, count, margin)
    return Expected(exact, np.where(np.isnan(exact), 0, strays), steady, right.values)


def _steady(
    step: Step,
    decided: Mapping[int, np.ndarray],
    noisy: Mapping[int, np.ndarray],
    count: int,
    least: float,
) -> np.ndarray:
    """Whether no decision is within rounding of what is decided."""
    first, second = [x for x, _ in step.decisions], [y for _, y in step.decisions]
    with np.errstate(all="ignore"):
        whole = _rows(decided, step.to_whole, count)
        half = np.floor(whole) + 0.5
        apart = _rows(decided, first, count) - _rows(decided, second, count)
        margin = np.vstack([apart, whole - half])
        shape = _REPEATS, count
        apart = _rows(noisy, first, *shape) - _rows(noisy, second, *shape)
        other = np.vstack([apart, _rows(noisy, step.to_whole, *shape) - half[:, None]])
        moved = np.abs(other - margin[:, None]).max(axis=1)
        unsure = (moved > 0) & (np.abs(margin) < least * moved)
    return np.asarray(~unsure.any(axis=0))


def _rows(values: Mapping[int, np.ndarray], nodes: Sequence[int], *shape: int) -> np.ndarray:
    """The values of some nodes, ``(K, *shape)``."""
    found = np.empty((len(nodes), *shape))
    for row, k in zip(found, nodes, strict=True):
        row[:] = values[k]
    return found


def allowed(step: Step, right: Expected) -> np.ndarray:
    """The tolerance of each root, ``(roots, B)``."""
    size = EPS[step.program.precision] * np.abs(np.nan_to_num(right.exact))
    strays = IN_LOOPS if len(step.order) > LONG else STRAYS
    return np.asarray(strays * right.strays + SHARE * size)


def with_others(
    step: Step, right: Expected, found: Sequence[np.ndarray], within: float = WELL_WITHIN
) -> Expected:
    """The same, with results of another implementation, which count as another rounding.

    Where one has a number and the other none, a step is not steady; nor is a long one in which it
    is not well within the tolerance: its order of operations may be another, as in C with loops.

    Args:
        step: the filter's.
        right: its results.
        found: those of the other implementation, ``(roots, B)``, by each half of symmetric ones.
        within: the tolerance over what a long step may use up of it.
    """
    steady, strays = right.steady, right.strays
    for other in found:
        with np.errstate(invalid="ignore"):
            apart = np.nan_to_num(np.abs(other - right.exact), posinf=0, neginf=0)
        steady = steady & (np.isnan(other) == np.isnan(right.exact)).all(axis=0)
        if len(step.order) > LONG:
            steady &= (within * apart <= allowed(step, right)).all(axis=0)
        strays = np.maximum(strays, apart)
    return replace(right, strays=strays, steady=steady)


def comparable(step: Step, right: Expected) -> np.ndarray:
    """The steps to a finite state of numbers that are not too large."""
    own = sum(field.size for field in step.program.state)
    good = np.isfinite(right.exact[:own]).all(axis=0) & np.isfinite(right.strays).all(axis=0)
    size = np.abs(np.nan_to_num(right.exact)).max(axis=0, initial=0)
    return np.asarray(good & right.steady & (size < _LARGEST[step.program.precision]))
