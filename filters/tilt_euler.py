"""Roll and pitch from gyroscopes and accelerometers under external acceleration, by Euler angles.

The three filters of Suh, Park, Kang and Ro, 2004, as printed and as corrected. The state is
[theta, phi, wx, wy, wz], pitch, roll and rates about forward, right and down axes; samples are of a
sensor with axes forward, left and up: at rest, ax = g sin theta and ay = g sin phi cos theta.
The pitch stays within 90 deg; for any attitude see :mod:`filters.attitude`.
"""

from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.declared import Channel, Param, components
from filters.extended import linearised
from filters.imu import DISTURBANCE, GRAVITY, XYZ
from filters.kalman import Estimate, Innovation, predict, update
from filters.validate import check_setup

Law = Literal["standard", "simple", "two-step"]


TILT = ("pitch", "roll")
TO_PAPER = (1.0, -1.0, -1.0)
"""From rates about forward, left and up axes to rates about forward, right and down axes."""


class TiltNoise(NamedTuple):
    """Parameters of the tilt filters.

    As far as the angles' error shows, q1, r_nom, r3, alpha2, r_big and P0 share a scale that is
    free; the likelihood of the innovations determines it.
    """

    q1: Annotated[
        Array,
        Param(
            "rad^2/s^3",
            "density of the angular acceleration",
            typical=1.0,
            low=1e-6,
            high=1e4,
            smaller="rates and angles are smoother and lag",
            larger="rates and angles follow the sensors",
        ),
    ]
    r_nom: Annotated[
        Array,
        Param(
            "",
            "variance of the accelerometers over g^2 without disturbance; one, or one an axis",
            typical=1e-2,
            low=1e-7,
            high=1e3,
            smaller="angles follow the accelerometers faster",
            larger="gyroscopes are trusted longer",
        ),
    ]
    r3: Annotated[
        Array,
        Param(
            "rad^2/s^2",
            "variance of the gyroscopes",
            typical=1e-4,
            low=1e-10,
            high=1e2,
            smaller="gyroscopes are trusted more",
            larger="angles follow the accelerometers faster",
        ),
    ]
    alpha1: Annotated[
        Array,
        Param(
            "",
            "how much of r stays from sample to sample",
            typical=0.4,
            low=0.0,
            high=1.0,
            smaller="a disturbance is forgotten sooner",
            larger="a disturbance is distrusted longer",
            per_sample=True,
        ),
    ]
    alpha2: Annotated[
        Array,
        Param(
            "",
            "how much a residual of 1 g adds to r",
            typical=2.0,
            low=1e-4,
            high=1e6,
            smaller="disturbances come through",
            larger="disturbed axes are left to the gyroscopes",
        ),
    ]
    delta: Annotated[Array, DISTURBANCE]
    r_big: Annotated[
        Array,
        Param("", "variance over g^2 of disturbed accelerometers, of the simple law", typical=1.0),
    ]
    gravity: Annotated[Array, GRAVITY]
    x0: Annotated[
        Array,
        Param("rad, rad/s", "pitch, roll and rates at the start", typical=0.0, shape=(5,)),
    ]
    P0: Annotated[
        Array, Param("rad^2, rad^2/s^2", "variance of each of them at the start", typical=0.1)
    ]


class TiltSample(NamedTuple):
    """One sample, axes forward, left, up; stacked along time for :func:`filters.run`.

    NaN is missing; no disturbance is detected where an acceleration is missing.
    """

    acc: Annotated[
        Array, Channel("m/s^2", "specific force, forward, left, up: +g along z at rest", XYZ)
    ]
    gyr: Annotated[Array, Channel("rad/s", "angular rate about the same axes", XYZ)]


class TiltState(NamedTuple):
    """State of the filter: its estimate, and the accelerometers' variances r ``(2,)``."""

    estimate: Estimate
    r: Array


_TAKEN = (*(f"gyr_{axis}" for axis in XYZ), "acc_x", "acc_y")


class TiltOutputs(NamedTuple):
    """The outputs of the filter after a sample."""

    angles: Annotated[Array, Channel("rad", "nose up, and right side down", TILT, "angle")]
    rates: Annotated[Array, Channel("rad/s", "rates about forward, right, down axes", XYZ)]
    r: Annotated[
        Array, Channel("", "variances of the accelerometers over g^2, as taken", XYZ[:2], "detail")
    ]
    detected: Annotated[Array, Channel("", "whether a disturbance was detected", (), "detail")]
    innovation: Annotated[
        Array,
        Channel("", "rates, then accelerations over g, less what is predicted", _TAKEN, "detail"),
    ]
    variance: Annotated[Array, Channel("", "predicted variances of these", _TAKEN, "detail")]


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

    params, inputs, outputs = TiltNoise, TiltSample, TiltOutputs
    states = {
        "pitch": Channel("rad", "nose up", kind="angle"),
        "roll": Channel("rad", "right side down", kind="angle"),
    } | components("rate", "rad/s", "rate about forward, right, down axes", XYZ)

    def __post_init__(self) -> None:
        check_setup(self)

    def init(self, params: TiltNoise) -> TiltState:
        """The start; r begins at r_nom."""
        P0 = params.P0 * jnp.eye(5, dtype=params.x0.dtype)
        return TiltState(Estimate(params.x0, P0), jnp.broadcast_to(params.r_nom, (2,)))

    def step(
        self, params: TiltNoise, state: TiltState, inputs: TiltSample
    ) -> tuple[TiltState, TiltOutputs]:
        """Predict, detect, and take the measurements."""
        ahead = _ahead(state.estimate, params.q1, self.dt)
        C = _slopes(ahead.x, full=self.jacobian == "full")
        missing = jnp.isnan(inputs.acc)
        # Masked before it is divided: a NaN would reach the derivative by gravity.
        a = jnp.where(missing, jnp.nan, jnp.where(missing, 0.0, inputs.acc) / params.gravity)
        detected = jnp.abs(a @ a - 1) > params.delta
        after, turned = _gyroscopes(ahead, inputs.gyr, params.r3)
        # One joint update, as the standard filter has it, takes f at the prediction.
        again = self.law == "two-step" and self.innovation == "nonlinear"
        at = after.x if again else ahead.x
        expected = self._expected(C, at)
        if not again:
            expected = expected + (C * (after.x - at)).sum(axis=1)
        r = self._variances(params, state.r, a[:2] - expected, detected)
        estimate, leaned = linearised(after, C, r, a[:2], expected)
        innovation = jnp.stack([*(one.value for one in turned), *leaned.innovation])
        variance = jnp.stack([*(one.variance for one in turned), *leaned.variance])
        outputs = TiltOutputs(estimate.x[:2], estimate.x[2:], r, detected, innovation, variance)
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
        grown = params.alpha1 * r + params.alpha2 * size
        # Not jnp.maximum, which compares twice: the derivative of a tie is half of each.
        grown = jnp.where(grown < nominal, nominal, grown)
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
    # W W', as sin^2 + cos^2 = 1.
    WW = jnp.diag(jnp.stack([jnp.ones_like(x[0]), 1 + jnp.tan(x[0]) ** 2]))
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


def _gyroscopes(estimate: Estimate, rate: Array, r3: Array) -> tuple[Estimate, list[Innovation]]:
    """(8), one axis after another."""
    taken = []
    for i, sign in enumerate(TO_PAPER):
        axis = jnp.eye(5, dtype=r3.dtype)[2 + i]
        estimate, one = update(estimate, axis, r3, sign * rate[i])
        taken.append(one)
    return estimate, taken
