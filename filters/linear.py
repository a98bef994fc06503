"""Linear filters for any model: Kalman's, with missing samples and varying times; stored gains."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters.declared import Channel
from filters.diffuse import AnyEstimate, advance, begin, take_rows
from filters.kalman import decorrelate
from filters.small_linalg import matmul


class Transition(NamedTuple):
    """One step of a discrete model, x' = F x + B u + G w with cov w = Q per sample.

    Attributes:
        F: transition, ``(n, n)``.
        G: where the noise enters, ``(n, p)``.
        Q: covariance of the noise in one sample, ``(p, p)``.
        B: where a known input enters, ``(n, q)``; None where there is none.
    """

    F: Array
    G: Array
    Q: Array
    B: Array | None = None


class LinearModel(NamedTuple):
    """A linear model: how it moves, how it is measured and where it starts.

    Attributes:
        transition: :class:`Transition`; a sample may bring its own.
        H: measurement matrix, ``(m, n)``.
        R: measurement covariance: its diagonal ``(m,)`` or the full matrix ``(m, m)``.
        P0: covariance of the start, ``(n, n)``; rank-deficient and zero are allowed.
        x0: the start, ``(n,)``; ``(n, s)`` where s signals pass through the same gains.
    """

    transition: Transition
    H: Array
    R: Array
    P0: Array
    x0: Array


class Sample(NamedTuple):
    """One sample's inputs; stacked along time for :func:`filters.run`.

    Attributes:
        z: measurements, ``(m,)`` or ``(m, s)``; NaN means missing.
        u: known input, ``(q,)``, or None.
        transition: the step that leads to this sample where it differs from the model's
            (see :func:`filters.transitions` for varying sample times), or None.
    """

    z: Annotated[Array, Channel("unit", "measurements")]
    u: Annotated[Array | None, Channel("", "known input")] = None
    transition: Transition | None = None


class LinearForm(NamedTuple):
    """The linear model whose Kalman filter a filter is: what its method ``linear`` returns.

    Attributes:
        transition: :class:`Transition` of one step of the filter's ``dt``.
        H: measurement matrix, ``(m, n)``.
        R: measurement covariance, its diagonal ``(m,)`` or the full matrix ``(m, m)``.
    """

    transition: Transition
    H: Array
    R: Array


class Measured(NamedTuple):
    """A whole record as a linear model takes it: what a filter's method ``measured`` returns.

    Attributes:
        z: measurements, ``(N, m)``; NaN means missing.
        u: known input of the step that leads to each sample, ``(N, q)``, or None.
        sigma: deviations of the measurements where ``R`` is a factor on their squares, ``(N, m)``,
            or None; where one is not positive its measurement is missing.
    """

    z: Array | np.ndarray
    u: Array | np.ndarray | None = None
    sigma: Array | np.ndarray | None = None


class LinearOutputs(NamedTuple):
    """The outputs of the filter after a sample.

    Attributes:
        x: state estimate, ``(n,)`` or ``(n, s)``.
        P: its covariance, ``(n, n)``.
        innovation: one per measurement, decorrelated where R is full, ``(m,)`` or ``(m, s)``; 0
            where it is missing.
        variance: the innovations' predicted variances, ``(m,)``; 0 where one is missing.
        gain: the gains of the scalar updates, ``(m, n)``.
    """

    x: Annotated[Array, Channel("", "state estimate")]
    P: Annotated[Array, Channel("", "its covariance", (), "detail")]
    innovation: Annotated[
        Array, Channel("unit", "measurements less what is predicted", (), "detail")
    ]
    variance: Annotated[Array, Channel("unit^2", "predicted variances of these", (), "detail")]
    gain: Annotated[Array, Channel("", "gains of the scalar updates", (), "detail")]


@dataclass(frozen=True)
class LinearKalman:
    """The Kalman filter: predict, then take the m measurements one after another.

    Source: Kalman 1960; sequential updates as in Bierman 1977, ch. 5. A missing
    measurement (NaN) is skipped, so a missing sample is a prediction. Its model says what it
    estimates: it declares neither parameters nor states.

    Attributes:
        diffuse: numbers of the states of which nothing is known at the start, exactly
            (:mod:`filters.diffuse`): their x0 and P0 do not matter, and the measurements that
            determine them do not count (variance 0).
    """

    diffuse: tuple[int, ...] = ()

    inputs, outputs = Sample, LinearOutputs

    def init(self, params: LinearModel) -> AnyEstimate:
        """The start: ``x0`` and ``P0``."""
        return begin(params.x0, params.P0, self.diffuse)

    def step(
        self, params: LinearModel, state: AnyEstimate, inputs: Sample
    ) -> tuple[AnyEstimate, LinearOutputs]:
        """Predict to this sample's time and take its measurements."""
        move = params.transition if inputs.transition is None else inputs.transition
        estimate = advance(state, move.F, matmul(matmul(move.G, move.Q), move.G.T))
        if inputs.u is not None:
            if move.B is None:
                raise ValueError(
                    "the samples bring a known input u, but their transition has no B, the matrix "
                    "(n, q) through which it enters"
                )
            push = matmul(move.B, inputs.u)
            x = estimate.x + push.reshape(push.shape + (1,) * (estimate.x.ndim - 1))
            estimate = estimate._replace(x=x)
        H, variances, z = params.H, params.R, inputs.z
        if params.R.ndim == 2:
            H, variances, z = decorrelate(H, params.R, z)
        estimate, innovation = take_rows(estimate, H, variances, z)
        return estimate, LinearOutputs(estimate.x, estimate.P, *innovation)


class GainedSample(NamedTuple):
    """A measurement with the gain to apply to it.

    Attributes:
        z: measurements, ``(m,)``; NaN means missing.
        K: gain, ``(n, m)``.
    """

    z: Array
    K: Array


@dataclass(frozen=True)
class StoredGains:
    """A linear filter with gains computed beforehand: measure, output, predict.

    The first measurement is taken at once, on x0, as by :class:`filters.KalmanCovariance`, whose
    gains it takes; one gain for all samples makes a fixed-gain filter. A building block, which
    declares nothing. Source: Ha, Kim and Choi 1981, (13); their (18) has the innovation's sign
    wrong.
    """

    def init(self, params: LinearModel) -> Array:
        """The start, x0."""
        return params.x0

    def step(self, params: LinearModel, state: Array, inputs: GainedSample) -> tuple[Array, Array]:
        """Correct, output x(+), and predict to the next sample."""
        y = inputs.z - matmul(params.H, state)
        x = state + matmul(inputs.K, jnp.where(jnp.isnan(y), 0.0, y))
        return matmul(params.transition.F, x), x
