"""Steps in which a wrong constant shows: a search from states near a filter's own and far off."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tuner.code.fields import Field
from tuner.code.limits import beside_limits
from tuner.code.literal import Precision
from tuner.code.mutants import CHANGE, Given, Mutant, Noise, Step
from tuner.code.states import Around, Arrays, placed

EPS = {"double": 2.0**-52, "float": 2.0**-23}
SHARE = 4
"""Tolerance of a number after one step over its size and the precision, beside that of rounding."""
STRAYS = 4
"""Tolerance over the largest effect of random rounding errors."""
_BATCH, _ROUNDS, _FEW, _REPEATS = 64, 8, 3, 6
_LONG = 6000
"""Operations of a step beyond which fewer states are looked at."""
_LANES = 128
"""Constants that are changed at a time."""
_LARGEST = {"double": 1e60, "float": 1e12}


@dataclass(frozen=True, eq=False)
class Found:
    """Single steps in which constants show.

    Attributes:
        states, samples: a field each, ``(C, ...)``.
        count: C.
        tried: number of states that were looked at.
        idle: number of constants that showed in none of them, not even doubled.
    """

    states: Arrays
    samples: Arrays
    count: int
    tried: int
    idle: int


@dataclass(frozen=True, eq=False)
class Expected:
    """Roots of steps without and with rounding errors, ``(roots, B)``."""

    exact: np.ndarray
    strays: np.ndarray


def search(step: Step, around: Around, most: int) -> Found:
    """At most so many steps that together show as many constants as can be.

    Args:
        step: the filter's.
        around: where states are drawn.
        most: number of steps.
    """
    draw, tried = np.random.default_rng(0), 0
    program, hidden = step.program, list(step.mutants)
    idle, chosen = set(hidden), list[Arrays]()
    for drawn in _batches(step, around, draw):
        if not hidden or len(chosen) == most:
            break
        states, samples = (_rounded(part, program.precision) for part in drawn)
        given = placed(program, states, samples)
        tried += len(next(iter(given.values()), ()))
        # Rounding is measured where a change shows at all, which is in few of the later steps.
        exact = _exact(step, given)
        plain = Expected(exact, np.zeros(exact.shape))
        some = shown(step, given, hidden, plain, 2.0).any(axis=0)
        some |= shown(step, given, sorted(idle), plain, 1.0, change=1.0).any(axis=0)
        if not some.any():
            continue
        states, samples = ([x[some] for x in part] for part in (states, samples))
        given = {k: x[some] for k, x in given.items()}
        right = expected(step, given, draw)
        shows = shown(step, given, hidden, right, 2.0)
        while len(chosen) < most:
            best = int(shows.sum(axis=0).argmax())
            if not shows[:, best].any():
                break
            chosen.append([x[best] for x in (*states, *samples)])
            kept = np.logical_not(shows[:, best])
            hidden = [one for one, stays in zip(hidden, kept, strict=True) if stays]
            shows = shows[kept]
        still = [one for one in hidden if one in idle]
        doubled = np.atleast_1d(shown(step, given, still, right, 1.0, change=1.0).any(axis=1))
        idle = {one for one, moves in zip(still, doubled, strict=True) if not moves}
    fields = [*program.state, *program.inputs]
    whole = [
        np.array([one[k] for one in chosen]).reshape(len(chosen), *f.shape)
        for k, f in enumerate(fields)
    ]
    own = len(program.state)
    return Found(whole[:own], whole[own:], len(chosen), tried, len(idle))


def _batches(
    step: Step, around: Around, draw: np.random.Generator
) -> Iterator[tuple[Arrays, Arrays]]:
    if len(step.order) > _LONG:
        yield from (around.drawn(draw, _BATCH // 2) for _ in range(_FEW))
        return
    yield from (around.drawn(draw, _BATCH) for _ in range(_ROUNDS))
    yield from beside_limits(step, around, draw)


def expected(step: Step, given: Given, draw: np.random.Generator) -> Expected:
    """The results of steps, and by how much rounding errors change them."""
    exact = _exact(step, given)
    noise = Noise(draw, EPS[step.program.precision], _REPEATS)
    runs = step.results(given, noise=noise)
    with np.errstate(all="ignore"):
        apart = [np.abs(run - right) for run, right in zip(runs, exact, strict=True)]
    strays = np.array([np.max(np.atleast_2d(one), axis=0) for one in apart]).reshape(exact.shape)
    return Expected(exact, np.where(np.isnan(exact), 0, strays))


def _exact(step: Step, given: Given) -> np.ndarray:
    count = max(map(len, given.values()), default=1)
    found = [np.broadcast_to(one, count) for one in step.results(given)]
    return np.array(found, float).reshape(-1, count)


def allowed(right: Expected, precision: Precision) -> np.ndarray:
    """The tolerance of each root, ``(roots, B)``."""
    return np.asarray(
        STRAYS * right.strays + SHARE * EPS[precision] * np.abs(np.nan_to_num(right.exact))
    )


def shown(
    step: Step,
    given: Given,
    mutants: list[Mutant],
    right: Expected,
    margin: float,
    change: float = CHANGE,
) -> np.ndarray:
    """Which constants show in which steps, ``(M, B)``; none in a step without finite results."""
    program, exact = step.program, right.exact
    own = sum(field.size for field in program.state)
    limit = _LARGEST[program.precision]
    good = np.isfinite(exact[:own]).all(axis=0) & np.isfinite(right.strays).all(axis=0)
    good &= np.abs(np.nan_to_num(exact)).max(axis=0, initial=0) < limit
    most = margin * allowed(right, program.precision)
    found = np.zeros((len(mutants), exact.shape[1]), bool)
    known = step.values(given)
    for first in range(0, len(mutants), _LANES):
        some = slice(first, first + _LANES)
        with np.errstate(all="ignore"):
            for k, row in step.changed(known, mutants[some], change).items():
                apart = np.abs(row.astype(float) - exact[k])
                found[some] |= (apart > most[k]) | (np.isnan(row) != np.isnan(exact[k]))
    return np.asarray(found & good)


def unplaced(fields: list[Field], rows: np.ndarray) -> tuple[Arrays, np.ndarray]:
    """Rows of stored entries as arrays ``(B, ...)`` of each field, and the rows that remain."""
    found = []
    for field in fields:
        own, rows = rows[: field.size], rows[field.size :]
        array = np.zeros((own.shape[1], *field.shape))
        for row, index in zip(own, field.entries(), strict=True):
            array[_at(index)] = row
            if field.half:
                array[_at(index[::-1])] = row
        found.append(array)
    return found, rows


def _at(index: tuple[int, ...]) -> tuple[slice | int, ...]:
    return (slice(None), *index)


def _rounded(arrays: Arrays, precision: Precision) -> Arrays:
    """Numbers that the precision has."""
    if precision == "double":
        return arrays
    with np.errstate(all="ignore"):
        return [x.astype(np.float32).astype(float) if x.dtype.kind == "f" else x for x in arrays]
