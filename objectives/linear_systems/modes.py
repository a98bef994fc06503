"""Why a Kalman filter has no steady state, in words: modes that are unseen, or undriven.

NumPy, not traced. :func:`objectives.steady_kalman` is the steady filter of what is left.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from objectives.linear_systems.subspaces import MOST_SLACK, undriven, unseen


class Mode(NamedTuple):
    """One way in which a model moves on its own.

    Attributes:
        eigenvalue: of A, 1/s where it is continuous, else per sample.
        direction: unit vector by states: where an unseen mode moves, which combination of states
            an undriven one is; of a complex pair the absolute values.
        kind: why it stands in the way of a steady filter.
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
    """What is left of a model.

    Attributes:
        T: orthonormal basis of the states that are left, ``(n, r)``.
        A, W, C: the model in it, ``(r, r)``, ``(r, r)``, ``(m, r)``.
        modes: what was taken out.
    """

    T: np.ndarray
    A: np.ndarray
    W: np.ndarray
    C: np.ndarray
    modes: tuple[Mode, ...]


def unseen_modes(A: np.ndarray, C: np.ndarray, *, discrete: bool) -> tuple[Mode, ...]:
    """The modes that do not die out and that no measurement shows: their covariance grows.

    By the staircase of unobservable subspaces, with singular values, in scaled units; so a chain
    (a ramp: two states) is found whole.

    Args:
        A: dynamics ``(n, n)``: 1/s, or over one sample where ``discrete``.
        C: measurement matrix, ``(m, n)``.
        discrete: whether A steps by samples.

    >>> A, C = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0, 1.0]])
    >>> [mode.words(["position", "speed"]) for mode in unseen_modes(A, C, discrete=False)]
    ['the constant mode along position']
    """
    return _modes(*unseen(A, C, discrete), "unseen", discrete)


def undriven_modes(A: np.ndarray, W: np.ndarray, *, discrete: bool) -> tuple[Mode, ...]:
    """The modes that neither grow nor die out and that no noise drives.

    Their covariance falls as 1/t for ever, so the Riccati equation has no solution that makes the
    filter stable.

    Args:
        A: as for :func:`unseen_modes`.
        W: covariance of the noise in a sample, or its spectral density, ``(n, n)``.
        discrete: whether A steps by samples.

    >>> A, W = np.array([[0.0, 1.0], [0.0, 0.0]]), np.diag([1.0, 0.0])
    >>> [mode.words(["position", "bias"]) for mode in undriven_modes(A, W, discrete=False)]
    ['the constant mode along bias']
    """
    return _modes(*undriven(A, W, discrete), "undriven", discrete)


def without_undriven(A: np.ndarray, W: np.ndarray, C: np.ndarray, *, discrete: bool) -> Reduction:
    """The model on the states that its undriven modes leave, an invariant subspace of A.

    >>> found = without_undriven(np.zeros((2, 2)), np.diag([1.0, 0.0]), np.eye(2), discrete=False)
    >>> abs(found.T).tolist(), found.A.shape
    ([[1.0], [0.0]], (1, 1))
    """
    values, basis, scale = undriven(A, W, discrete)
    # y'x = 0 for each row y = basis' / scale: undriven combinations of the states
    return _reduced(
        A, W, C, basis / scale[:, None], _modes(values, basis, scale, "undriven", discrete)
    )


def without_unseen(A: np.ndarray, W: np.ndarray, C: np.ndarray, *, discrete: bool) -> Reduction:
    """The model modulo the states that grow unseen: ``T'x`` moves on its own and is all that shows.

    >>> A, C = np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0, 1.0]])
    >>> without_unseen(A, np.eye(2), C, discrete=False).T.ravel().tolist()
    [0.0, 1.0]
    """
    values, basis, scale = unseen(A, C, discrete)
    return _reduced(
        A, W, C, basis * scale[:, None], _modes(values, basis, scale, "unseen", discrete)
    )


def _modes(
    values: np.ndarray,
    basis: np.ndarray,
    scale: np.ndarray,
    kind: Literal["unseen", "undriven"],
    discrete: bool,
) -> tuple[Mode, ...]:
    found = []
    units = scale if kind == "unseen" else 1 / scale
    for value, vector in zip(values, basis.T, strict=True):
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


def _reduced(
    A: np.ndarray, W: np.ndarray, C: np.ndarray, gone: np.ndarray, modes: tuple[Mode, ...]
) -> Reduction:
    """The model on the orthogonal complement of what is gone."""
    n, count = gone.shape
    if not count:
        return Reduction(np.eye(n), A, W, C, modes)
    both = np.concatenate([gone.real, gone.imag], axis=1)
    both = both / np.maximum(np.linalg.norm(both, axis=0), np.finfo(float).tiny)
    T = np.linalg.svd(both)[0][:, count:]
    T = T * np.sign(T[np.abs(T).argmax(axis=0), np.arange(T.shape[1])])
    return Reduction(T, T.T @ A @ T, T.T @ W @ T, C @ T, modes)
