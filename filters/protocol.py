"""What a filter is, and the one time loop that runs every filter."""

from typing import Protocol, TypeVar

import jax

Params = TypeVar("Params", contravariant=True)
State = TypeVar("State")
Inputs = TypeVar("Inputs", contravariant=True)
Outputs = TypeVar("Outputs", covariant=True)


class Filter(Protocol[Params, State, Inputs, Outputs]):
    """A frozen dataclass with two pure methods; its fields are static (sizes, flags, names).

    Equal instances are interchangeable for ``jax.jit``, so they share one compilation.
    """

    def init(self, params: Params) -> State:
        """The state before the first sample."""
        ...

    def step(self, params: Params, state: State, inputs: Inputs) -> tuple[State, Outputs]:
        """Take one sample: the next state and what the filter puts out."""
        ...


def run(filter: Filter, params, inputs, *, unroll: int = 1):
    """Run a filter over a record: the one time loop of this project.

    Args:
        filter: any :class:`Filter`.
        params: its parameters, a pytree of arrays.
        inputs: its inputs, a pytree whose leaves have time as their first axis, ``(N, ...)``.
        unroll: steps a turn of the compiled loop; 4 makes a forward pass about a tenth faster,
            and a gradient four times slower.

    Returns:
        ``(state, outputs)``: the state after the last sample, and the outputs stacked along time.
        What a caller drops inside ``jax.jit`` is never stored.

    >>> from filters import GyroscopeFilter, Noise
    >>> import jax.numpy as jnp
    >>> state, rate = run(GyroscopeFilter(dt=0.01), Noise.of(R=1e-4, Q=1.0), jnp.ones(500))
    >>> rate.shape
    (500,)
    """
    return jax.lax.scan(
        lambda state, sample: filter.step(params, state, sample),
        filter.init(params),
        inputs,
        unroll=unroll,
    )
