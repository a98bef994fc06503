"""The protocol of a filter, and the one time loop that runs every filter."""

from collections.abc import Callable
from typing import Any, Protocol, TypeAlias, TypeVar, cast

import jax

from filters.small_linalg import unfolded

P_contra = TypeVar("P_contra", contravariant=True)
S = TypeVar("S")
U_contra = TypeVar("U_contra", contravariant=True)
Y_co = TypeVar("Y_co", covariant=True)


class Filter(Protocol[P_contra, S, U_contra, Y_co]):
    """A frozen dataclass with two pure methods; its fields are static (sizes, flags, names).

    Equal instances are interchangeable for ``jax.jit``, so they share one compilation.
    """

    def init(self, params: P_contra) -> S:
        """The state before the first sample."""
        ...

    def step(self, params: P_contra, state: S, inputs: U_contra) -> tuple[S, Y_co]:
        """Take one sample: the next state and the outputs."""
        ...


AnyFilter: TypeAlias = Filter[Any, Any, Any, Any]


def run(
    filter: Filter[P_contra, S, U_contra, Y_co], params: P_contra, inputs: Any, *, unroll: int = 1
) -> tuple[S, Any]:
    """Run a filter over a record: the one time loop of this project.

    Args:
        filter: any :class:`Filter`.
        params: its parameters, a pytree of arrays.
        inputs: its inputs, a pytree whose leaves have time as their first axis, ``(N, ...)``.
        unroll: steps per iteration of the compiled loop; 4 makes a forward pass about a tenth
            faster, and a gradient four times slower.

    Returns:
        ``(state, outputs)``: the state after the last sample, and the outputs stacked along time.
        What a caller drops inside ``jax.jit`` is never stored.

    >>> from filters import GyroscopeFilter, KownackiNoise
    >>> import jax.numpy as jnp
    >>> state, rate = run(GyroscopeFilter(dt=0.01), KownackiNoise.of(R=1e-4, Q=1.0), jnp.ones(500))
    >>> rate.shape
    (500,)
    """
    params = unfolded(params, inputs)
    start = filter.init(params)
    return over_time(lambda s, u: step_of(filter, params, s, u), start, inputs, unroll=unroll)


def step_of(filter: Any, params: Any, state: Any, inputs: Any) -> tuple[Any, Any]:
    """A filter's step, which is traced once for all programs that it is a part of.

    A filter that cannot be told from others, for it has no hash, is traced anew each time.
    """
    try:
        hash(filter)
    except TypeError:
        stepped: tuple[Any, Any] = filter.step(params, state, inputs)
    else:
        stepped = _traced(filter, params, state, inputs)
    return stepped


_traced = jax.jit(
    lambda filter, params, state, inputs: filter.step(params, state, inputs),
    static_argnums=0,
    inline=True,
)


def over_time(
    step: Callable[[S, Any], tuple[S, Any]], start: S, inputs: Any, *, unroll: int = 1
) -> tuple[S, Any]:
    """The last state and the stacked outputs of a step along the first axis of its inputs.

    Args:
        step: the step, from a state and one sample to the next state and the outputs.
        start: the state before the first sample.
        inputs: a pytree whose leaves have time as their first axis, ``(N, ...)``.
        unroll: steps per iteration of the compiled loop.

    >>> import jax.numpy as jnp
    >>> end, sums = over_time(lambda total, u: (total + u, total + u), 0.0, jnp.arange(4.0))
    >>> float(end), sums.tolist()
    (6.0, [0.0, 1.0, 3.0, 6.0])
    """
    return cast("tuple[S, Any]", jax.lax.scan(step, start, inputs, unroll=unroll))
