"""The noise parameters of a linear model, which enter its covariances linearly."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import numpy as np
from jax import Array

from objectives.in_numpy import in_numpy

_ROUNDING = 1e-9
"""Tolerance of rounding in a derivative that is 0 or constant, over its largest entry."""


class NoModelError(ValueError):
    """The reason why a problem's identifiability does not follow from its model alone."""


@dataclass(frozen=True)
class Entry:
    """One number that enters the noise: an entry of a parameter, or its square.

    Attributes:
        parameter: the parameter's name.
        place: where in it, ``()`` for a single number.
        power: 1, or 2 for a deviation, whose square it is that enters.
    """

    parameter: str
    place: tuple[int, ...]
    power: int

    @property
    def name(self) -> str:
        """The entry in words, as Q12 or sigma^2."""
        digits = "".join(str(i + 1) for i in self.place)
        return f"{self.parameter}{digits}" + (f"^{self.power}" if self.power > 1 else "")


class Matrices(NamedTuple):
    """A model at each of U distinct steps.

    Attributes:
        F: ``(U, n, n)``.
        B: ``(U, n, q)``, or None.
        Q: G Q G', ``(U, n, n)``; of the parts of a noise ``(U, 1 + p, n, n)``.
        H: ``(m, n)``.
        R: ``(m, m)``; of the parts ``(1 + p, m, m)``.
    """

    F: Any
    B: Any
    Q: Any
    H: Any
    R: Any


class Parts(NamedTuple):
    """The p noise parameters, their values ``(p,)``, and their coefficient matrices."""

    entries: tuple[Entry, ...]
    values: np.ndarray
    matrices: Matrices


Noise = Callable[..., Matrices]
"""From free parameters by name, and what else is known, to the model."""


@dataclass(frozen=True)
class _WithSlopes:
    """A model at numbers of its entries, and its derivative by each; equal ones are traced once."""

    noise: Noise
    entries: tuple[Entry, ...]

    def __call__(
        self, points: Array, free: Mapping[str, Array], known: tuple[Any, ...]
    ) -> tuple[Matrices, Matrices]:
        """At each of the points ``(B, p)``."""

        def filled(flat: Array) -> Matrices:
            given = dict(free)
            for number, e in zip(flat, self.entries, strict=True):
                for place in {e.place, e.place[::-1]}:
                    given[e.parameter] = given[e.parameter].at[place].set(number)
            return self.noise(given, *known)

        return jax.vmap(lambda at: (filled(at), jax.jacfwd(filled)(at)))(points)


def parts_of(noise: Noise, free: Mapping[str, np.ndarray], *known: Any) -> Parts:
    """The parameters of Q and R, with their coefficient matrices.

    Numbers of the start alone are left out.

    Args:
        noise: the model from free parameters by name.
        free: these.
        known: what ``noise`` takes besides.

    Raises:
        NoModelError: where one changes F, B or H, and where Q and R are linear neither in it nor in
            its square.
    """
    entries = _entries(free)
    begun = np.array([free[e.parameter][e.place] for e in entries])
    # Different factors, so that products of two show as well.
    factors = 1.5 + np.arange(len(begun)) / max(len(begun), 1)
    points = np.stack([begun, factors * begun])
    both = in_numpy(_WithSlopes(noise, tuple(entries)), points, dict(free), known)
    (here, first), (_, second) = (jax.tree.map(lambda leaf, i=i: leaf[i], both) for i in (0, 1))
    _refuse_motion(entries, begun, here, first)
    chosen, columns, units = [], [], []
    for i, entry in enumerate(entries):
        power = _power(entry, _column(first, i), _column(second, i), factors[i])
        if power:
            chosen.append(replace(entry, power=power))
            columns.append(i)
            units.append(power * begun[i] ** (power - 1))
    values = np.array([begun[i] ** e.power for i, e in zip(columns, chosen, strict=True)])

    def parts(total: Array, slope: Array) -> np.ndarray:
        each = [np.asarray(slope[..., i]) / u for i, u in zip(columns, units, strict=True)]
        known = np.asarray(total) - sum(t * part for t, part in zip(values, each, strict=True))
        known = np.where(np.abs(known) > 1e-12 * np.abs(total), known, 0.0)  # no rounding
        return np.stack([known, *each], axis=-3)

    Q, R = parts(here.Q, first.Q), parts(here.R, first.R)
    B = None if here.B is None else np.asarray(here.B)
    matrices = Matrices(np.asarray(here.F), B, Q, np.asarray(here.H), R)
    return Parts(tuple(chosen), values, matrices)


def _entries(free: Mapping[str, np.ndarray]) -> list[Entry]:
    """All numbers of the free parameters; of symmetric matrices the upper triangle."""
    return [
        Entry(name, place, 1)
        for name, value in free.items()
        for place in np.ndindex(value.shape)
        if place == tuple(sorted(place)) or value.ndim < 2
    ]


def _refuse_motion(
    entries: list[Entry], begun: np.ndarray, here: Matrices, slope: Matrices
) -> None:
    for i, entry in enumerate(entries):
        for matrix, change in ((here.F, slope.F), (here.H, slope.H), (here.B, slope.B)):
            if matrix is None:
                continue
            moved = np.abs(np.asarray(change[..., i]) * begun[i]).max(initial=0.0)
            if moved > _ROUNDING * np.abs(np.asarray(matrix)).max(initial=0.0):
                raise NoModelError(
                    f"{entry.parameter} changes how the state moves or is measured, and what "
                    "differences tell of the noise depends on it; fix it"
                )


def _column(slope: Matrices, i: int) -> np.ndarray:
    return np.concatenate([np.ravel(slope.Q[..., i]), np.ravel(slope.R[..., i])])


def _power(entry: Entry, one: np.ndarray, two: np.ndarray, factor: float) -> int:
    """1 where the slope is constant, 2 where it grows with the number, 0 where there is none."""
    if not one.any() and not two.any():
        return 0
    size = _ROUNDING * np.abs(one).max()
    for power in (1, 2):
        if np.allclose(two, one * factor ** (power - 1), rtol=_ROUNDING, atol=1e-3 * size):
            return power
    raise NoModelError(
        f"the noise is linear neither in {entry.name} nor in its square, by which alone "
        "differences of measurements are judged"
    )
