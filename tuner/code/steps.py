"""Single steps of a filter in which a wrong constant shows, with JAX's results."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import jax
import numpy as np

from tuner.code.array_step import Step
from tuner.code.at_rest import whereabouts
from tuner.code.detection import largest_moves, undetected
from tuner.code.expected import EPS, LONG, allowed, expected, with_others
from tuner.code.fields import Field
from tuner.code.mutants import Mutant
from tuner.code.operations import kind_of
from tuner.code.program import Program
from tuner.code.reference_filter import SAMPLES, ReferenceFilter
from tuner.code.search import Before, Found, formulas, search
from tuner.code.states import Around, Arrays, by_field, by_node, column

STEPS, _UNSEARCHED = 40, 4
"""Most single steps, and their number where there are no formulas to search by."""


@dataclass(frozen=True, eq=False)
class Steps:
    """Single steps from given states, a field each, ``(C, ...)``.

    Attributes:
        states, samples: what is given.
        expected, after: the outputs, and the next state.
        allowed, allowed_after: their tolerances.
        constants: number of constants in the formulas of a step.
        undetected: those that show in none of these steps when changed by a thousandth.
        idle: those that had no effect at all: not even doubled, or in a long step by their
            derivatives.
        looked_at: number of steps among which these were found.
        around: where they were drawn.
        formulas: operations of a step, in order.
    """

    states: Arrays
    samples: Arrays
    expected: Arrays
    after: Arrays
    allowed: Arrays
    allowed_after: Arrays
    constants: int
    undetected: list[Mutant]
    idle: set[Mutant]
    looked_at: int
    around: Around
    formulas: list[str]

    @property
    def detected(self) -> int:
        """Number of constants that show."""
        return self.constants - len(self.undetected)

    def before(self) -> Before:
        """What they are for a search of the same step in another precision."""
        counts = self.looked_at, self.idle
        return Before(self.states, self.samples, *counts, self.undetected, self.formulas)


def searched_steps(
    own: ReferenceFilter,
    program: Program,
    met: Arrays,
    samples: Any,
    wanted: Sequence[int],
    before: Before | None = None,
) -> Steps | None:
    """Steps in which constants show, with JAX's results."""
    step = Step(program)
    around = whereabouts(own, program.state, program.inputs, met, samples)
    if len(step.order) > LONG:
        around = replace(around, wide=-np.log10(EPS[program.precision]))

    def ran(states: Arrays, given: Arrays) -> tuple[Arrays, Arrays]:
        return _ran(own, jax.tree.structure(samples), states, given, wanted)

    found = search(step, around, lambda *given: _roots(program, *ran(*given)), before)
    if not found.chosen.steps:
        return None
    return _judged(step, found, around, *ran(found.states, found.samples))


def _ran(
    own: ReferenceFilter, tree: Any, states: Arrays, samples: Arrays, wanted: Sequence[int]
) -> tuple[Arrays, Arrays]:
    """The next states and the outputs by JAX, as many steps at once as were compiled."""
    parts = []
    count = len((states or samples)[0])
    for at in range(0, count, SAMPLES):
        rows = slice(at, at + SAMPLES)
        given = jax.tree.unflatten(tree, [x[rows] for x in samples])
        after, outputs = own.run(given, [x[rows] for x in states])
        parts.append([*after, *(outputs[k] for k in wanted)])
    whole = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return whole[: len(states)], whole[len(states) :]


def _roots(program: Program, after: Arrays, outputs: Arrays) -> tuple[np.ndarray, np.ndarray]:
    """The stored entries of states and outputs, ``(roots, B)``; and with the other halves.

    JAX's halves of a symmetric matrix may differ, and C with loops has both.
    """
    fields = list(zip([*program.state, *program.outputs], [*after, *outputs], strict=True))
    own = [column(x, i) for f, x in fields for i in f.entries()]
    others = [column(x, i[::-1] if f.half else i) for f, x in fields for i in f.entries()]
    return np.array(own, float), np.array(others, float)


def _judged(step: Step, found: Found, around: Around, after: Arrays, outputs: Arrays) -> Steps:
    """The steps with their tolerances, which take in how far JAX is from the formulas."""
    program = step.program
    given = by_node(program, found.states, found.samples)
    right = expected(step, given, np.random.default_rng(1))
    right = with_others(step, right, _roots(program, after, outputs))
    found.chosen.show(found.faint, largest_moves(step, found.faint, right) > 1)
    kept = found.chosen.fewest(STEPS, right.steady.tolist())
    same = np.isin(np.arange(len(right.steady)), kept)
    right = right.of(same)
    most, rest = by_field(program.state, allowed(step, right))
    most_out, _ = by_field(program.outputs, rest)
    missed = undetected(step, right)
    return Steps(
        [x[same] for x in found.states],
        [x[same] for x in found.samples],
        [x[same] for x in outputs],
        [x[same] for x in after],
        most_out,
        most,
        len(step.mutants),
        missed,
        found.idle.intersection(missed),
        found.tried,
        around,
        formulas(step),
    )


def drawn_steps(
    own: ReferenceFilter, met: Arrays, samples: Any, wanted: Sequence[int], share: float
) -> Steps | None:
    """Steps from states of all sizes, without a search; what is allowed follows from JAX alone.

    Args:
        own: the filter.
        met: states that it was in, a field each, time first.
        samples: its inputs, time first.
        wanted: which of its outputs, flat, are included.
        share: tolerance of a number relative to its size.
    """
    leaves, tree = jax.tree.flatten(samples)
    state, inputs = (
        [Field("", x.shape[1:], kind_of(x.dtype)) for x in part] for part in (met, leaves)
    )
    draw = np.random.default_rng(0)
    around = whereabouts(own, state, inputs, met, samples)
    drawn = [[_near(x, own.dtype, 0 * x) for x in part] for part in around.drawn(draw, SAMPLES)]

    def ran(by: ReferenceFilter, errors: float) -> Arrays:
        before, given = (
            [_near(x, by.dtype, errors * draw.uniform(-1, 1, x.shape)) for x in part]
            for part in drawn
        )
        after, outputs = by.run(jax.tree.unflatten(tree, given), before)
        return [np.asarray(x, float) for x in (*after, *(outputs[k] for k in wanted))]

    found = ran(own, 0.0)
    others = [ran(own, 4 * float(np.finfo(own.dtype).eps)) for _ in range(3)]
    others.append(ran(replace(own, dtype=np.float64), 0.0))
    good = _finite(found, others, len(met))
    if not len(good):
        return None
    size = [np.abs(x.reshape(SAMPLES, int(np.prod(x.shape[1:])))).max(axis=1) for x in found]
    order = good[np.argsort(np.max(size[: len(met)], axis=0)[good])]
    which = order[np.linspace(0, len(order) - 1, _UNSEARCHED).astype(int)]
    allowed = [_allowed(x, [other[k] for other in others], share) for k, x in enumerate(found)]
    right, most = ([x[which] for x in part] for part in (found, allowed))
    starts, given = ([x[which] for x in part] for part in drawn)
    n = len(met)
    ends = right[n:], right[:n], most[n:], most[:n]
    return Steps(starts, given, *ends, 0, [], set(), SAMPLES, around, [])


def _near(x: np.ndarray, dtype: type[np.floating], errors: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        return np.asarray((x * (1 + errors)).astype(dtype) if x.dtype.kind == "f" else x)


def _allowed(found: np.ndarray, others: Arrays, share: float) -> np.ndarray:
    """One tolerance for all entries of a field, whose small ones are differences of large ones."""
    with np.errstate(invalid="ignore"):
        apart = [np.abs(np.nan_to_num(other - found)) for other in others]
    each = 4 * np.max(apart, axis=0) + share * np.abs(np.nan_to_num(found))
    axes = tuple(range(1, found.ndim))
    return np.asarray(np.broadcast_to(each.max(axis=axes, keepdims=True), found.shape))


def _finite(found: Arrays, others: Sequence[Arrays], states: int) -> np.ndarray:
    """Steps to a finite state, whatever the rounding errors are; outputs may be missing."""
    good = np.ones(SAMPLES, bool)
    for k, x in enumerate(found):
        missing = np.isnan(x) & (k >= states)
        for other in (found, *others):
            same = np.where(missing, np.isnan(other[k]), np.isfinite(other[k]))
            good &= same.reshape(SAMPLES, int(np.prod(x.shape[1:]))).all(axis=1)
    return np.flatnonzero(good)
