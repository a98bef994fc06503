"""The content of a time loop, from leaves to leaves, and its functions with derivatives."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any, TypeAlias

import jax
import numpy as np
from jax import Array

from filters import AnyFilter, run
from objectives import Data, Folded, Objective, is_fold
from objectives.in_numpy import in_numpy
from tuner.code.interpreter import Arrays
from tuner.code.straight_line import Slot, straight_line
from tuner.native.active import moved

Leaves: TypeAlias = Sequence[Any]


@dataclass(frozen=True, eq=False)
class Runner:
    """The content of a time loop.

    Attributes:
        start: from parameters to the state before the first sample.
        step: from parameters, state and sample to the next state and the kept values.
        params: values of the parameters; those that depend on a point may be any.
        moved: the coordinates of a point that each of their numbers depends on: each leaf's shape
            and ``(size,)``.
        state: before the first sample, for its shapes and types.
        sample: one sample, for its shapes and types.
        wanted: which leaves of the state are needed at the end.
        keeps: which leaves of the kept values are needed.
    """

    start: Callable[[Leaves], Leaves]
    step: Callable[[Leaves, Leaves, Leaves], Leaves]
    params: Arrays
    moved: Arrays
    state: Arrays
    sample: Arrays
    wanted: list[bool]
    keeps: list[bool]


def is_real(leaf: Any) -> bool:
    """Whether an array has derivatives."""
    return bool(np.dtype(leaf.dtype).kind == "f")


def columns(record: Any) -> np.ndarray:
    """A record as rows of numbers, ``(N, k)``.

    Args:
        record: arrays with time first.
    """
    leaves = [np.asarray(leaf, float) for leaf in jax.tree.leaves(record)]
    whole = np.hstack([leaf.reshape(len(leaf), prod(leaf.shape[1:])) for leaf in leaves])
    return np.ascontiguousarray(whole)


def with_slopes(
    function: Callable[..., Leaves], moving: Sequence[Leaves], fixed: Sequence[Leaves] = ()
) -> Any:
    """A traced function of lists of leaves, with derivatives along a direction.

    It takes the leaves that move, the direction in those of them that are real, and the leaves that
    are fixed; its results are followed by the derivatives of those that are real.
    """
    leaves, tree = jax.tree.flatten(list(moving))
    real = [is_real(leaf) for leaf in leaves]

    def both(leaves: Leaves, slopes: Leaves, fixed: Sequence[Leaves]) -> Any:
        def of_real(numbers: Leaves) -> list[Any]:
            rest = iter(numbers)
            whole = [next(rest) if r else leaf for r, leaf in zip(real, leaves, strict=True)]
            return list(function(*jax.tree.unflatten(tree, whole), *fixed))

        at = [leaf for r, leaf in zip(real, leaves, strict=True) if r]
        found, changes = jax.jvp(of_real, (at,), (slopes,))
        return found, [d for x, d in zip(found, changes, strict=True) if is_real(x)]

    directions = [leaf for r, leaf in zip(real, leaves, strict=True) if r]
    return jax.make_jaxpr(both)(leaves, directions, list(fixed))


def runner_of(
    filter: AnyFilter, objective: Objective, build: Callable[[Array], Any], z: Array, data: Data
) -> Runner:
    """The loop of a filter that is judged by an objective.

    An objective inside the loop provides its sum at the end; for another one the outputs that it
    uses are kept.

    Args:
        filter: the filter.
        objective: the objective.
        build: the map from a point to the filter's parameters.
        z: a point, ``(n,)``.
        data: shapes and types of a record, or the record.
    """
    folds = is_fold(objective)
    whole = Folded(filter, objective) if is_fold(objective) else filter
    params, params_tree = jax.tree.flatten(in_numpy(build, z))
    record = data if folds else data.inputs
    sample, sample_tree = jax.tree.flatten(record)
    sample = [np.zeros(leaf.shape[1:], leaf.dtype) for leaf in sample]
    state, state_tree = jax.tree.flatten(
        jax.eval_shape(whole.init, jax.tree.unflatten(params_tree, params))
    )
    state = [np.zeros(leaf.shape, leaf.dtype) for leaf in state]

    def start(params: Leaves) -> Leaves:
        return jax.tree.leaves(whole.init(jax.tree.unflatten(params_tree, params)))

    def step(params: Leaves, state: Leaves, sample: Leaves) -> Leaves:
        after, kept = whole.step(
            jax.tree.unflatten(params_tree, params),
            jax.tree.unflatten(state_tree, state),
            jax.tree.unflatten(sample_tree, sample),
        )
        return [*jax.tree.leaves(after), *jax.tree.leaves(kept)]

    total = len(jax.tree.leaves(jax.eval_shape(objective.init))) if is_fold(objective) else 0
    wanted = [k >= len(state) - total for k in range(len(state))]
    kept = jax.eval_shape(step, params, state, sample)[len(state) :]
    keeps = (
        [True] * len(kept)
        if folds
        else _looked_at(objective, filter, jax.tree.unflatten(params_tree, params), data)
    )
    params = [np.asarray(leaf) for leaf in params]
    return Runner(start, step, params, moved(build, z.size), state, sample, wanted, keeps)


def _looked_at(objective: Any, filter: AnyFilter, params: Any, data: Data) -> list[bool]:
    """Which outputs an objective uses."""
    outputs = jax.eval_shape(lambda inputs: run(filter, params, inputs)[1], data.inputs)
    leaves, tree = jax.tree.flatten(outputs)
    judged = jax.make_jaxpr(lambda seen, truth: objective(jax.tree.unflatten(tree, seen), truth))
    given = [Slot(leaf.shape, leaf.dtype) for leaf in (*leaves, *jax.tree.leaves(data.truth))]
    uses = straight_line(judged(leaves, data.truth), given).uses
    return [slot in uses for slot in given[: len(leaves)]]
