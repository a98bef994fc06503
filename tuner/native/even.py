"""Symmetric matrices among the arrays of a loop, found by their values at random points."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from objectives.in_numpy.evaluate import KNOWN
from tuner.code.straight_line import Atom, Operation, Slot

LEAST = 8
"""Smallest matrix of which it pays to compute one half only."""
_APART = 1e-9
"""Share of its largest entry by which rounding may leave a matrix not symmetric."""
_TRIALS = 2


@dataclass(frozen=True)
class Carried:
    """An array that a loop carries from sample to sample, and its derivative, back.

    Attributes:
        before, after: at the beginning of an iteration, and at its end.
        value: one before the first iteration.
        even: whether it begins as a symmetric matrix.
    """

    before: Atom
    after: Atom
    value: np.ndarray
    even: bool


def even_slots(
    operations: Sequence[Operation],
    carried: Sequence[Carried],
    given: Mapping[Slot, np.ndarray],
) -> frozenset[Slot]:
    """The symmetric matrices of at least eight rows, in every iteration, but for rounding.

    Args:
        operations: of an iteration.
        carried: what the next iteration begins with.
        given: values of all else that it begins with; of parameters at a point where nothing is
            symmetric by chance.
    """
    halves = [one for one in carried if one.even]
    while True:
        trials = [_values(operations, carried, halves, given, trial) for trial in range(_TRIALS)]
        still = [one for one in halves if _everywhere(one.after, trials)]
        if len(still) == len(halves):
            break
        halves = still
    slots = {slot for values in trials for slot in values}
    return frozenset(slot for slot in slots if _everywhere(slot, trials))


def without_turns(
    operations: Sequence[Operation],
    results: Sequence[Atom],
    carried: Sequence[Carried],
    even: Collection[Slot],
) -> tuple[list[Operation], list[Atom]]:
    """The same without transposing symmetric matrices.

    What rounding leaves of a carried matrix that is not symmetric must not grow over the samples:
    nothing is changed where one does not come from products of which one half is computed.
    """
    if any(one.after in even and _passed_on(operations, one, even) for one in carried):
        return list(operations), list(results)
    same: dict[Slot, Atom] = {}

    def read(atom: Atom) -> Atom:
        return same.get(atom, atom) if isinstance(atom, Slot) else atom

    kept: list[Operation] = []
    for operation in operations:
        one = replace(operation, inputs=tuple(map(read, operation.inputs)))
        if one.name == "transpose" and one.inputs[0] in even:
            same[one.outputs[0]] = one.inputs[0]
        else:
            kept.append(one)
    return kept, [read(atom) for atom in results]


def _passed_on(operations: Sequence[Operation], carried: Carried, even: Collection[Slot]) -> bool:
    """Whether one half of a carried matrix has an effect on the other half of the next one."""
    reached = {carried.before}
    for one in operations:
        mirrored = one.name == "dot_general" and one.outputs[0] in even
        if not mirrored and not reached.isdisjoint(_slots(one.inputs)):
            reached |= set(one.outputs)
    return carried.after in reached


def _values(
    operations: Sequence[Operation],
    carried: Sequence[Carried],
    halves: Collection[Carried],
    given: Mapping[Slot, np.ndarray],
    trial: int,
) -> dict[Slot, np.ndarray]:
    """The results of an iteration that begins anywhere, as far as they are known."""
    draw = np.random.default_rng(trial)
    known = dict(given)
    for one in carried:
        if isinstance(one.before, Slot):
            known[one.before] = _drawn(draw, one.value, even=one in halves)
    with np.errstate(all="ignore"):
        for operation in operations:
            numbers = [known.get(a) if isinstance(a, Slot) else a for a in operation.inputs]
            if operation.name in KNOWN and not any(x is None for x in numbers):
                known.update(_found(operation, numbers))
    return known


def _found(operation: Operation, numbers: Sequence[np.ndarray | None]) -> dict[Slot, np.ndarray]:
    equation = operation.equation
    one = len(operation.outputs) == 1 and not equation.primitive.multiple_results
    if equation.primitive.name != operation.name:  # of a branch, whose both ways are computed
        found, one = np.where(numbers[0], numbers[2], numbers[1]), True  # type: ignore[arg-type]
    else:
        found = KNOWN[operation.name](*numbers, **equation.params)
    several = (found,) if one else found
    pairs = zip(operation.outputs, several, strict=True)
    return {slot: np.asarray(x, slot.dtype) for slot, x in pairs}


def _drawn(draw: np.random.Generator, value: np.ndarray, *, even: bool) -> np.ndarray:
    if value.dtype.kind != "f":
        return value
    if not even:
        return value + draw.normal(size=value.shape)
    root = draw.normal(size=value.shape)
    return np.asarray((value + value.T) / 2 + root @ root.T)


def _everywhere(atom: Atom, trials: Sequence[Mapping[Slot, np.ndarray]]) -> bool:
    return isinstance(atom, Slot) and all(_even(values.get(atom)) for values in trials)


def _even(x: np.ndarray | None) -> bool:
    if x is None or x.ndim != 2 or x.shape[0] != x.shape[1] or len(x) < LEAST:
        return False
    return bool(x.dtype.kind == "f" and np.abs(x - x.T).max() <= _APART * np.abs(x).max())


def _slots(atoms: Iterable[Atom]) -> list[Slot]:
    return [atom for atom in atoms if isinstance(atom, Slot)]
