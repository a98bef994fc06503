"""Varying sample times for any filter that has one."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from jax import Array

from filters.protocol import AnyFilter


class TimedSample(NamedTuple):
    """A filter's inputs and the time since the previous sample, s, ``()``."""

    dt: Array
    inputs: Any


@dataclass(frozen=True)
class Timed:
    """A filter whose sample time ``dt`` comes with every sample.

    Attributes:
        filter: the filter; its own ``dt`` is not used.

    >>> import jax.numpy as jnp
    >>> from filters import AngleSample, Complementary, ComplementaryGain, run
    >>> turning = AngleSample(jnp.ones(2), jnp.full(2, jnp.nan))
    >>> samples = TimedSample(jnp.array([0.25, 0.5]), turning)
    >>> still = ComplementaryGain(jnp.array(1.0), jnp.array(0.0))
    >>> run(Timed(Complementary(dt=1.0)), still, samples)[1].tolist()
    [0.25, 0.75]
    """

    filter: Any
    same_params = True

    def __post_init__(self) -> None:
        if "dt" not in getattr(self.filter, "__dataclass_fields__", {}):
            raise ValueError(
                f"{type(self.filter).__name__} has no sample time dt, so it takes no varying ones"
            )

    def init(self, params: Any) -> Any:
        """The filter's own start."""
        return self.filter.init(params)

    def step(self, params: Any, state: Any, inputs: TimedSample) -> tuple[Any, Any]:
        """Take one sample after the time that has passed."""
        now: AnyFilter = replace(self.filter, dt=inputs.dt)
        stepped: tuple[Any, Any] = now.step(params, state, inputs.inputs)
        return stepped
