"""Errors of an attitude: total, heading and inclination; and their root mean squares.

Source: Laidig, Caruso, Cereatti and Seel, Data 6(7):72, 2021 (the three angles).
"""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.rotation import conjugate, multiply
from objectives.kinds import Kind
from objectives.squares import Squares, root

Part = Literal["total", "heading", "inclination"]


class AttitudeError(NamedTuple):
    """Angles between an estimated and a true attitude, rad, not negative.

    Attributes:
        total: of the rotation from one to the other.
        heading: of its part about the vertical.
        inclination: of the rest: the angle between the two verticals.
    """

    total: Array
    heading: Array
    inclination: Array


def attitude_error(estimate: Array, truth: Array) -> AttitudeError:
    """The error of one quaternion (sensor to earth, earth z up) ``(4,)``; NaN where one has NaN.

    With e = estimate truth* the angles are 2 acos abs(w), 2 atan abs(z / w) and
    2 acos sqrt(w^2 + z^2), worked out by arc tangents, which keep their digits near zero.

    >>> one = jnp.array([1.0, 0.0, 0.0, 0.0])
    >>> [float(part) for part in attitude_error(one, one)]
    [0.0, 0.0, 0.0]
    """
    e = multiply(estimate, conjugate(truth))
    w, z = jnp.abs(e[0]), jnp.abs(e[3])
    tilt, upright = root(e[1] ** 2 + e[2] ** 2), root(w**2 + z**2)
    return AttitudeError(
        total=2 * jnp.arctan2(root(tilt**2 + z**2), w),
        heading=2 * jnp.arctan2(z, w),
        inclination=2 * jnp.arctan2(tilt, upright),
    )


@dataclass(frozen=True)
class AttitudeRmse:
    """Root mean square error of an attitude, deg.

    It is the outputs' field ``att``, or the outputs themselves. Quaternions are ``(N, 4)``, sensor
    to earth, or have the records in between ``(N, k, 4)``, which then count as one long record;
    :class:`Records` takes the mean of the single records instead. The truth has their shape;
    samples where it is NaN do not count, which is how rest phases are left out (:func:`masked`). It
    sums in the time loop, and keeps nothing.

    Attributes:
        part: which error.

    Raises:
        ValueError: for outputs that are a tuple without ``att``.
    """

    part: Part = "inclination"

    kind: ClassVar[Kind] = "root mean square"

    def init(self) -> Squares:
        """The empty sum."""
        return Squares.none()

    def added(self, output: Any, truth: Array) -> tuple[Array, Array]:
        """The square of each error, rad^2, 0 where it does not count, and whether it counts."""
        shape = truth.shape[:-1]
        estimate, truth = _attitude(output).reshape(-1, 4), truth.reshape(-1, 4)
        seen = ~jnp.isnan(truth).any(axis=1)
        # Samples without truth get a dummy one, so that no NaN enters the derivative.
        filled = jnp.where(seen[:, None], truth, jnp.array([1.0, 0.0, 0.0, 0.0]))
        error = getattr(jax.vmap(attitude_error)(estimate, filled), self.part)
        return jnp.where(seen, error**2, 0.0).reshape(shape), seen.reshape(shape)

    def update(self, total: Squares, output: Any, truth: Array) -> tuple[Squares, None]:
        """Add one sample."""
        return total.plus(*self.added(output, truth)), None

    def value(self, total: Squares, kept: None) -> Array:
        """The root mean square, ``()``; NaN where nothing counts."""
        return jnp.degrees(total.root_mean())

    def __call__(self, outputs: Any, truth: Array) -> Array:
        """The same of stacked outputs."""
        return self.value(self.update(self.init(), outputs, truth)[0], None)


def _attitude(outputs: Any) -> Array:
    """The quaternions in a filter's outputs."""
    found = getattr(outputs, "att", outputs)
    if not hasattr(found, "shape"):
        raise ValueError(
            f"{type(outputs).__name__} has no att, the attitude as a quaternion; score a filter "
            "whose outputs have one"
        )
    quaternions: Array = found
    return quaternions


def masked(truth: Array, counts: Array) -> Array:
    """A truth ``(N, ...)`` that only counts where ``counts`` ``(N,)`` is true: NaN elsewhere.

    >>> masked(jnp.ones((2, 2)), jnp.array([True, False])).tolist()
    [[1.0, 1.0], [nan, nan]]
    """
    shape = counts.shape + (1,) * (truth.ndim - 1)
    return jnp.where(counts.reshape(shape), truth, jnp.nan)


class AngleErrors(NamedTuple):
    """Errors of single angles over a record, (12).

    Attributes:
        S: mean square, deg^2, ``(k,)``; the paper calls it the average absolute error.
        M: largest absolute error, deg, ``(k,)``.
    """

    S: Array
    M: Array


def angle_errors(estimates: Array, truth: Array) -> AngleErrors:
    """S and M of k angles ``(N, k)`` in rad; samples with a truth of NaN do not count.

    Source: Suh, Park, Kang and Ro, 2004, (12).

    >>> angle_errors(jnp.radians(jnp.array([[1.0], [3.0]])), jnp.zeros((2, 1))).S.round(9).tolist()
    [5.0]
    """
    error = jnp.degrees(estimates - truth)
    seen = ~jnp.isnan(error)
    kept = jnp.where(seen, error, 0.0)
    return AngleErrors((kept**2).sum(axis=0) / seen.sum(axis=0), jnp.abs(kept).max(axis=0))
