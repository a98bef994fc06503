"""Objectives, and the score of a filter by one."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal, NamedTuple, Protocol, TypeAlias, TypeGuard, cast

import jax
import jax.numpy as jnp
from jax import Array

from filters import AnyFilter, Settling, run, run_kept, summed
from filters.protocol import step_of
from objectives.kinds import Additive
from objectives.likelihood import InnovationLikelihood, Likely


class Fold(Protocol):
    """An objective inside the time loop: it accumulates a sum, and may keep values of samples."""

    def init(self) -> Any:
        """The sum before the first sample, any pytree."""
        ...

    def update(self, total: Any, output: Any, truth: Any) -> tuple[Any, Any]:
        """One sample: the new sum, and the values to be kept of this sample (None: nothing)."""
        ...

    def value(self, total: Any, kept: Any) -> Array:
        """One number from the final sum and the kept values, stacked along time."""
        ...


Measure: TypeAlias = Callable[[Any, Any], Array]
Objective: TypeAlias = Fold | Measure
"""A :class:`Fold`, or a plain function of a filter's stacked outputs and the truth: one number.

Where no filter is run, the function takes the parameters themselves in place of the outputs: it
judges a design.
"""


Way: TypeAlias = Literal["forwards", "backwards", "backwards in parts"]
"""How a time loop is differentiated: see :func:`score_and_gradient`."""
Build: TypeAlias = Callable[[Array], Any]
"""From a point to a filter's parameters."""


class Data(NamedTuple):
    """The data that a filter is scored on.

    Attributes:
        inputs: the filter's inputs, a pytree whose leaves have time first, ``(N, ...)``.
        truth: the reference of the outputs; for a :class:`Fold`, with time first.
    """

    inputs: Any
    truth: Any

    @property
    def samples(self) -> int:
        """Number of samples N of the inputs; 1 where there are none.

        >>> Data((jnp.zeros((5, 2)), jnp.zeros(5)), None).samples, Data(None, None).samples
        (5, 1)
        """
        leaves = jax.tree.leaves(self.inputs)
        return len(leaves[0]) if leaves else 1


@dataclass(frozen=True)
class Folded:
    """A filter with an objective in its loop: the state is the pair, the output the kept values."""

    filter: AnyFilter
    fold: Fold

    def init(self, params: Any) -> tuple[Any, Any]:
        """Both states before the first sample."""
        return self.filter.init(params), self.fold.init()

    def step(
        self, params: Any, state: tuple[Any, Any], inputs: Data
    ) -> tuple[tuple[Any, Any], Any]:
        """One sample of the filter, then of the objective."""
        inner, output = step_of(self.filter, params, state[0], inputs.inputs)
        total, kept = self.fold.update(state[1], output, inputs.truth)
        return (inner, total), kept


def score(filter: AnyFilter | None, objective: Objective, params: Any, data: Data) -> Array:
    """Run a filter over the data and score it: one number, differentiable in ``params``.

    Without a filter nothing is run, and the objective judges ``params`` themselves.

    Args:
        filter: the filter, or None.
        objective: from outputs and truth to one number, or a :class:`Fold`.
        params: the filter's.
        data: inputs and truth.

    >>> from filters import GyroscopeFilter, KownackiNoise
    >>> at_rest = Data(jnp.zeros(100), jnp.zeros(100))
    >>> error = lambda outputs, truth: ((outputs - truth) ** 2).mean()
    >>> float(score(GyroscopeFilter(dt=0.01), error, KownackiNoise.of(R=1e-4, Q=1.0), at_rest))
    0.0
    """
    return _judge(objective, data, _collect(filter, objective, params, data))


def score_and_gradient(
    filter: AnyFilter | None,
    objective: Objective,
    build: Build,
    z: Array,
    data: Data,
    *,
    way: Way = "forwards",
) -> tuple[Array, Array]:
    """The score and its gradient in z ``(n,)``, where ``build(z)`` gives the filter's parameters.

    Forwards the time loop carries n tangents and stores nothing for a way back; what follows the
    loop is differentiated backwards in any case: one transform of the outputs serves all n
    parameters. Backwards the loop takes the time of a few passes, however large n is, and stores
    what it needs of each sample. In parts it stores little and is run twice, which is faster where
    a sample needs much, as an extended filter's does: see :func:`filters.run_kept`.

    Args:
        filter: the filter, or None.
        objective: what is scored.
        build: from z to the filter's parameters.
        z: the point.
        data: inputs and truth.
        way: how the time loop is differentiated; the gradients differ by rounding alone.
    """
    if way != "forwards":
        parts = way == "backwards in parts"
        whole = partial(_score_kept, filter, objective, data=data, parts=parts)
        value, gradient = jax.value_and_grad(lambda at: whole(build(at)))(z)
        return value, gradient
    collected, tangents = _forwards(lambda at: _collect(filter, objective, build(at), data), z)
    return judged(objective, data, collected, tangents)


def sum_and_gradient(
    filter: AnyFilter, objective: Fold, build: Build, z: Array, data: Data, *, way: Way = "forwards"
) -> tuple[Any, Array]:
    """The sum of an objective that keeps nothing else, and the gradient of its first number.

    Sums of parts of the data add up, and so do their gradients. Arguments as of
    :func:`score_and_gradient`.

    Returns:
        The sum, and the gradient ``(n,)``.
    """
    if way != "forwards":
        over = partial(run_kept, parts=way == "backwards in parts")

        def first(at: Array) -> tuple[Array, Any]:
            total, _ = _collect(filter, objective, build(at), data, over)
            return total[0], total

        (_, total), gradient = jax.value_and_grad(first, has_aux=True)(z)
        return total, gradient
    total, tangents = _forwards(lambda at: _collect(filter, objective, build(at), data)[0], z)
    return total, tangents[0]


def judged(
    objective: Objective, data: Data, collected: tuple[Any, Any], tangents: tuple[Any, Any]
) -> tuple[Array, Array]:
    """The score from the results of a time loop, and its gradient.

    Args:
        objective: the objective.
        data: inputs and truth.
        collected: the sum of an objective that takes part in the loop, and what it kept; of another
            one None, and the filter's outputs, time first.
        tangents: their derivatives by each of n coordinates, stacked first.

    Returns:
        The score ``()`` and its gradient ``(n,)``.
    """
    value, weights = weighed(objective, data, collected)
    return value, _chain(weights, tangents)


def weighed(objective: Objective, data: Data, collected: tuple[Any, Any]) -> tuple[Array, Any]:
    """The score from the results of a time loop, and its derivative by each of them.

    Args:
        objective: the objective.
        data: inputs and truth.
        collected: as of :func:`judged`.

    Returns:
        The score ``()``, and the derivatives in the form of ``collected``.
    """
    value, pull = jax.vjp(lambda seen: _judge(objective, data, seen), collected)
    (weights,) = pull(jnp.ones_like(value))
    return value, weights


def scores_and_gradients(
    filter: AnyFilter | None, objective: Objective, build: Build, Z: Array, data: Data
) -> tuple[Array, Array]:
    """The same at many points Z ``(B, n)`` in one time loop: scores ``(B,)``, gradients ``(B, n)``.

    The points lie side by side in memory and each tangent apart, which lets the loop's arithmetic
    run on whole vector registers.
    """
    collect = jax.vmap(lambda at: _collect(filter, objective, build(at), data))
    collected, tangents = _forwards(collect, Z)
    values, pull = jax.vjp(jax.vmap(lambda seen: _judge(objective, data, seen)), collected)
    (weights,) = pull(jnp.ones_like(values))
    return values, jax.vmap(_chain, in_axes=(0, 1))(weights, tangents)


@dataclass(frozen=True)
class _Adding:
    """A filter whose output is the objective's terms of each sample."""

    filter: AnyFilter
    objective: Additive

    def init(self, params: Any) -> Any:
        """The filter's state."""
        return self.filter.init(params)

    def step(self, params: Any, state: Any, inputs: Data) -> tuple[Any, tuple[Array, Array]]:
        """One sample of the filter, and its terms."""
        state, output = step_of(self.filter, params, state, inputs.inputs)
        return state, self.objective.added(output, inputs.truth)


def contributions(
    filter: AnyFilter, objective: Additive, params: Any, data: Data
) -> tuple[Array, Array]:
    """Contribution of each sample to an objective, and the number of terms that count.

    Args:
        filter: the filter.
        objective: a likelihood or a mean square.
        params: the filter's.
        data: inputs and truth.

    Returns:
        Both of the shape that the objective adds in, time first: ``(N, m)`` for m measurements,
        ``(N, k, m)`` for k records side by side. The sums' ratio is the objective, or its square.

    >>> from filters import LevelSample, LocalLevel, LocalLevelNoise
    >>> from objectives import InnovationLikelihood
    >>> data = Data(LevelSample(jnp.arange(5.0)), jnp.zeros((5, 1)))
    >>> noise, likelihood = LocalLevelNoise(jnp.array(1.0), jnp.array(1.0)), InnovationLikelihood()
    >>> nats, counts = contributions(LocalLevel(dt=1.0), likelihood, noise, data)
    >>> bool(nats.sum() / counts.sum() == score(LocalLevel(dt=1.0), likelihood, noise, data))
    True
    """
    _, (amounts, counted) = run(_Adding(filter, objective), params, data)
    return amounts, counted


def kept_bytes(filter: AnyFilter | None, objective: Objective, params: Any, data: Data) -> int:
    """Memory in bytes that one run keeps beyond its time loop."""
    _, kept = _collected.eval_shape(filter, objective, params, data)
    return sum(leaf.size * leaf.dtype.itemsize for leaf in jax.tree.leaves(kept))


def is_fold(objective: Objective) -> TypeGuard[Fold]:
    """Whether an objective takes part in the time loop."""
    return hasattr(objective, "update")


def _score_kept(
    filter: AnyFilter | None, objective: Objective, params: Any, data: Data, *, parts: bool
) -> Array:
    over = partial(run_kept, parts=parts)
    return _judge(objective, data, _collect(filter, objective, params, data, over))


def _collect(
    filter: AnyFilter | None,
    objective: Objective,
    params: Any,
    data: Data,
    over: Callable[..., tuple[Any, Any]] = run,
) -> tuple[Any, Any]:
    """The loop's part: the objective's sum and the kept values, or all outputs."""
    if filter is None:
        return None, params
    if isinstance(filter, Settling):
        if isinstance(objective, InnovationLikelihood):
            backwards = over is not run
            short = summed(filter, params, data, objective.added, again=backwards)
            if short is not None:
                return Likely(*short[0]), None
        filter = filter.filter
    if is_fold(objective):
        (_, total), kept = over(Folded(filter, objective), params, data)
        return total, kept
    return None, over(filter, params, data.inputs)[1]


_collected = jax.jit(_collect, static_argnums=(0, 1))  # remembers the shapes it has worked out


def _judge(objective: Objective, data: Data, collected: tuple[Any, Any]) -> Array:
    """The part after the loop: one number."""
    if is_fold(objective):
        return objective.value(*collected)
    return cast("Measure", objective)(collected[1], data.truth)


def _forwards(function: Callable[[Array], Any], point: Array) -> tuple[Any, Any]:
    """``function(point)`` and its derivative by each coordinate of the last axis, stacked first."""
    basis = jnp.eye(point.shape[-1])
    along = jax.vmap(
        lambda unit: jax.jvp(function, (point,), (jnp.broadcast_to(unit, point.shape),)),
        out_axes=(None, 0),
    )
    return along(basis)


def _chain(weights: Any, tangents: Any) -> Array:
    """The chain rule: sum over all leaves of weight times tangent, one number per tangent."""
    pairs = zip(jax.tree.leaves(weights), jax.tree.leaves(tangents), strict=True)
    parts = [jnp.tensordot(t, w, axes=w.ndim) for w, t in pairs if w.dtype != jax.dtypes.float0]
    return jnp.sum(jnp.stack(parts), axis=0)
