"""What a number does that no step of a self-test shows: one by one, by evaluation."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Literal

import numpy as np

from benchmarks.numbers_in_c import NUMBER, Changed, Moved
from benchmarks.specialised import Specialised, Told
from benchmarks.unsteady import Unsteady
from tuner.code.array_step import Step
from tuner.code.expected import LONG, allowed, comparable, expected
from tuner.code.limits import beside_limits
from tuner.code.mutants import CHANGE, Mutant
from tuner.code.selftest_tables import stored
from tuner.code.states import Around, Arrays, by_field, by_node, rounded

Kind = Literal[
    "proven",
    "by rounding",
    "without effect",
    "not reached",
    "only doubled",
    "below tolerance",
    "missed",
]
_NONE = 1e-28
"""Share of the largest result of a step, with 113 bits, below which a move is due to rounding."""
_ROUNDING = 1e-10
"""Share of the same move with fewer bits below which it is rounding."""
_TWICE, _LARGE = 1.0, (-0.999, 1e3, 1e6)
"""Changes over the number, and those that turn most of the decisions that it takes part in."""
_SAME = 1e-10
"""Difference of two numbers over them, up to which they are one."""
_ALIKE = 200
"""Most constants of one size that are looked at for a proof."""
_BATCH, _DRAWN, _FREE = 128, 6, 400
"""States looked at together; how often; and with decisions taken at random."""


@dataclass(frozen=True)
class Effect:
    """The effect of a number that a self-test does not see.

    Attributes:
        line: where it stands.
        kind: proven by the formulas to reach no result, or to do so only where rounding decides,
            which no self-test can have; without effect, whatever is decided, as far
            as was tried; with one under decisions that no state tried
            takes together; with one when it is doubled, but not by a thousandth; with one below
            what is allowed; or with a larger one, which the steps of the self-test miss.
        multiple: the largest move that a change by a thousandth makes, over what is allowed.
    """

    line: str
    kind: Kind
    multiple: float


class _Proofs:
    """What the formulas tell of constants that are not detected.

    Args:
        step: the formulas.
        undetected: these constants.
        plain: the C, for the order of its results.
    """

    def __init__(self, step: Step, undetected: Sequence[Mutant], plain: Changed) -> None:
        nodes = step.graph.nodes
        self._step, self._plain = step, plain
        self._loops = "for (" in plain.source  # where a choice may stand the other way round
        self._sizes = {
            one: abs(float(nodes[nodes[one.node].args[one.at]].value)) for one in undetected
        }
        self._unsteady, self._specialised = Unsteady(step), Specialised(step)
        self._known = dict[Mutant, Told | None]()

    def kind(self, line: str, value: float, moved: np.ndarray) -> Kind | None:
        """What is proven of a number; None: nothing.

        It is one of the constants of this size, or the inverse of one where it divides: one that
        reaches all results that it moves.

        Args:
            line: where it stands.
            value: the number.
            moved: which results it moves under some decisions, ``(results,)``.
        """
        same = [
            one
            for one, size in self._sizes.items()
            if self._is(one, size, abs(value))
            and (self._loops or one.at in _places(line, value))
            and self._reaches(one, moved)
        ]
        if not 0 < len(same) <= _ALIKE:
            return None
        told = {self._told(one) for one in same}
        if None in told:
            return None
        return "proven" if told == {"same"} else "by rounding"

    def _told(self, one: Mutant) -> Told | None:
        """What is proven of a constant; None: nothing."""
        if one not in self._known:
            way = self._step.ways.way(one)
            told = self._specialised.tells(one, way) if way is not None else "same"
            if told is None and way is not None and self._unsteady.always(one, way):
                told = "but for rounding"
            self._known[one] = told
        return self._known[one]

    def _is(self, one: Mutant, size: float, value: float) -> bool:
        """Whether a number may be this constant, or a divisor where it is a factor."""
        if np.isclose(size, value, rtol=_SAME, atol=0):
            return True
        factor = self._step.graph.nodes[one.node].op == "mul"
        return factor and bool(np.isclose(size, 1 / value, rtol=1e-6, atol=0))

    def _reaches(self, one: Mutant, moved: np.ndarray) -> bool:
        """Whether all these results depend on a constant."""
        if not moved.any():
            return True
        after = self._step.after([one.node])
        own = np.array([[root in after] for root in self._step.roots], float)
        return not (moved & (_in_c(self._step, self._plain, own)[0] == 0)).any()


def _places(line: str, value: float) -> Sequence[int]:
    """Which operands a number may be, by what stands before it, in C without loops."""
    numbers = [(float(one[1]), one[0][0]) for one in re.finditer(rf"[^\w.]\s*\(?-?{NUMBER}", line)]
    before = [sign for size, sign in numbers if np.isclose(size, abs(value), rtol=1e-7, atol=0)]
    places: Mapping[str, Sequence[int]] = {"?": [1], ":": [2]}
    return places.get(before[0], range(3)) if len(before) == 1 else range(3)


@dataclass(frozen=True, eq=False)
class _Looked:
    """Steps, with the tolerances of the results in the order of the C."""

    states: Arrays
    samples: Arrays
    allowed: np.ndarray


def effects(
    step: Step,
    around: Around,
    undetected: Sequence[Mutant],
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
    looked = list(_looked(step, around, undetected, plain, draw)) if hidden else []
    proofs = _Proofs(step, undetected, plain)
    for number, line in hidden.items():
        multiple = max((_multiple(plain, wide, number, one) for one in looked), default=0.0)
        kind: Kind = "missed"
        if multiple < 1:
            some = looked[:1] + looked[_DRAWN // 2 :] if len(step.order) > LONG else looked
            if any(_acts(plain, wide, number, one, CHANGE) for one in some):
                kind = "below tolerance"
            elif any(_acts(plain, wide, number, one, _TWICE) for one in some):
                kind = "only doubled"
            else:
                moved = _unseen(step, around, plain, wide, number, draw)
                kind = "not reached" if moved.any() else "without effect"
                kind = proofs.kind(line, plain.value(number), moved) or kind
        yield Effect(line, kind, multiple)


def _looked(
    step: Step,
    around: Around,
    undetected: Sequence[Mutant],
    plain: Changed,
    draw: np.random.Generator,
) -> Iterator[_Looked]:
    """Steps near and far; of long ones those in which the C is well within what is allowed.

    A self-test could not have the others, since correct code fails in them.
    """
    program, own = step.program, len(around.states)
    long = len(step.order) > LONG
    few, many = (4, _DRAWN // 2) if long else (16, _DRAWN)
    batches = [around.drawn(draw, _BATCH) for _ in range(many)]
    wanted = {one.node for one in undetected if one in step.limits} if long else None
    beside = beside_limits(step, around, draw, wanted, late=True)
    for batch in [*batches, *islice(beside, few)]:
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


def _multiple(plain: Changed, wide: Changed, number: int, looked: _Looked) -> float:
    """The largest move of a result over what is allowed; a large one with 113 bits as well.

    Otherwise it is rounding that moved it.
    """
    found = _over(plain, number, looked)
    large = (found >= 1).any(axis=1)
    if large.any():
        part = ([x[large] for x in both] for both in (looked.states, looked.samples))
        some = _Looked(*part, looked.allowed[large])
        found[large] = np.minimum(found[large], _over(wide, number, some))
    return float(found.max(initial=0))


def _over(by: Changed, number: int, looked: _Looked) -> np.ndarray:
    apart = by.moved(number, CHANGE, looked.states, looked.samples).apart
    with np.errstate(all="ignore"):
        return np.asarray(np.nan_to_num(np.abs(apart) / looked.allowed, posinf=np.inf))


def _acts(plain: Changed, wide: Changed, number: int, looked: _Looked, change: float) -> bool:
    """Whether a change moves a result."""
    given = number, change, looked.states, looked.samples
    return bool(_shows(wide.moved(*given), plain.moved(*given)).any())


def _shows(found: Moved, rounded: Moved) -> np.ndarray:
    """Which results move with 113 bits, and not by rounding, which fewer bits show more."""
    exact, coarse = _shares(found), _shares(rounded)
    by_rounding = coarse[np.isfinite(coarse)].max(initial=0)
    moves = np.isfinite(exact) & (exact > max(_NONE, _ROUNDING * by_rounding))
    return np.asarray((moves | (np.isinf(exact) & np.isinf(coarse).any())).any(axis=0))


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
) -> np.ndarray:
    """The results that a number moves under any decisions, whether a state takes them or not.

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
        moved = _shows(one, found(plain, change, forces))
        if change in (CHANGE, _TWICE) and moved.any():
            return moved
        turned |= one.turned.any(axis=0)
    for k in np.flatnonzero(turned):
        sides = [forces.copy(), forces.copy()]
        sides[0][:, k], sides[1][:, k] = -1, 1
        moved = _shows(found(wide, CHANGE, *sides), found(plain, CHANGE, *sides))
        if moved.any():
            return moved
    return np.zeros(len(moved), bool)
