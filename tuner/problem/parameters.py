"""The kinds of parameters that can be tuned, each as unconstrained numbers z.

Positive numbers are tuned as their logarithm, bounded ones through a logistic curve, and
covariances through the logarithms of their Cholesky diagonal, so that no solver can leave the
allowed set. A fixed parameter takes no place in z.
"""

from dataclasses import dataclass, replace
from typing import Any, Protocol

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from objectives import covariance


class Parameter(Protocol):
    """One named parameter: ``size`` numbers of z, and the value they stand for."""

    @property
    def size(self) -> int:
        """Number of its entries in z."""
        ...

    @property
    def unit(self) -> str:
        """The value's unit, "" for none."""
        ...

    @property
    def meaning(self) -> str:
        """Its meaning, in a short sentence; "" where none was given."""
        ...

    @property
    def limited(self) -> bool:
        """Whether the ends of its box are limits of the problem, not of the search alone."""
        ...

    def constrain(self, z: Array) -> Array:
        """The value that ``(size,)`` entries of z stand for."""
        ...

    def unconstrain(self, value: np.ndarray) -> np.ndarray:
        """The entries of z that stand for a value, ``(size,)``."""
        ...

    def start(self) -> np.ndarray:
        """The entries of z that stand for the initial value, ``(size,)``."""
        ...

    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """The lowest and highest z, ``(size,)`` each."""
        ...

    def coordinates(self, name: str) -> list[str]:
        """The name of each entry of z, in words."""
        ...

    def form(self) -> "Parameter":
        """Another parameter with the same :meth:`constrain`: equal ones share their programs."""
        ...


@dataclass(frozen=True)
class Positive:
    """A positive number between ``low`` and ``high``, tuned as its natural logarithm.

    ``threshold`` says that something switches at this value, so that an objective is
    piecewise constant in it and an automatic gradient is 0 and tells nothing.
    """

    init: float
    low: float
    high: float
    unit: str = ""
    size: int = 1
    limited: bool = False
    threshold: bool = False
    meaning: str = ""

    def __post_init__(self) -> None:
        if not 0 < self.low <= self.init <= self.high < np.inf:
            raise ValueError(
                f"a positive parameter needs 0 < low <= init <= high, got low {self.low:g}, "
                f"init {self.init:g}, high {self.high:g}"
            )

    def constrain(self, z: Array) -> Array:
        """exp z."""
        return jnp.exp(z[0])

    def unconstrain(self, value: np.ndarray) -> np.ndarray:
        """Ln value."""
        number = _number(value)
        if not 0 < number < np.inf:
            raise ValueError(f"must be positive and finite, got {number:g}")
        return np.log([number])

    def start(self) -> np.ndarray:
        """Ln init."""
        return self.unconstrain(np.asarray(self.init))

    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Ln low and ln high."""
        return np.log([self.low]), np.log([self.high])

    def coordinates(self, name: str) -> list[str]:
        """Ln of the name."""
        return [f"ln {name}"]

    def form(self) -> "Positive":
        """The logarithm of any positive number."""
        return Positive(1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Bounded:
    """A number strictly between ``low`` and ``high``, tuned through the logistic curve."""

    init: float
    low: float
    high: float
    unit: str = ""
    size: int = 1
    limited: bool = False
    meaning: str = ""

    def __post_init__(self) -> None:
        if not -np.inf < self.low < self.init < self.high < np.inf:
            raise ValueError(
                f"a bounded parameter needs finite low < init < high, got low {self.low:g}, "
                f"init {self.init:g}, high {self.high:g}"
            )

    def constrain(self, z: Array) -> Array:
        """Low + (high - low) / (1 + exp -z)."""
        return self.low + (self.high - self.low) * jax.nn.sigmoid(z[0])

    def unconstrain(self, value: np.ndarray) -> np.ndarray:
        """The logit of the value's place between the bounds."""
        number = _number(value)
        share = (number - self.low) / (self.high - self.low)
        if not 0 < share < 1:
            raise ValueError(
                f"must lie strictly between {self.low:g} and {self.high:g}, got {number:g}"
            )
        return np.array([np.log(share) - np.log1p(-share)])

    def start(self) -> np.ndarray:
        """The logit of init."""
        return self.unconstrain(np.asarray(self.init))

    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Init, or a thousandth of the range from either bound, where the curve is nearly flat."""
        start = self.start()
        return np.minimum(-6.9, start), np.maximum(6.9, start)

    def coordinates(self, name: str) -> list[str]:
        """Logit of the name."""
        return [f"logit {name}"]

    def form(self) -> "Bounded":
        """The same between the same bounds."""
        return replace(self, unit="", meaning="")


@dataclass(frozen=True)
class Limited:
    """A number that is tuned as it is, in its own scale, between limits that belong to the problem.

    The optimum may lie at a limit: it counts as converged there, with a multiplier, while a
    parameter of another kind that ends at its bound shows that the box was too small.
    """

    init: float
    low: float
    high: float
    unit: str = ""
    scale: float = 1.0
    size: int = 1
    limited: bool = True
    meaning: str = ""

    def __post_init__(self) -> None:
        if not -np.inf < self.low <= self.init <= self.high < np.inf or self.low == self.high:
            raise ValueError(
                f"a limited parameter needs finite low <= init <= high and low < high, got low "
                f"{self.low:g}, init {self.init:g}, high {self.high:g}"
            )
        if not 0 < self.scale < np.inf:
            raise ValueError(f"a limited parameter needs a positive scale, got {self.scale:g}")

    def constrain(self, z: Array) -> Array:
        """Scale times z."""
        return self.scale * z[0]

    def unconstrain(self, value: np.ndarray) -> np.ndarray:
        """The number over its scale."""
        number = _number(value)
        if not self.low <= number <= self.high:
            raise ValueError(f"must lie between {self.low:g} and {self.high:g}, got {number:g}")
        return np.array([number / self.scale])

    def start(self) -> np.ndarray:
        """Init over its scale."""
        return np.array([self.init / self.scale])

    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Low and high over the scale."""
        return np.array([self.low / self.scale]), np.array([self.high / self.scale])

    def coordinates(self, name: str) -> list[str]:
        """The name."""
        return [name]

    def form(self) -> "Limited":
        """A number of the same scale."""
        return Limited(0.0, 0.0, 1.0, scale=self.scale)


@dataclass(frozen=True)
class Covariance:
    """A covariance matrix ``(n, n)``, tuned as its Cholesky factor with logarithmic diagonal.

    Attributes:
        init: the initial matrix as nested tuples, symmetric positive definite.
        low, high: bounds of the factor's diagonal, that is of standard deviations.
        unit: unit of the entries.
        meaning: its meaning.
    """

    init: tuple[tuple[float, ...], ...]
    low: float
    high: float
    unit: str = ""
    limited: bool = False
    meaning: str = ""

    def __post_init__(self) -> None:
        if not 0 < self.low < self.high < np.inf:
            raise ValueError(
                f"a covariance needs 0 < low < high, got low {self.low:g}, high {self.high:g}"
            )
        (low, high), start = self.box(), self.start()
        if not ((low <= start) & (start <= high)).all():
            raise ValueError(
                "the Cholesky factor of a covariance's init needs a diagonal from low "
                f"{self.low:g} to high {self.high:g} and no entry above high, got "
                f"{np.linalg.cholesky(np.asarray(self.init)).tolist()}"
            )

    @property
    def size(self) -> int:
        """n (n + 1) / 2."""
        return len(self.init) * (len(self.init) + 1) // 2

    def constrain(self, z: Array) -> Array:
        """L L' with L's diagonal exp z."""
        n = len(self.init)
        L = jnp.zeros((n, n)).at[np.tril_indices(n)].set(z)
        L = L.at[np.diag_indices(n)].set(jnp.exp(jnp.diagonal(L)))
        return L @ L.T

    def unconstrain(self, value: np.ndarray) -> np.ndarray:
        """The lower triangle of the Cholesky factor, its diagonal as logarithms, row by row."""
        matrix, n = covariance(value, definite=True), len(self.init)
        if len(matrix) != n:
            raise ValueError(f"must have the shape {(n, n)}, got {matrix.shape}")
        L = np.linalg.cholesky(matrix)
        diagonal = np.diag_indices(n)
        L[diagonal] = np.log(L[diagonal])
        lower: np.ndarray = L[np.tril_indices(n)]
        return lower

    def start(self) -> np.ndarray:
        """The factor of init."""
        return self.unconstrain(np.asarray(self.init))

    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Ln low and ln high on the diagonal, +-high below it."""
        rows, columns = np.tril_indices(len(self.init))
        on = rows == columns
        return np.where(on, np.log(self.low), -self.high), np.where(
            on, np.log(self.high), self.high
        )

    def coordinates(self, name: str) -> list[str]:
        """Entries of the factor L."""
        pairs = zip(*np.tril_indices(len(self.init)), strict=True)
        return [f"{'ln ' if i == j else ''}L{i + 1}{j + 1} of {name}" for i, j in pairs]

    def form(self) -> "Covariance":
        """A covariance of the same size."""
        return Covariance(tuple(map(tuple, np.eye(len(self.init)).tolist())), 1.0, 2.0)


@dataclass(frozen=True)
class Fixed:
    """A parameter that is not tuned: a number, or a vector or matrix as nested tuples.

    ``nominal`` says that the value is only a choice: another one that is given is taken, as where
    all variances of a filter are scaled together.
    """

    value: float | tuple[Any, ...]
    unit: str = ""
    size: int = 0
    limited: bool = False
    meaning: str = ""
    nominal: bool = False

    def constrain(self, z: Array) -> Array:
        """The value itself."""
        return jnp.asarray(self.value, dtype=float)

    def unconstrain(self, value: np.ndarray) -> np.ndarray:
        """Nothing; any other value than the fixed one is an error, unless it is nominal."""
        if not self.nominal and not np.array_equal(value, np.asarray(self.value)):
            raise ValueError(f"is fixed at {self.value}, got {value}")
        return np.zeros(0)

    def start(self) -> np.ndarray:
        """Nothing."""
        return np.zeros(0)

    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """Nothing."""
        return np.zeros(0), np.zeros(0)

    def coordinates(self, name: str) -> list[str]:
        """Nothing."""
        return []

    def form(self) -> "Fixed":
        """The same value."""
        return Fixed(self.value)


def _number(value: np.ndarray) -> float:
    """The only number of an array."""
    if np.size(value) != 1:
        raise ValueError(f"must be one number, got the shape {np.shape(value)}")
    return float(np.reshape(value, ()))
