"""Modes that keep a Kalman filter from a steady state: undetectable, or undriven ones.

NumPy, not traced. :func:`objectives.steady_kalman` is the steady filter of what is left.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from objectives.linear_systems.model import LinearSystem
from objectives.linear_systems.subspaces import MOST_SLACK, Subspace, undriven, unseen


class Mode(NamedTuple):
    """A mode of a model.

    Attributes:
        eigenvalue: of A, 1/s where it is continuous, else per sample.
        direction: unit vector by states: where an unseen mode moves, which combination of states
            an undriven one is; of a complex pair the absolute values.
        kind: why it prevents a steady filter.
        discrete: whether the eigenvalue is per sample.
    """

    eigenvalue: complex
    direction: tuple[float, ...]
    kind: Literal["unseen", "undriven"]
    discrete: bool

    def words(self, states: Sequence[str] | None = None) -> str:
        """The mode in words.

        Raises:
            ValueError: where there is not one name for each state.

        >>> Mode(1.0 + 0.0j, (0.0, 1.0), "undriven", True).words(["h", "bias"])
        'the constant mode along bias'
        """
        names = states or [f"x{i + 1}" for i in range(len(self.direction))]
        if len(names) != len(self.direction):
            raise ValueError(
                f"{len(names)} names for {len(self.direction)} states ({', '.join(names)}); give "
                "one for each state"
            )
        along = ", ".join(n for n, d in zip(names, self.direction, strict=True) if d != 0)
        rest = 1.0 if self.discrete else 0.0
        if abs(self.eigenvalue - rest) < MOST_SLACK:
            return f"the constant mode along {along}"
        value = self.eigenvalue if self.eigenvalue.imag else self.eigenvalue.real
        unit = "per sample" if self.discrete else "1/s"
        return f"the mode {value:.6g} {unit} along {along}"


class Reduction(NamedTuple):
    """A system reduced to some of its states.

    Attributes:
        T: orthonormal basis of the remaining states, ``(n, r)``.
        system: how T'x moves; a state that is left alone keeps its name. It may have no states.
        modes: the removed ones.
    """

    T: np.ndarray
    system: LinearSystem
    modes: tuple[Mode, ...]


def unseen_modes(system: LinearSystem) -> tuple[Mode, ...]:
    """The undetectable modes: no measurement shows them, they do not decay, their covariance grows.

    By the staircase of unobservable subspaces, with singular values, in scaled units; so a chain
    (a ramp: two states) is found whole.

    >>> A, C, names = [[0.0, 1.0], [0.0, 0.0]], [[0.0, 1.0]], ("position", "speed")
    >>> system = LinearSystem(A, C, np.eye(2), [[1.0]], states=names)
    >>> [mode.words(names) for mode in unseen_modes(system)]
    ['the constant mode along position']
    """
    return _modes(unseen(system), "unseen", system.discrete)


def undriven_modes(system: LinearSystem) -> tuple[Mode, ...]:
    """The neutral modes that no noise drives: they neither grow nor decay.

    Their covariance falls as 1/t for ever, so the Riccati equation has no solution that makes the
    filter stable.

    >>> A, names = [[0.0, 1.0], [0.0, 0.0]], ("position", "bias")
    >>> system = LinearSystem(A, [[1.0, 0.0]], np.diag([1.0, 0.0]), [[1.0]], states=names)
    >>> [mode.words(names) for mode in undriven_modes(system)]
    ['the constant mode along bias']
    """
    return _modes(undriven(system), "undriven", system.discrete)


def require_detectable(system: LinearSystem) -> None:
    """Refuse a system that has no stable observer.

    Raises:
        ValueError: names the modes that do not decay and show in no measurement.
    """
    modes = unseen_modes(system)
    if modes:
        words = " and ".join(mode.words(system.states) for mode in modes)
        raise ValueError(
            f"no measurement shows {words}, which does not die out, so no observer's error stays "
            "bounded; measure it, or leave it out of the model"
        )


def without_undriven(system: LinearSystem) -> Reduction:
    """The system on the states without its undriven modes, an invariant subspace of A.

    >>> walks = LinearSystem(np.zeros((2, 2)), np.eye(2), np.diag([1.0, 0.0]), np.eye(2))
    >>> found = without_undriven(walks)
    >>> found.T.tolist(), found.system.states
    ([[1.0], [0.0]], ('x1',))
    """
    found = undriven(system)
    # y'x = 0 for each row y = basis' / scale: undriven combinations of the states
    gone = found.basis / found.scale[:, None]
    return _reduced(system, gone, _modes(found, "undriven", system.discrete))


def without_unseen(system: LinearSystem) -> Reduction:
    """The system modulo its undetectable states: T'x is autonomous and determines all outputs.

    >>> system = LinearSystem([[0.0, 1.0], [0.0, 0.0]], [[0.0, 1.0]], np.eye(2), [[1.0]])
    >>> without_unseen(system).T.ravel().tolist()
    [0.0, 1.0]
    """
    found = unseen(system)
    gone = found.basis * found.scale[:, None]
    return _reduced(system, gone, _modes(found, "unseen", system.discrete))


def _modes(
    space: Subspace, kind: Literal["unseen", "undriven"], discrete: bool
) -> tuple[Mode, ...]:
    found = []
    units = space.scale if kind == "unseen" else 1 / space.scale
    for value, vector in zip(space.values, space.basis.T, strict=True):
        if value.imag < -1e-9 * abs(value):
            continue  # its conjugate stands for both
        plain = abs(value.imag) <= 1e-9 * abs(value)
        size = np.abs(vector)
        turned = vector / vector[size.argmax()] if plain else size
        direction = np.where(size > 1e-8 * size.max(), turned.real, 0.0) * units
        direction = direction / np.linalg.norm(direction)
        shown = complex(value.real, 0.0 if plain else value.imag)
        found.append(Mode(shown, tuple(direction.tolist()), kind, discrete))
    return tuple(found)


def _reduced(system: LinearSystem, gone: np.ndarray, modes: tuple[Mode, ...]) -> Reduction:
    """The system on the orthogonal complement of the removed states."""
    n, count = gone.shape
    if not count:
        return Reduction(np.eye(n), system, modes)
    both = np.concatenate([gone.real, gone.imag], axis=1)
    both = both / np.maximum(np.linalg.norm(both, axis=0), np.finfo(float).tiny)
    T = np.linalg.svd(both)[0][:, count:]
    single = np.abs(T) > 1 - 1e-9
    T = np.where(single.any(axis=0), single, T)  # a state that is left alone keeps its own sign
    T = T * np.sign(T[np.abs(T).argmax(axis=0), np.arange(T.shape[1])])
    names = [
        system.states[int(column.argmax())] if column.any() else f"part_{i + 1}"
        for i, column in enumerate(single.T)
    ]
    return Reduction(T, system.restricted(T, names), modes)
