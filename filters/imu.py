"""One sample of an inertial unit, as the attitude filters take it."""

from typing import Annotated, NamedTuple

from jax import Array

from filters.declared import Channel, Param

XYZ = ("x", "y", "z")
WXYZ = ("w", "x", "y", "z")


FORCE = Channel("m/s^2", "specific force, +g along z at rest, z up", XYZ)
TURN = Channel("rad/s", "angular rate", XYZ)


class ImuSample(NamedTuple):
    """One sample of an inertial unit; stacked along time for :func:`filters.run`.

    All three are ``(3,)`` in the sensor's axes, and NaN is missing: a missing rate is no turn.

    >>> import jax.numpy as jnp
    >>> ImuSample(jnp.array([0.0, 0.0, 9.81]), jnp.zeros(3)).mag is None
    True
    """

    acc: Annotated[Array, FORCE]
    gyr: Annotated[Array, TURN]
    mag: Annotated[Array | None, Channel("", "magnetic field, in any unit", XYZ)] = None


class SixAxes(NamedTuple):
    """One sample of an inertial unit without a magnetometer, for filters that take none."""

    acc: Annotated[Array, FORCE]
    gyr: Annotated[Array, TURN]


ATTITUDE = Channel("", "attitude, sensor to earth, earth z up", WXYZ, "attitude")
"""The attitude that a filter estimates, ``(4,)``."""
LEVEL = Param(
    "", "attitude at the start, sensor to earth; zeros: level by the first sample", 0.0, shape=(4,)
)
"""The attitude at which a filter begins."""
GRAVITY = Param("m/s^2", "gravity, in the accelerometers' unit", 9.81)
"""The specific force that accelerometers measure at rest."""
DISTURBANCE = Param(
    "",
    "a disturbance is detected where abs(a)^2 / g^2 differs more from 1; a threshold",
    typical=0.05,
    smaller="noise counts as a disturbance",
    larger="disturbances pass unseen",
)
"""The threshold above which accelerometers show more than gravity."""
