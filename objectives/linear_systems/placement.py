"""Poles as coordinates: observer gains from the factors of a characteristic polynomial.

Every polynomial whose roots all decay at least as fast as a given rate is a product of the factors
below with coordinates inside simple limits, and every such product is one. So the slowest pole,
which has no gradient where poles meet, becomes a smooth coordinate of its own.
"""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters.small_linalg import product, solve


@dataclass(frozen=True)
class Factors:
    """A monic polynomial of given degree by its factors.

    Continuous, with a = ``rate``: (s + a (1 + r)) for an odd degree and, for each pair,
    (s + a)^2 + d a (s + a) + f a^2, with r, d, f >= 0: no root decays slower than e^(-a t).

    Discrete, with a = ``rate`` the radius and t = (1 - a) / (1 + a): (z - a) + t r (z + a) and
    (z - a)^2 + t d (z - a) (z + a) + t^2 f (z + a)^2, made monic: no root lies outside abs(z) = a.
    That is the bilinear map of the disc to the half plane; for slow roots r, d and f are those of
    the continuous polynomial.

    Attributes:
        degree: of the polynomial.
        discrete: whether time is discrete.
    """

    degree: int
    discrete: bool = False

    @property
    def pairs(self) -> int:
        """Number of factors of degree two."""
        return self.degree // 2

    @property
    def odd(self) -> bool:
        """Whether one factor has degree one."""
        return self.degree % 2 == 1

    def coefficients(
        self, rate: Array, real: Array | None, pairs: list[tuple[Array, Array]]
    ) -> Array:
        """The polynomial's coefficients, highest power (1) first, ``(degree + 1,)``.

        Args:
            rate: a.
            real: r, None where the degree is even.
            pairs: (d, f) of each pair.

        >>> one = jnp.asarray(1.0)
        >>> Factors(3).coefficients(2 * one, 0 * one, [(0 * one, 0 * one)]).tolist()
        [1.0, 6.0, 12.0, 8.0]
        """
        product = jnp.ones(1)
        if real is not None:
            product = self._factor(rate, jnp.stack([jnp.ones(()), real]))
        for d, f in pairs:
            product = _times(product, self._factor(rate, jnp.stack([jnp.ones(()), d, f])))
        return product

    def coordinates(
        self, rate: float, roots: np.ndarray
    ) -> tuple[float | None, list[tuple[float, float]]]:
        """r and the pairs (d, f) of a polynomial with given roots ``(degree,)``, in conjugates.

        They are not negative where no root is slower than ``rate``.

        >>> Factors(3).coordinates(1.0, np.array([-2.0, -3.0, -4.0]))
        (3.0, [(3.0, 2.0)])
        """
        roots = np.asarray(roots, complex)
        u = (roots + rate) / rate
        if self.discrete:
            u = (roots - rate) / (roots + rate) * (1 + rate) / (1 - rate)
        real = np.sort(u.real[np.abs(u.imag) <= 1e-12 * (1 + np.abs(u))])
        alone = -float(real[0]) if self.odd else None
        real = real[1:] if self.odd else real
        pairs = [(-float(a + b), float(a * b)) for a, b in real.reshape(-1, 2)]
        pairs += [
            (-2 * float(v.real), float(abs(v) ** 2)) for v in u if v.imag > 1e-12 * (1 + abs(v))
        ]
        return alone, pairs

    def _factor(self, a: Array, shape: Array) -> Array:
        """One monic factor; ``shape`` holds 1, r or 1, d, f."""
        # In u = (s + a) / a, or u = (z - a) / (z + a) / t, every factor is u^k + shape[1] u^(k-1)..
        t = (1 - a) / (1 + a)
        above = jnp.stack([jnp.ones(()), -a if self.discrete else a])
        below = jnp.stack([t, t * a]) if self.discrete else jnp.stack([jnp.zeros(()), a])
        total = shape[:1]
        power = jnp.ones(1)
        for entry in range(1, shape.shape[0]):
            power = _times(power, below)
            total = _times(total, above) + shape[entry] * power
        return total / total[0]


def _times(a: Array, b: Array) -> Array:
    """The product of two polynomials; jnp.convolve has no counterpart in symbolic tools."""
    parts = [
        jnp.concatenate([jnp.zeros(i), a * b[i], jnp.zeros(b.shape[0] - 1 - i)])
        for i in range(b.shape[0])
    ]
    return sum(parts[1:], parts[0])


def place(A: Array, c: Array, coefficients: Array) -> Array:
    """The gain L ``(n,)`` that puts the eigenvalues of A - L c on the roots of a polynomial.

    L = p(A) O^-1 e_n with O = (c, c A, ...). Source: Ackermann, 1972. Differentiable.

    Args:
        A: dynamics or transition, ``(n, n)``.
        c: one measurement row, ``(n,)``.
        coefficients: of the monic polynomial p, highest power first, ``(n + 1,)``.

    Returns:
        ``(n,)``; not finite where c does not observe every state.

    >>> A, c = jnp.array([[0.0, 1.0], [0.0, 0.0]]), jnp.array([1.0, 0.0])
    >>> place(A, c, jnp.array([1.0, 3.0, 2.0])).tolist()
    [3.0, 2.0]
    """
    n = A.shape[0]
    rows = [c]
    for _ in range(n - 1):
        rows.append(product(rows[-1][None], A)[0])
    last = solve(jnp.stack(rows), jnp.eye(n)[:, -1:])
    gain = coefficients[0] * last
    for coefficient in coefficients[1:]:  # Horner's rule
        gain = product(A, gain) + coefficient * last
    return gain[:, 0]
