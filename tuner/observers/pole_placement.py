"""Observers by their poles: the slowest decay rate is a coordinate, so it needs no constraint.

With one measurement a gain is as good as its characteristic polynomial, whose factors are the
coordinates (:class:`objectives.Factors`). With several, one measurement guides: whatever gains the
others have, the guide's gain puts the poles (Heymann 1968 says that almost all let it), so the
coordinates are the factors and the others' gains. Stable modes that nothing shows are split off:
their gains are free, and their own decay rate limits the design's.
"""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from objectives import Factors, LinearSystem, place, unobservable
from tuner.observers.gains import Entries, Observer
from tuner.problem.parameters import Limited, Parameter, Positive

WIDEST = 100.0
"""Largest ratio of the other poles' decay rates to the slowest one's."""
_START_SHARE = 0.98
"""Initial decay rate for a gain, as a share of its slowest pole's."""
_REPRODUCED = 1e-6
"""Tolerance at which coordinates have to reproduce the gain that they were computed from."""


@dataclass(frozen=True, eq=False)
class PolePlacement:
    """The map from coordinates of the poles, and gains of the other measurements, to a gain.

    Attributes:
        system: the system.
        T: x = T x', the model's own units, seen states first, ``(n, n)``.
        H: y' = H y, the guide first, ``(m, m)``.
        seen: number of observable states.
    """

    system: LinearSystem
    T: np.ndarray
    H: np.ndarray
    seen: int

    @property
    def factors(self) -> Factors:
        """Factors of the characteristic polynomial of the observable states."""
        return Factors(self.seen, self.system.discrete)

    @property
    def side(self) -> Entries:
        """Gains of the measurements beside the guide, on the observable states."""
        return Entries("side", (self.seen, len(self.H) - 1))

    @property
    def hidden(self) -> Entries:
        """Gains on the unobservable states."""
        return Entries("hidden", (len(self.T) - self.seen, len(self.H)))

    def __call__(self, values: dict[str, Array]) -> Observer:
        """The observer at coordinates given by name."""
        decay, side = values["decay"], self.side.matrix(values)
        pairs = [
            (values[f"damping_{i + 1}"], values[f"stiffness_{i + 1}"])
            for i in range(self.factors.pairs)
        ]
        rate = decay if self.system.dt is None else jnp.exp(-decay * self.system.dt)
        coefficients = self.factors.coefficients(rate, values.get("spread"), pairs)
        A, C = self._seen()
        guide = place(jnp.asarray(A) - side @ jnp.asarray(C[1:]), jnp.asarray(C[0]), coefficients)
        L = jnp.concatenate([jnp.column_stack([guide, side]), self.hidden.matrix(values)])
        L = jnp.asarray(self.T) @ L @ jnp.asarray(self.H)
        return Observer(decay, L, self.system.steady(L))

    def coordinates(self, L: np.ndarray) -> dict[str, float] | None:
        """The coordinates of a gain ``(n, m)``; None where they are out of reach.

        So they are where the guide cannot place the poles, or the poles lie too far apart.
        """
        own = np.linalg.solve(self.T, L) @ np.linalg.inv(self.H)
        A, C = self._seen()
        decay = _START_SHARE * min(self.system.decay(L), self.limit())
        rate = decay if self.system.dt is None else np.exp(-decay * self.system.dt)
        poles = np.linalg.eigvals(A - own[: self.seen] @ C)
        values = self._named(*self.factors.coordinates(rate, poles))
        if not all(0 <= values[name] <= most for name, most in self._limits().items()):
            return None
        values |= self.side.named(own[: self.seen, 1:]) | self.hidden.named(own[self.seen :])
        values["decay"] = decay
        back = np.asarray(_gain(self, {name: jnp.asarray(v) for name, v in values.items()}))
        return values if np.abs(back - L).max() <= _REPRODUCED * np.abs(L).max() else None

    def coinciding(self, decay: float) -> dict[str, float]:
        """The coordinates of poles with one decay rate, and no gains beside the guide's."""
        alike: dict[str, float] = dict.fromkeys(self._limits(), 0.0)
        for entries in (self.side, self.hidden):
            alike |= entries.named(np.zeros(entries.shape))
        return alike | {"decay": decay}

    def limit(self) -> float:
        """The slowest decay rate of the unobservable states, 1/s: no observer is faster."""
        A = np.linalg.solve(self.T, self.system.A @ self.T)[self.seen :, self.seen :]
        return float(self.system.rates(np.linalg.eigvals(A)).min(initial=np.inf))

    def parameters(self, start: dict[str, float]) -> dict[str, Parameter]:
        """The coordinates as parameters that start at given values."""
        decay, limit = start["decay"], self.limit()
        found: dict[str, Parameter] = {
            "decay": Positive(decay, 1e-4 * decay, 1e4 * decay, unit="1/s")
            if np.isinf(limit)
            else Limited(decay, 1e-4 * decay, limit, unit="1/s", scale=decay)
        }
        found |= {name: Limited(start[name], 0.0, most) for name, most in self._limits().items()}
        return found | self._gains(self.side, start) | self._gains(self.hidden, start)

    def _limits(self) -> dict[str, float]:
        """The factors' coordinates by name, with their upper limits."""
        widest = WIDEST if self.factors.odd else None
        return self._named(widest, [(WIDEST, WIDEST**2)] * self.factors.pairs)

    @staticmethod
    def _named(real: float | None, pairs: list[tuple[float, float]]) -> dict[str, float]:
        values = {} if real is None else {"spread": real}
        for i, (damping, stiffness) in enumerate(pairs):
            values |= {f"damping_{i + 1}": damping, f"stiffness_{i + 1}": stiffness}
        return values

    def _gains(self, entries: Entries, start: dict[str, float]) -> dict[str, Parameter]:
        names = list(entries.named(np.zeros(entries.shape)))
        values = np.array([start[name] for name in names]).reshape(entries.shape)
        unit = np.abs(values).max(initial=0.0) or 1.0
        return entries.parameters(values, np.full(entries.shape, unit))

    def _seen(self) -> tuple[np.ndarray, np.ndarray]:
        A = np.linalg.solve(self.T, self.system.A @ self.T)
        C = self.H @ self.system.C @ self.T
        return A[: self.seen, : self.seen], C[:, : self.seen]


@jax.jit(static_argnums=0)
def _gain(placement: PolePlacement, values: dict[str, Array]) -> Array:
    return placement(values).L


def pole_placements(system: LinearSystem, size: np.ndarray) -> list[PolePlacement]:
    """The ways to place a system's poles, one with each measurement as guide.

    Args:
        system: the system.
        size: a typical error of every state, ``(n,)``.
    """
    n, C = len(size), system.C * size
    hidden = unobservable(system.in_units(np.diag(size), np.ones(len(C)), 1.0))
    count = len(hidden.values)
    turned = np.eye(n)
    if count:
        turned = np.linalg.svd(hidden.scale[:, None] * hidden.basis)[0][:, ::-1]
    T = size[:, None] * turned
    height = np.sqrt((C**2).sum(axis=1))
    scale = np.where(height > 0, height, 1.0)
    own = np.diag(1 / scale)
    return [
        PolePlacement(system, T, np.roll(own, -guide, axis=0), n - count)
        for guide in np.flatnonzero(height)
    ]
