"""Level flight and then a bank turn, known exactly, in three variants.

The paper says how long it flies and how far it turns, but not how it banks, how fast it is, or at
which angle of attack: T1 is a coordinated turn with an angle of attack, T0 one without, T2 slips.
Body axes are forward, right, down; ft, s, rad.
"""

from functools import partial
from typing import Literal, NamedTuple, get_args

import jax
import jax.numpy as jnp
from jax import Array

from filters.small_linalg import product

Trajectory = Literal["T0", "T1", "T2"]
TRAJECTORIES: tuple[Trajectory, ...] = get_args(Trajectory)


class Course(NamedTuple):
    """A trajectory to be flown.

    Attributes:
        speed: ft/s.
        bank: largest bank angle mu_max, rad.
        tilt: angle of attack of T1 in level flight, largest pitch and slip of T2, rad.
        level: duration of straight flight, s.
        turn: duration of the turn, s.
        ramp: time to bank, and to come back, s; raised cosines.
        gravity: ft/s^2.
    """

    speed: float
    bank: float
    tilt: float
    level: float
    turn: float
    ramp: float
    gravity: float


class Motion(NamedTuple):
    """The truth at n times.

    Attributes:
        angles: (roll, pitch), rad, ``(n, 2)``.
        rate: (p, q, r), rad/s, ``(n, 3)``.
        force: specific force, ft/s^2, ``(n, 3)``.
        velocity: (u, v, w), ft/s, ``(n, 3)``.
    """

    angles: Array
    rate: Array
    force: Array
    velocity: Array


def motion(trajectory: Trajectory, course: Course, t: Array) -> Motion:
    """The truth of a flight at times t ``(n,)``, s."""
    found: Motion = _motion(trajectory == "T2", _flown(trajectory, course), t)
    return found


def rate_and_slope(trajectory: Trajectory, course: Course, t: Array) -> tuple[Array, Array]:
    """(p, q, r) and their derivatives, ``(n, 3)`` each."""
    found: tuple[Array, Array] = _slope(trajectory == "T2", _flown(trajectory, course), t)
    return found


def _flown(trajectory: Trajectory, course: Course) -> Course:
    """T0 is T1 without an angle of attack."""
    return course._replace(tilt=0.0) if trajectory == "T0" else course


# A flight is worked out once, and compiling it with optimisation takes longest of all.
_QUICK = {"xla_backend_optimization_level": 0}


@partial(jax.jit, static_argnums=0, compiler_options=_QUICK)
def _motion(slips: bool, course: Course, t: Array) -> Motion:
    found: Motion = jax.vmap(partial(_at, slips, course))(t)
    return found


@partial(jax.jit, static_argnums=0, compiler_options=_QUICK)
def _slope(slips: bool, course: Course, t: Array) -> tuple[Array, Array]:
    def rate(t: Array) -> Array:
        return _at(slips, course, t).rate

    return jax.vmap(lambda t: jax.jvp(rate, (t,), (jnp.ones_like(t),)))(t)


def bank_angle(course: Course, t: Array) -> Array:
    """The bank angle mu, rad."""
    s = t - course.level
    into = jnp.clip(jnp.where(s < course.turn / 2, s, course.turn - s), 0.0, course.ramp)
    return course.bank / 2 * (1 - jnp.cos(jnp.pi * into / course.ramp))


def _at(slips: bool, course: Course, t: Array) -> Motion:
    """Everything from the attitude's law: C turns axes along and across the velocity, and down.

    Those axes turn with the heading's rate g tan mu / V, and the velocity's change is along the
    second one.
    """
    law = partial(_attitude, slips, course)
    C, slope = jax.jvp(law, (t,), (jnp.ones_like(t),))
    S = product(slope, C.T)  # -(omega x)
    turning = course.gravity * jnp.tan(bank_angle(course, t)) / course.speed
    rate = jnp.stack([S[1, 2], S[2, 0], S[0, 1]]) + C[:, 2] * turning
    force = C[:, 1] * course.speed * turning - C[:, 2] * course.gravity
    angles = jnp.stack([jnp.arctan2(C[1, 2], C[2, 2]), -jnp.arcsin(C[0, 2])])
    return Motion(angles, rate, force, C[:, 0] * course.speed)


def _attitude(slips: bool, course: Course, t: Array) -> Array:
    """C, ``(3, 3)``."""
    mu = bank_angle(course, t)
    if slips:
        slip = course.tilt * mu / course.bank
        return product(_about(0, mu), _about(1, slip), _about(2, -slip))
    alpha = course.tilt / jnp.cos(mu)
    return product(_about(1, alpha), _about(0, mu))


def _about(axis: int, angle: Array) -> Array:
    """The rotation of coordinates about one axis, ``(3, 3)``."""
    sine, cosine = jnp.sin(angle), jnp.cos(angle)
    one, zero = jnp.ones_like(angle), jnp.zeros_like(angle)
    block = ((one, zero, zero), (zero, cosine, sine), (zero, -sine, cosine))
    return jnp.stack(
        [block[(i - axis) % 3][(j - axis) % 3] for i in range(3) for j in range(3)]
    ).reshape(3, 3)
