"""The vertical channel of an inertial navigation system that is aligned at rest.

Source: Ha, Kim and Choi, Kalman Filter Method and the Conventional Method for the Bias Error
Reduction of INS Vertical Channel, 1981; equation numbers are theirs. The state is
(A_B, dV, dh): the bias of the vertical acceleration, velocity error, altitude error. Left alone,
the channel diverges (by a factor e in 571 s), so errors are propagated, never the channel itself.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
from jax import Array
from jax.typing import ArrayLike

from filters.declared import Channel
from filters.exponential import expm
from filters.small_linalg import matmul

GRAVITY_GRADIENT = 3.07e-6
"""Kgh in 1/s^2: the fall of gravity with altitude, which makes the channel diverge."""


def vertical_channel(k_gh: ArrayLike = GRAVITY_GRADIENT) -> Array:
    """Dynamics of model (11), ``(3, 3)``, 1/s: A_B' = 0, dV' = A_B + Kgh dh + W_a, dh' = dV.

    The noise W_a enters the second state, and the third, dh, is measured.

    >>> vertical_channel()[1].tolist()
    [1.0, 0.0, 3.07e-06]
    """
    k = jnp.asarray(k_gh, dtype=float)
    return jnp.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]).at[1, 2].set(k)


class LoopGains(NamedTuple):
    """Gains of the conventional scheme.

    Attributes:
        K1: on the altitude, 1/s.
        K2: on the velocity, 1/s^2; the paper's K2, which compensates Kgh: K2' = K2 - Kgh.
        K3: on the estimated bias, 1/s^3.
    """

    K1: ArrayLike
    K2: ArrayLike
    K3: ArrayLike


def loop_error(gains: LoopGains, k_gh: ArrayLike = GRAVITY_GRADIENT) -> Array:
    """The conventional scheme in error coordinates, ``(4, 4)``, 1/s; W_a enters the third.

    The state is (epsilon, e, dV, dh_r): error of the estimated bias, what the loop feeds back,
    velocity error, and the constant error of the altitude it is given. With K2' = K2 - Kgh
    (8): epsilon' = K3 e, e' = dV - K1 e, dV' = -epsilon - K2' e + Kgh dh_r + W_a. The matrix
    printed in (4) never feeds the estimated bias back; this is Fig. 2.
    """
    K1, K2, K3, k = (jnp.asarray(g, dtype=float) for g in (*gains, k_gh))
    zero, one = jnp.zeros(()), jnp.ones(())
    rows = (
        (zero, K3, zero, zero),
        (zero, -K1, one, zero),
        (-one, k - K2, zero, k),
        (zero, zero, zero, zero),
    )
    return jnp.stack([jnp.stack(row) for row in rows])


class LoopStep(NamedTuple):
    """The conventional scheme over one sample, x' = F x + B (z - h) with h the altitude in x.

    Attributes:
        F: the channel's transition, ``(3, 3)``.
        B: effect of a difference that is held for the sample, through the gains, ``(3,)``.
    """

    F: Array
    B: Array


def loop_step(gains: LoopGains, dt: float, k_gh: ArrayLike = GRAVITY_GRADIENT) -> LoopStep:
    """The scheme with the fed-back altitude difference sampled and held for dt seconds.

    It is stable only where dt is short against the loop's time constants. (Holding z itself would
    be wrong by K3 V dt^2 / 12 where V is the uncorrected velocity error, which grows for ever.)
    """
    K1, K2, K3 = (jnp.asarray(gain, dtype=float) for gain in gains)
    L = jnp.stack([K3, K2, K1])
    held = jnp.zeros((4, 4)).at[:3, :3].set(vertical_channel(k_gh)).at[:3, 3].set(L)
    over = expm(held * dt)
    return LoopStep(over[:3, :3], over[:3, 3])


@dataclass(frozen=True)
class ConventionalLoop:
    """The conventional scheme as it runs: three numbers, three gains, no covariance.

    Inputs are altitude differences z (inertial, uncorrected, minus given), ``()``; the output is
    (A_B, dV, dh) as predicted for the next sample. Its parameters are what :func:`loop_step` makes
    of the gains, so it declares none. In error coordinates, and with dt -> 0, it is
    :func:`loop_error`, where e = z - dh and dV is the error of the corrected velocity.
    """

    inputs = {"z": Channel("m", "inertial less given altitude")}  # noqa: RUF012
    outputs = {  # noqa: RUF012
        "x": Channel("", "bias, velocity error and altitude error", ("A_B", "dV", "dh"))
    }
    states = {  # noqa: RUF012
        "A_B": Channel("m/s^2", "bias of the vertical acceleration"),
        "dV": Channel("m/s", "velocity error"),
        "dh": Channel("m", "altitude error"),
    }

    def init(self, params: LoopStep) -> Array:
        """At zero."""
        return jnp.zeros_like(params.B)

    def step(self, params: LoopStep, state: Array, inputs: Array) -> tuple[Array, Array]:
        """Take one sample and move on; after a missing one (NaN) the channel is predicted."""
        y = jnp.where(jnp.isnan(inputs), 0.0, inputs - state[2])
        state = matmul(params.F, state) + params.B * y
        return state, state
