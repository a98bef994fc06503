"""Roll and pitch from gyroscopes and accelerometers under external acceleration, by Euler angles.

The three filters of Suh, Park, Kang and Ro, 2004, as printed and as corrected. The state is
[theta, phi, wx, wy, wz], pitch, roll and rates; accelerations are in g with the paper's polarity:
ax = sin theta and ay = sin phi cos theta at rest, beside rates about forward, right and down axes.
The pitch stays within 90 deg; for any attitude see :mod:`filters.attitude`.
"""

from dataclasses import dataclass
from typing import Literal, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.extended import linearised
from filters.kalman import Estimate, predict, update
from filters.validate import check_setup

Law = Literal["standard", "simple", "two-step"]


class TiltNoise(NamedTuple):
    """What the tilt filters take; the scale that q1, r_nom, r3, alpha2 and r_big share is free.

    Attributes:
        q1: spectral density of the angular acceleration, rad^2/s^3, times that scale.
        r_nom: variance of the accelerometers without disturbance, g^2, ``(2,)`` or ``()``.
        r3: variance of the gyroscopes, (rad/s)^2.
        alpha1: how much of r stays from sample to sample, 0 to 1.
        alpha2: how much a residual of 1 g adds to r, g.
        delta: by how much abs(a)^2 may differ from 1 g^2 before a disturbance is detected.
        r_big: variance of disturbed accelerometers in the simple adaptive filter, g^2.
        x0: the start, ``(5,)``.
        P0: its covariance, ``(5, 5)``.
    """

    q1: Array
    r_nom: Array
    r3: Array
    alpha1: Array
    alpha2: Array
    delta: Array
    r_big: Array
    x0: Array
    P0: Array


class TiltSample(NamedTuple):
    """One sample's inputs; stacked along time for :func:`filters.run`.

    Attributes:
        acceleration: (ax, ay, az) in g, ``(3,)``; NaN means missing: nothing is detected then.
        rate: (gx, gy, gz), rad/s, ``(3,)``; NaN means missing.
    """

    acceleration: Array
    rate: Array


class TiltState(NamedTuple):
    """What the filter carries: its estimate, and the accelerometers' variances r ``(2,)``."""

    estimate: Estimate
    r: Array


class TiltOutputs(NamedTuple):
    """What the filter knows after a sample.

    Attributes:
        angles: (theta, phi), rad, ``(2,)``.
        rates: rad/s, ``(3,)``.
        r: variances that the accelerometers were taken with, g^2, ``(2,)``.
        detected: whether a disturbance was, ``()`` of bool.
    """

    angles: Array
    rates: Array
    r: Array
    detected: Array


@dataclass(frozen=True)
class TiltKalman:
    """The standard, the simple adaptive and the two-step filter (Suh et al. 2004, (5) to (11)).

    All three detect a disturbance by (7). The standard filter ignores it; the simple one takes
    r_big for r; the two-step filter takes the gyroscopes first, and r grows along the axes on which
    the accelerometers contradict them.

    Attributes:
        dt: sample time, s.
        law: which filter.
        jacobian: full, or printed: (5) leaves -sin phi sin theta out.
        innovation: nonlinear z - f(x); linearised: the same, with f linearised at the prediction
            throughout, so that at a constant r the two-step filter is the standard one; or linear
            z - C x as printed, which is biased by 1 deg at 20 deg and has no rest above 34 deg.
        residual: absolute, or signed as printed in (9), which trusts disturbances of one sign.
        fading: printed: (10), whose rest is r_nom / (1 - alpha1), or convex: with
            (1 - alpha1) r_nom, whose rest is r_nom.
    """

    dt: float
    law: Law = "two-step"
    jacobian: Literal["full", "printed"] = "full"
    innovation: Literal["nonlinear", "linearised", "linear"] = "nonlinear"
    residual: Literal["absolute", "signed"] = "absolute"
    fading: Literal["printed", "convex"] = "printed"

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: TiltNoise) -> TiltState:
        """The start; r begins at r_nom."""
        return TiltState(Estimate(params.x0, params.P0), jnp.broadcast_to(params.r_nom, (2,)))

    def step(
        self, params: TiltNoise, state: TiltState, inputs: TiltSample
    ) -> tuple[TiltState, TiltOutputs]:
        """Predict, detect, and take the measurements."""
        ahead = _ahead(state.estimate, params.q1, self.dt)
        C = _slopes(ahead.x, full=self.jacobian == "full")
        a = inputs.acceleration
        detected = jnp.abs(a @ a - 1) > params.delta
        after = _gyroscopes(ahead, inputs.rate, params.r3)
        # One joint update, as the standard filter has it, takes f at the prediction.
        again = self.law == "two-step" and self.innovation == "nonlinear"
        at = after.x if again else ahead.x
        expected = self._expected(C, at) + (C * (after.x - at)).sum(axis=1)
        r = self._variances(params, state.r, a[:2] - expected, detected)
        estimate, _ = linearised(after, C, r, a[:2], expected)
        outputs = TiltOutputs(estimate.x[:2], estimate.x[2:], r, detected)
        return TiltState(estimate, r), outputs

    def _expected(self, C: Array, x: Array) -> Array:
        if self.innovation == "linear":
            return (C * x).sum(axis=1)
        return jnp.stack([jnp.sin(x[0]), jnp.sin(x[1]) * jnp.cos(x[0])])

    def _variances(self, params: TiltNoise, r: Array, e: Array, detected: Array) -> Array:
        """Nominal, or large where detected, or (9) and (10)."""
        nominal = jnp.broadcast_to(params.r_nom, (2,))
        if self.law == "standard":
            return nominal
        if self.law == "simple":
            return jnp.where(detected, params.r_big, nominal)
        size = jnp.abs(e) if self.residual == "absolute" else e
        size = jnp.where(jnp.isnan(size), 0.0, size)
        grown = jnp.maximum(params.alpha1 * r + params.alpha2 * size, params.r_nom)
        share = 1.0 if self.fading == "printed" else 1 - params.alpha1
        return jnp.where(detected, grown, params.alpha1 * r + share * params.r_nom)


def tilt_transition(x: Array, dt: float) -> Array:
    """Phi of (4), ``(5, 5)``: exact for rates that do not turn the axes meanwhile.

    Args:
        x: pitch, roll, rad, and rates, rad/s, ``(5,)``.
        dt: s.

    >>> (tilt_transition(jnp.zeros(5), 0.5) @ jnp.array([0.0, 0.0, 0.2, 0.4, 0.0])).tolist()
    [0.2, 0.1, 0.2, 0.4, 0.0]
    """
    W = _kinematics(x)
    upper = jnp.concatenate([jnp.eye(2, dtype=x.dtype), W * dt], axis=1)
    lower = jnp.concatenate([jnp.zeros((3, 2), x.dtype), jnp.eye(3, dtype=x.dtype)], axis=1)
    return jnp.concatenate([upper, lower])


def tilt_disturbance(x: Array, q1: Array, dt: float) -> Array:
    """Q_k after (4), ``(5, 5)``, of angular accelerations with the density q1."""
    W = _kinematics(x)
    WW = (W[:, None, :] * W[None, :, :]).sum(axis=2)
    upper = jnp.concatenate([dt**3 / 3 * WW, dt**2 / 2 * W], axis=1)
    lower = jnp.concatenate([dt**2 / 2 * W.T, dt * jnp.eye(3, dtype=x.dtype)], axis=1)
    return q1 * jnp.concatenate([upper, lower])


def _ahead(estimate: Estimate, q1: Array, dt: float) -> Estimate:
    F = tilt_transition(estimate.x, dt)
    return predict(estimate, F, tilt_disturbance(estimate.x, q1, dt))


def _kinematics(x: Array) -> Array:
    """W of (4), ``(2, 3)``: from body rates to the rates of (theta, phi)."""
    sine, cosine, slope = jnp.sin(x[1]), jnp.cos(x[1]), jnp.tan(x[0])
    zero, one = jnp.zeros((), x.dtype), jnp.ones((), x.dtype)
    return jnp.stack([zero, cosine, -sine, one, sine * slope, cosine * slope]).reshape(2, 3)


def _slopes(x: Array, *, full: bool) -> Array:
    """C1 of (5), ``(2, 5)``."""
    mixed = -jnp.sin(x[1]) * jnp.sin(x[0]) if full else jnp.zeros((), x.dtype)
    zero = jnp.zeros((), x.dtype)
    rows = [jnp.cos(x[0]), zero, mixed, jnp.cos(x[1]) * jnp.cos(x[0])]
    return jnp.concatenate([jnp.stack(rows).reshape(2, 2), jnp.zeros((2, 3), x.dtype)], axis=1)


def _gyroscopes(estimate: Estimate, rate: Array, r3: Array) -> Estimate:
    """(8), one axis after another."""
    for i in range(3):
        estimate, _ = update(estimate, jnp.eye(5, dtype=r3.dtype)[2 + i], r3, rate[i])
    return estimate
