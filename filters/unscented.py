"""The unscented Kalman filter for any model: sigma points in place of Jacobians."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, sqrt
from typing import NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters.angles import difference
from filters.extended import ExtendedModel, ExtendedSample, Move
from filters.kalman import Estimate, Innovation, decorrelate, update
from filters.linear import LinearOutputs
from filters.small_linalg import matmul, semidefinite_root


@dataclass(frozen=True)
class UnscentedKalman:
    """The unscented Kalman filter of x' = f(x, u) + w, z = h(x, u) + v.

    Takes what :class:`filters.ExtendedKalman` takes, and needs no derivative of f and h. Of n
    states there are 2 n + 1 sigma points, x and x +- sqrt(c) s_i, where c = alpha^2 (n + kappa) and
    s_i are the columns of the covariance's lower Cholesky factor. Mean and covariance ahead are
    those of f at the points, and Q; then points are drawn anew from these, and the measurements of
    a sample are taken together, by mean and covariances of h at the points. In a mean the point x
    has the weight 1 - n/c and each other 1/(2 c); in a covariance x has 1 - alpha^2 + beta more.

    Conventions differ. Wan and van der Merwe 2000 have alpha = 1e-3, beta = 2, kappa = 0; Julier
    and Uhlmann 1997 alpha = 1, beta = 0, kappa = 3 - n; cubature (Arasaratnam and Haykin 2009)
    alpha = 1, beta = kappa = 0. lambda is c - n, which Julier 2002 calls kappa. Others keep the
    points of the prediction for h, which leaves Q out of them, or take another root, which moves
    the points. Innovations are decorrelated as :class:`filters.LinearKalman` does with a full R.

    Its model says what it estimates: it declares neither parameters nor states. Source: Wan
    and van der Merwe, The unscented Kalman filter for nonlinear estimation, 2000, additive noise;
    Julier, The scaled unscented transformation, 2002; Sarkka, Bayesian Filtering and Smoothing,
    2013, algorithm 5.14, which draws points anew.

    Attributes:
        move: f: parameters, state, input to the next state; a module-level function.
        disturb: covariance of w, ``(n, n)``, at the state before the step.
        measure: h: to the measurements ``(m,)``.
        alpha: how far the points lie, above 0. Curvature is found from differences that shrink with
            its square, so 1e-3 costs six digits: single precision does not have that many.
        beta: 2 is best for normal distributions and a small alpha. From alpha^2 on no covariance
            can become indefinite, below it may.
        kappa: above -n; None is 3 - n, with which the points lie sqrt(3) alpha deviations away
            whatever n is.
        angles: which measurements are angles in rad, one flag for each; empty where none is. Their
            differences from h(x), at the points and of z from the mean, are within half a turn.
        turning: the same for states that f brings back within a turn; a state that counts on beyond
            half a turn needs none. Their mean is f(x) and the mean difference from it.

    >>> def still(p, x, u):
    ...     return x
    >>> filter = UnscentedKalman(still, lambda p, x, u: p * jnp.eye(1), measure=still)
    >>> model = ExtendedModel(jnp.asarray(1.0), jnp.ones(1), jnp.zeros(1), jnp.zeros((1, 1)))
    >>> state, out = filter.step(model, filter.init(model), ExtendedSample(jnp.ones(1)))
    >>> out.x.tolist()
    [0.5]
    """

    move: Move
    disturb: Move
    measure: Move
    alpha: float = 1.0
    beta: float = 2.0
    kappa: float | None = None
    angles: tuple[bool, ...] = ()
    turning: tuple[bool, ...] = ()

    inputs, outputs = ExtendedSample, LinearOutputs

    def __post_init__(self) -> None:
        if not 0 < self.alpha < inf:
            raise ValueError(
                f"UnscentedKalman: alpha is {self.alpha!r}; give a positive number, such as 1"
            )

    def init(self, params: ExtendedModel) -> Estimate:
        """The start: ``x0`` and ``P0``."""
        n, kappa = len(params.x0), self.kappa
        if kappa is not None and not -n < kappa < inf:
            raise ValueError(
                f"UnscentedKalman: kappa is {kappa!r} for {n} states; give more than {-n}, or None "
                f"for 3 - {n}"
            )
        return Estimate(params.x0, params.P0)

    def step(
        self, params: ExtendedModel, state: Estimate, inputs: ExtendedSample
    ) -> tuple[Estimate, LinearOutputs]:
        """Predict to this sample's time and take its measurements."""
        model, u = params.model, inputs.u
        reach = self.alpha**2 * (3.0 if self.kappa is None else len(state.x) + self.kappa)
        more = self.beta - self.alpha**2
        root = semidefinite_root(state.P)
        moved = transformed(
            lambda x: self.move(model, x, u), state.x, root, reach, more, self.turning
        )
        ahead = matmul(moved.slopes, moved.slopes.T) + moved.bend
        root = semidefinite_root(ahead + self.disturb(model, state.x, u))
        seen = transformed(
            lambda x: self.measure(model, x, u), moved.mean, root, reach, more, self.angles
        )
        off = difference(inputs.z, seen.mean, self.angles)
        return _taken(moved.mean, root, seen, params.R, off)


class Transformed(NamedTuple):
    """The distribution of a function's values, as sigma points show it.

    Attributes:
        mean: of the function, ``(m,)``.
        slopes: its mean slopes along the columns of the root, ``(m, n)``: ``slopes slopes'`` is the
            covariance of its linear part, ``root slopes'`` that with the argument.
        bend: the covariance of the rest, ``(m, m)``.
    """

    mean: Array
    slopes: Array
    bend: Array


def transformed(
    function: Callable[[Array], Array],
    x: Array,
    root: Array,
    reach: float,
    more: float,
    angles: Sequence[bool] = (),
) -> Transformed:
    """The unscented transformation, by differences from the point in the middle.

    The weights, large and of either sign where alpha is small, then multiply differences only.

    Args:
        function: of a point ``(n,)`` to ``(m,)``.
        x: mean of its argument, ``(n,)``.
        root: root of its covariance, ``(n, n)``.
        reach: c, the square of the points' distance.
        more: beta - alpha^2, weight of the square of the mean's shift in the covariance.
        angles: which of the m numbers are angles in rad; empty where none is.

    >>> found = transformed(lambda x: x**2, jnp.array([1.0]), jnp.eye(1), reach=3.0, more=-1.0)
    >>> found.mean.round(12).tolist(), (found.slopes**2 + found.bend).round(12).tolist()
    ([2.0], [[6.0]])
    """
    n, far = len(x), sqrt(reach)
    steps = far * root.T
    points = jax.vmap(function)(jnp.concatenate([x[None], x + steps, x - steps]))
    off = difference(points[1:], points[0], angles)
    odd, even = (off[:n] - off[n:]) / (2 * far), (off[:n] + off[n:]) / (2 * far)
    shift = even.sum(axis=0) / far
    bend = matmul(even.T, even) + more * jnp.outer(shift, shift)
    return Transformed(points[0] + shift, odd.T, bend)


def _taken(
    x: Array, root: Array, seen: Transformed, R: Array, off: Array
) -> tuple[Estimate, LinearOutputs]:
    """All measurements, in the coordinates of the root, where the prediction's covariance is I.

    There z = mean + slopes e + v, with v of the covariance R + bend: a linear measurement, whose
    update in Joseph's form subtracts no covariances and works with a singular one.
    """
    noise = R if R.ndim == 2 else jnp.diag(R)
    H, variances, z = decorrelate(seen.slopes, noise + seen.bend, off)
    start = Estimate(jnp.zeros_like(x), jnp.eye(len(x), dtype=x.dtype))

    def one(estimate: Estimate, number: tuple[Array, ...]) -> tuple[Estimate, Innovation]:
        return update(estimate, *number)

    # A loop keeps XLA from writing the first updates out into each entry of the later ones.
    known, brought = jax.lax.scan(one, start, (H, variances, z))
    P = matmul(matmul(root, known.P), root.T)
    found = Estimate(x + matmul(root, known.x), (P + P.T) / 2)
    gain = matmul(brought.gain, root.T)
    return found, LinearOutputs(found.x, found.P, brought.value, brought.variance, gain)
