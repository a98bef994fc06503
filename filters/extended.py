"""The extended Kalman filter for any model, with Jacobians by JAX."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, TypeAlias

import jax
import jax.numpy as jnp
from jax import Array

from filters.declared import Channel
from filters.diffuse import AnyEstimate, AnyKind, advance, begin, take
from filters.linear import LinearOutputs

Move: TypeAlias = Callable[[Any, Array, Any], Array]
"""From the model's parameters, a state ``(n,)`` and the sample's known input."""


class ExtendedModel(NamedTuple):
    """What an extended Kalman filter is run with.

    Attributes:
        model: parameters of the model's functions, any pytree.
        R: variances of the measurements, ``(m,)``.
        x0: the start, ``(n,)``.
        P0: covariance of the start, ``(n, n)``; zero is allowed.
    """

    model: Any
    R: Array
    x0: Array
    P0: Array


class ExtendedSample(NamedTuple):
    """One sample's inputs; stacked along time for :func:`filters.run`.

    Attributes:
        z: measurements, ``(m,)``; NaN means that there is none, so sensors of several rates share
            one time line.
        u: known input of the model, any pytree, or None.
    """

    z: Annotated[Array, Channel("unit", "measurements")]
    u: Any = None


@dataclass(frozen=True)
class ExtendedKalman:
    """The extended Kalman filter of x' = f(x, u) + w, z = h(x, u) + v.

    Predicts, then takes the measurements one after another, all linearised at the predicted state
    (the textbook's update, for a diagonal R). What it estimates is its model's to say: it declares
    neither parameters nor states. Source: Jazwinski 1970, ch. 8; Bierman 1977, ch. 5.

    Attributes:
        move: f: parameters, state, input to the next state; a module-level function.
        disturb: covariance of w, ``(n, n)``, at the state before the step.
        measure: h: to the measurements ``(m,)``, at the predicted state.
        diffuse: numbers of the states of which nothing is known at the start, exactly
            (:mod:`filters.diffuse`): their P0 does not matter, their x0 is only where f and h are
            linearised until measurements have determined them, which do not count (variance 0).

    >>> def still(p, x, u):
    ...     return x
    >>> filter = ExtendedKalman(still, lambda p, x, u: p * jnp.eye(1), measure=still)
    >>> model = ExtendedModel(jnp.asarray(1.0), jnp.ones(1), jnp.zeros(1), jnp.zeros((1, 1)))
    >>> state, out = filter.step(model, filter.init(model), ExtendedSample(jnp.ones(1)))
    >>> out.x.tolist()
    [0.5]
    """

    move: Move
    disturb: Move
    measure: Move
    diffuse: tuple[int, ...] = ()

    inputs, outputs = ExtendedSample, LinearOutputs

    def init(self, params: ExtendedModel) -> AnyEstimate:
        """The start: ``x0`` and ``P0``."""
        return begin(params.x0, params.P0, self.diffuse)

    def step(
        self, params: ExtendedModel, state: AnyEstimate, inputs: ExtendedSample
    ) -> tuple[AnyEstimate, LinearOutputs]:
        """Predict to this sample's time and take its measurements."""
        model, u = params.model, inputs.u
        F = jax.jacfwd(self.move, argnums=1)(model, state.x, u)
        ahead = advance(state, F, self.disturb(model, state.x, u))
        estimate = ahead._replace(x=self.move(model, state.x, u))
        H = jax.jacfwd(self.measure, argnums=1)(model, estimate.x, u)
        expected = self.measure(model, estimate.x, u)
        return linearised(estimate, H, params.R, inputs.z, expected)


def linearised(
    estimate: AnyKind, H: Array, R: Array, z: Array, expected: Array
) -> tuple[AnyKind, LinearOutputs]:
    """Take measurements z = h(x) + v, linearised where ``expected`` = h(x) was worked out.

    Args:
        estimate: the prediction, at which h was linearised.
        H: Jacobian of h, ``(m, n)``.
        R: variances of v, ``(m,)``.
        z: measurements, ``(m,)``; NaN means missing.
        expected: h at the prediction, ``(m,)``.
    """
    # As if linear: z' = H x + v with z' = z - h(x-) + H x-.
    linear = z - expected + (H * estimate.x).sum(axis=1)
    parts = []
    for i in range(H.shape[0]):
        estimate, innovation = take(estimate, H[i], R[i], linear[i])
        parts.append(innovation)
    value, variance, gain = (jnp.stack(part) for part in zip(*parts, strict=True))
    return estimate, LinearOutputs(estimate.x, estimate.P, value, variance, gain)
