"""The observer of least variance among those that settle within a time."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from numpy.typing import ArrayLike

from filters import run
from filters.exponential import expm
from objectives import LinearSystem, require_detectable
from tuner.observers.gains import Entries, Observer, Variance
from tuner.observers.prescribed_decay import gain_of_decay
from tuner.problem.constraint import Constraint
from tuner.problem.problem import Problem
from tuner.problem.space import Space

SETTLED = 0.02
"""An error has settled when it stays below this share of its largest value."""
_POINTS, _REACH = 48, 4  # it is looked at so often, on the span of so many settling times
_POWER = 32  # of the mean that stands for the largest, so that it has a gradient
_STARTS = 3
_NOTHING = 1e-12
_FINE = 5000
_DEADBEAT = 20.0  # poles that decay by e^-20 a sample are as good as gone


@dataclass(frozen=True, eq=False)
class Settling:
    """The error that counts after a given time, whichever state it began in.

    Attributes:
        system: the system.
        error: weights of the error that counts, ``(n,)``.
        within_s: the time.
    """

    system: LinearSystem
    error: np.ndarray
    within_s: float

    def __call__(self, observer: Observer, _: None) -> Array:
        """The largest share that remains later, ``()``; slightly more where several are near it."""
        later, size = self.left(observer.L)
        share = later / size / SETTLED
        largest = jnp.maximum(jnp.max(share), 1e-12)
        total: Array = jnp.sum((share / largest) ** _POWER) ** (1 / _POWER)
        return SETTLED * largest * total

    def left(self, L: Array) -> tuple[Array, Array]:
        """The error after the time, for one in each state, ``(k, n)``; its largest value, ``(n,)``.

        Where a state does not touch the error that counts the largest is infinite.
        """
        closed = jnp.asarray(self.system.A) - L @ jnp.asarray(self.system.C)
        before = _POINTS // _REACH
        if self.system.dt is None:
            step = expm(closed * (self.within_s / before))
            early, _ = _rows(jnp.asarray(self.error), step, before)
            late, _ = _rows(early[-1], step, _POINTS - before)
        else:
            count = self.samples
            fine = jnp.linalg.matrix_power(closed, max(count // before, 1))
            early, _ = _rows(jnp.asarray(self.error), fine, before)
            reached = jnp.asarray(self.error) @ jnp.linalg.matrix_power(closed, count)
            late, _ = _rows(reached, fine, _POINTS - before)
        largest = jnp.max(jnp.abs(early), axis=0)
        nothing = largest <= _NOTHING * jnp.max(largest)
        return jnp.abs(late), jnp.where(nothing, jnp.inf, largest)

    @property
    def samples(self) -> int:
        """Samples within the time, of a discrete system."""
        return int(np.floor(self.within_s / (self.system.dt or 1.0) * (1 + 1e-9)))


def _rows(row: Array, step: Array, count: int) -> tuple[Array, Array]:
    """A row vector times the powers of a matrix, ``(count + 1, n)``, and the last of these."""
    last, found = run(_Multiplied(), (row, step), jnp.zeros(count + 1))
    return found, last


@dataclass(frozen=True)
class _Multiplied:
    """A row vector multiplied by a matrix at every sample; both are its parameters."""

    def init(self, params: tuple[Array, Array]) -> Array:
        return params[0]

    def step(self, params: tuple[Array, Array], state: Array, inputs: Array) -> tuple[Array, Array]:
        return state @ params[1], state


def settled(name: str, system: LinearSystem, error: ArrayLike, within_s: float) -> Problem:
    """The observer with the least variance of the error among those that settle in time.

    It settles in time where the error that counts, after an error in any one state, stays below
    2 % of its largest from then on. Its gains are found by a search that begins from Kalman filters
    of prescribed decay (:mod:`tuner.observers.prescribed_decay`); where the Kalman filter settles
    in time by itself, it is the one.

    Args:
        name: of the problem.
        system: the system.
        error: weights of the error that counts, ``(n,)``.
        within_s: the time.

    Raises:
        ValueError: where no observer was found that settles in time, or none is stable.
    """
    variance = Variance.of(system, error)
    require_detectable(system)
    settling = Settling(system, variance.error, within_s)
    gains = _settling_gains(settling)
    entries = Entries("L", (len(system.A), len(system.C)))
    size = np.max([np.abs(gain) for gain in gains], axis=0)
    unit = np.maximum(size, 1e-3 * size.max())
    space = Space.of(**entries.parameters(gains[0], unit))
    return Problem(
        name=name,
        space=space,
        filter=None,
        build=_Gains(system, entries),
        objective=variance,
        constraints=(Constraint("settles", settling, SETTLED),),
        known_starts=tuple(space.unconstrain(entries.named(gain)) for gain in gains[1:]),
    )


def settling_time(system: LinearSystem, L: np.ndarray, error: np.ndarray) -> float:
    """Time after which the error that counts, from any state, stays below 2 % of its largest, s.

    Infinite if it never is.

    >>> system = LinearSystem([[0.0]], [[1.0]], [[1.0]], [[1.0]])
    >>> round(settling_time(system, np.array([[2.0]]), np.array([1.0])), 2)
    1.96
    """
    decay = system.decay(L)
    if not decay > 0:
        return np.inf
    closed = system.A - L @ system.C
    step = 15 / decay / _FINE
    if system.dt is None:
        each = np.asarray(expm(jnp.asarray(closed * step)))
    else:  # a slow observer of fast samples is evaluated at intervals
        apart = max(int(step / system.dt), 1)
        step, each = apart * system.dt, np.linalg.matrix_power(closed, apart)
    rows = [np.asarray(error, float)]
    for _ in range(int(np.ceil(15 / decay / step)) + 2 * len(closed)):
        rows.append(rows[-1] @ each)
    found = np.abs(rows)
    size = found.max(axis=0)
    touched = size > _NOTHING * size.max()
    beyond = (found[:, touched] > SETTLED * size[touched]).any(axis=1)
    return float(step * (np.flatnonzero(beyond)[-1] + 1))


def _settling_gains(settling: Settling) -> list[np.ndarray]:
    """Stable gains that settle in time, the slowest first; and the Kalman filter's, if it does."""
    system, within = settling.system, settling.within_s
    if system.discrete and settling.samples < 1:
        raise ValueError(
            f"no observer settles within {within:g} s: the measurements come every {system.dt:g} s"
        )
    share = jax.jit(lambda L: settling(Observer(jnp.ones(()), L, jnp.zeros(())), None))
    found: list[np.ndarray] = []
    stable: list[np.ndarray] = []
    fastest = 300.0 / within if system.dt is None else min(300.0 / within, _DEADBEAT / system.dt)
    for alpha in np.append(0.0, np.geomspace(0.03 / within, fastest, 60)):
        try:
            L = gain_of_decay(system, float(alpha))
        except ValueError:
            continue
        if not system.decay(L) > 0:
            continue
        stable.append(L)
        if float(share(jnp.asarray(L))) <= SETTLED:
            found.append(L)
            if len(found) == _STARTS:
                break
    if not found:
        raise ValueError(
            f"no observer settles within {within:g} s: {_reached(settling, stable)}; allow more "
            "time, or measure faster or more"
        )
    return found


def _reached(settling: Settling, gains: list[np.ndarray]) -> str:
    if not gains:
        return "none was found that is stable"
    times = [settling_time(settling.system, L, settling.error) for L in gains]
    return f"the fastest that was found takes {min(times):.4g} s"


@dataclass(frozen=True, eq=False)
class _Gains:
    """The map from single gains to a point of the design."""

    system: LinearSystem
    entries: Entries

    def __call__(self, values: dict[str, Array]) -> Observer:
        L = self.entries.matrix(values)
        return Observer(jnp.ones(()), L, self.system.steady(L))
