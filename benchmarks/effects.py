"""What a number does that no step of a self-test shows: one by one, by evaluation."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Literal

import numpy as np

from benchmarks.numbers_in_c import Changed, Moved
from tuner.code.array_step import Step
from tuner.code.detection import LONG, allowed, comparable, expected
from tuner.code.limits import beside_limits
from tuner.code.mutants import CHANGE, Mutant
from tuner.code.needed import Ways
from tuner.code.selftest_tables import stored
from tuner.code.states import Around, Arrays, by_field, by_node, rounded

Kind = Literal[
    "proven", "without effect", "not reached", "only doubled", "below tolerance", "missed"
]
_NONE = 1e-28
"""Share of the largest result of a step, with 113 bits, below which a move is due to rounding."""
_ROUNDING = 1e-10
"""Share of the same move with fewer bits below which it is rounding."""
_TWICE, _LARGE = 1.0, (-0.999, 1e3, 1e6)
"""Changes over the number, and those that turn most of the decisions that it takes part in."""
_ALIKE = 100
"""Most constants of one size that are looked at for a proof."""
_BATCH, _DRAWN, _FREE = 128, 6, 400
"""States looked at together; how often; and with decisions taken at random."""


@dataclass(frozen=True)
class Effect:
    """The effect of a number that a self-test does not see.

    Attributes:
        line: where it stands.
        kind: proven by the formulas to reach no result; without effect, whatever is decided, as far
            as was tried; with one under decisions that no state tried
            takes together; with one when it is doubled, but not by a thousandth; with one below
            what is allowed; or with a larger one, which the steps of the self-test miss.
        multiple: the largest move that a change by a thousandth makes, over what is allowed.
    """

    line: str
    kind: Kind
    multiple: float


def _proven(step: Step, ways: Ways, undetected: Collection[Mutant], value: float) -> bool:
    """Whether no constant of this size that is not detected reaches a result, whatever is decided.

    The number is one of them, or the inverse of one where it divides.
    """
    nodes = step.graph.nodes
    sizes = {one: abs(float(nodes[nodes[one.node].args[one.at]].value)) for one in undetected}
    near = (abs(value), 1 / abs(value))
    same = [one for one, size in sizes.items() if np.isclose(size, near, rtol=1e-6, atol=0).any()]
    return 0 < len(same) <= _ALIKE and all(ways.way(one) is None for one in same)


@dataclass(frozen=True, eq=False)
class _Looked:
    """Steps, with the tolerances of the results in the order of the C."""

    states: Arrays
    samples: Arrays
    allowed: np.ndarray


def effects(
    step: Step,
    around: Around,
    undetected: Collection[Mutant],
    plain: Changed,
    wide: Changed,
    hidden: dict[int, str],
) -> Iterator[Effect]:
    """The effect of each of these numbers.

    Args:
        step: the formulas of the filter.
        around: where states are drawn.
        undetected: the constants of the formulas that do not show either.
        plain: its C.
        wide: the same with 113 bits.
        hidden: the numbers, with the line of each.
    """
    draw = np.random.default_rng(5)
    looked = list(_looked(step, around, plain, draw)) if hidden else []
    ways = Ways(step.graph, step.order, step.roots)
    for number, line in hidden.items():
        multiple = max((_multiple(plain, number, one) for one in looked), default=0.0)
        kind: Kind = "missed"
        if multiple < 1:
            some = looked[:1] + looked[-1:] if len(step.order) > LONG else looked
            if any(_acts(plain, wide, number, one, CHANGE) for one in some):
                kind = "below tolerance"
            elif any(_acts(plain, wide, number, one, _TWICE) for one in some):
                kind = "only doubled"
            else:
                kind = _unseen(step, around, plain, wide, number, draw)
                if _proven(step, ways, undetected, plain.value(number)):
                    kind = "proven"
        yield Effect(line, kind, multiple)


def _looked(
    step: Step, around: Around, plain: Changed, draw: np.random.Generator
) -> Iterator[_Looked]:
    """Steps near and far; of long ones those in which the C is well within what is allowed.

    A self-test could not have the others, since correct code fails in them.
    """
    program, own = step.program, len(around.states)
    long = len(step.order) > LONG
    few, many = (2, _DRAWN // 2) if long else (16, _DRAWN)
    batches = [around.drawn(draw, _BATCH) for _ in range(many)]
    for batch in [*batches, *islice(beside_limits(step, around, draw), few)]:
        states, samples = (rounded(part, program.precision) for part in batch)
        given = by_node(program, states, samples)
        right = expected(step, given, draw)
        good = comparable(step, right)
        kept = [x[good] for x in (*states, *samples)]
        tolerances = _in_c(step, plain, allowed(step, right)[:, good])
        if long and good.any():
            by_c = plain.moved(0, 0.0, kept[:own], kept[own:]).right
            exact = _in_c(step, plain, right.exact[:, good])
            with np.errstate(invalid="ignore"):
                near = np.nan_to_num(np.abs(by_c - exact), posinf=0, neginf=0) <= tolerances / 4
            same = (near & (np.isnan(by_c) == np.isnan(exact))).all(axis=1)
            kept, tolerances = [x[same] for x in kept], tolerances[same]
        if len(tolerances):
            yield _Looked(kept[:own], kept[own:], tolerances)


def _in_c(step: Step, plain: Changed, roots: np.ndarray) -> np.ndarray:
    """Numbers of the results of the formulas in the order of the C, ``(B, results)``."""
    state, rest = by_field(step.program.state, roots)
    outputs, _ = by_field(step.program.outputs, rest)
    return np.hstack([*stored(plain.code.state, state), *stored(plain.code.outputs, outputs)])


def _multiple(plain: Changed, number: int, looked: _Looked) -> float:
    apart = plain.moved(number, CHANGE, looked.states, looked.samples).apart
    with np.errstate(all="ignore"):
        return float(np.nan_to_num(np.abs(apart) / looked.allowed, posinf=np.inf).max(initial=0))


def _acts(plain: Changed, wide: Changed, number: int, looked: _Looked, change: float) -> bool:
    """Whether a change moves a result."""
    given = number, change, looked.states, looked.samples
    return _shows(wide.moved(*given), plain.moved(*given))


def _shows(found: Moved, rounded: Moved) -> bool:
    """Whether a result moves with 113 bits, and not by rounding, which fewer bits show more."""
    exact, coarse = _shares(found), _shares(rounded)
    missing = bool(np.isinf(exact).any() and np.isinf(coarse).any())
    largest, by_rounding = (one[np.isfinite(one)].max(initial=0) for one in (exact, coarse))
    return missing or bool(largest > max(_NONE, _ROUNDING * by_rounding))


def _shares(found: Moved) -> np.ndarray:
    """The moves over the largest result of each step."""
    size = np.where(np.isfinite(found.right), np.abs(found.right), 0).max(axis=1, keepdims=True)
    return np.asarray(np.abs(found.apart) / np.where(size > 0, size, 1.0))


def _unseen(
    step: Step,
    around: Around,
    plain: Changed,
    wide: Changed,
    number: int,
    draw: np.random.Generator,
) -> Kind:
    """Whether a number has an effect under any decisions, whether a state takes them or not.

    Decisions are taken at random; one that the number may turn is taken otherwise with it.
    """
    count = _FREE // 3 if len(step.order) > LONG else _FREE
    states, samples = around.drawn(draw, count)
    forces = draw.choice([-1, 1], (count, wide.decisions))
    forces[count // 2 :] *= draw.random((count - count // 2, wide.decisions)) < 1 / 2
    turned = np.zeros(wide.decisions, bool)

    def found(by: Changed, change: float, *sides: np.ndarray) -> Moved:
        return by.moved(number, change, states, samples, (sides[0], sides[-1]))

    for change in (CHANGE, _TWICE, *_LARGE):
        one = found(wide, change, forces)
        if change in (CHANGE, _TWICE) and _shows(one, found(plain, change, forces)):
            return "not reached"
        turned |= one.turned.any(axis=0)
    for k in np.flatnonzero(turned):
        sides = [forces.copy(), forces.copy()]
        sides[0][:, k], sides[1][:, k] = -1, 1
        if _shows(found(wide, CHANGE, *sides), found(plain, CHANGE, *sides)):
            return "not reached"
    return "without effect"
