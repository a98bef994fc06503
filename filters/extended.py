"""The extended Kalman filter for any model, with Jacobians by JAX."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, TypeAlias

import jax
from jax import Array

from filters.angles import difference
from filters.declared import Channel
from filters.diffuse import AnyEstimate, AnyKind, advance, begin, take_rows
from filters.kalman import decorrelate
from filters.linear import LinearOutputs

Move: TypeAlias = Callable[[Any, Array, Any], Array]
"""From the model's parameters, a state ``(n,)`` and the sample's known input."""


class ExtendedModel(NamedTuple):
    """The parameters of an extended Kalman filter.

    Attributes:
        model: parameters of the model's functions, any pytree.
        R: variances of the measurements, ``(m,)``, or their covariance, ``(m, m)``.
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
    (the textbook's update, for a diagonal R). With ``iterations`` above 1 it is the iterated
    filter: h is linearised anew at what the update found, and the update done again from the
    prediction, which are Gauss-Newton's steps to the state of greatest density after the
    measurement. The number of steps is fixed, and none is shortened: where they might stray, take
    fewer. Innovations and their variances are those of the first linearisation, what was predicted
    before the measurement was seen; gains are those of the last, as are x and P. What it estimates
    is its model's to say: it declares neither parameters nor states. Source: Jazwinski 1970, ch. 8;
    Bierman 1977, ch. 5; Bell and Cathey, The iterated Kalman filter update as a Gauss-Newton
    method, IEEE Transactions on Automatic Control 38(2), 1993.

    Attributes:
        move: f: parameters, state, input to the next state; a module-level function.
        disturb: covariance of w, ``(n, n)``, at the state before the step.
        measure: h: to the measurements ``(m,)``, at the predicted state.
        diffuse: numbers of the states of which nothing is known at the start, exactly
            (:mod:`filters.diffuse`): their P0 does not matter, their x0 is only where f and h are
            linearised until measurements have determined them, which do not count (variance 0).
        iterations: how often h is linearised, 1 or more.
        angles: which measurements are angles in rad, one word for each; z - h(x) of these is taken
            within half a turn. Empty where none is.

    >>> import jax.numpy as jnp
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
    iterations: int = 1
    angles: tuple[bool, ...] = ()

    inputs, outputs = ExtendedSample, LinearOutputs

    def __post_init__(self) -> None:
        if not isinstance(self.iterations, int) or self.iterations < 1:
            raise ValueError(
                f"ExtendedKalman: iterations is {self.iterations!r}; give how often the "
                "measurement is linearised, 1 or more"
            )

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
        found, taken = self._taken(params, estimate, None, inputs)
        for _ in range(self.iterations - 1):
            found, last = self._taken(params, estimate, found.x, inputs)
            taken = last._replace(innovation=taken.innovation, variance=taken.variance)
        return found, taken

    def _taken(
        self, params: ExtendedModel, ahead: AnyEstimate, at: Array | None, inputs: ExtendedSample
    ) -> tuple[AnyEstimate, LinearOutputs]:
        """The measurements, linearised at a state; None is the prediction."""
        model, u, x = params.model, inputs.u, ahead.x if at is None else at
        H = jax.jacfwd(self.measure, argnums=1)(model, x, u)
        expected, z = self.measure(model, x, u), inputs.z
        if any(self.angles):
            z = expected + difference(z, expected, self.angles)
        if at is not None:
            expected = expected + (H * (ahead.x - at)).sum(axis=1)
        return linearised(ahead, H, params.R, z, expected)


def linearised(
    estimate: AnyKind, H: Array, R: Array, z: Array, expected: Array
) -> tuple[AnyKind, LinearOutputs]:
    """Take measurements z = h(x) + v, linearised where ``expected`` = h(x) was worked out.

    Args:
        estimate: the prediction, at which h was linearised.
        H: Jacobian of h, ``(m, n)``.
        R: variances of v, ``(m,)``, or its covariance, ``(m, m)``.
        z: measurements, ``(m,)``; NaN means missing.
        expected: h at the prediction, ``(m,)``.
    """
    # As if linear: z' = H x + v with z' = z - h(x-) + H x-.
    linear = z - expected + (H * estimate.x).sum(axis=1)
    if R.ndim == 2:
        H, R, linear = decorrelate(H, R, linear)
    estimate, innovation = take_rows(estimate, H, R, linear)
    return estimate, LinearOutputs(estimate.x, estimate.P, *innovation)
