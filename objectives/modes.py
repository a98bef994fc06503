"""Why a Kalman filter has no steady state, in words, and the steady filter of what is left.

NumPy, not traced: for the sentence that a user reads, and for models to which
:func:`objectives.dare` answers NaN. Decisions are taken in units in which the entries of the
model are alike, so the units of states and of time do not decide.
"""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import scipy.linalg

from objectives.riccati import bucy_gain, care, dare, steady_gain, updated

_EPS = float(np.finfo(np.float64).eps)
_NOTHING = 1e-10  # of a scaled model's entries: far above rounding, far below any use
_MOST_SLACK = 1e-6  # of the rates: where rounding leaves a chain of two
_dare, _care = jax.jit(dare), jax.jit(care)


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
        if abs(self.eigenvalue - rest) < _MOST_SLACK:
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


class SteadyKalman(NamedTuple):
    """A Kalman filter in its steady state.

    Attributes:
        predicted: covariance before a measurement, ``(n, n)``; zero along what was taken out.
        updated: after it, ``(n, n)``; of a continuous filter the same.
        gain: ``(n, m)``; of a continuous filter in 1/s.
        poles: eigenvalues of the filter's error dynamics, without what was taken out, ``(r,)``.
        removed: the undriven modes that were taken out: in the end the filter knows them.
    """

    predicted: np.ndarray
    updated: np.ndarray
    gain: np.ndarray
    poles: np.ndarray
    removed: tuple[Mode, ...]


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
    return _modes(*_unseen(A, C, discrete), "unseen", discrete)


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
    return _modes(*_undriven(A, W, discrete), "undriven", discrete)


def without_undriven(A: np.ndarray, W: np.ndarray, C: np.ndarray, *, discrete: bool) -> Reduction:
    """The model on the states that its undriven modes leave, an invariant subspace of A.

    >>> found = without_undriven(np.zeros((2, 2)), np.diag([1.0, 0.0]), np.eye(2), discrete=False)
    >>> abs(found.T).tolist(), found.A.shape
    ([[1.0], [0.0]], (1, 1))
    """
    values, basis, scale = _undriven(A, W, discrete)
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
    values, basis, scale = _unseen(A, C, discrete)
    return _reduced(
        A, W, C, basis * scale[:, None], _modes(values, basis, scale, "unseen", discrete)
    )


def steady_kalman(
    A: np.ndarray,
    C: np.ndarray,
    W: np.ndarray,
    V: np.ndarray,
    *,
    discrete: bool,
    states: Sequence[str] | None = None,
) -> SteadyKalman:
    """The steady Kalman filter, without the undriven modes that keep it from having one.

    Args:
        A: dynamics ``(n, n)``: 1/s, or over one sample where ``discrete``.
        C: measurement matrix, ``(m, n)``.
        W: covariance of the noise in a sample, or its spectral density, ``(n, n)``.
        V: the same of the measurement noise, ``(m, m)``.
        discrete: whether A steps by samples.
        states: their names, for the sentences.

    Raises:
        ValueError: where shapes do not fit, V is not positive definite, W is not positive
            semi-definite, a mode that does not die out is not seen, or no solution was found.

    >>> one = np.eye(1)
    >>> float(steady_kalman(one, one, one, one, discrete=True).gain[0, 0].round(6))
    0.618034
    """
    A, C, W, V = (np.asarray(part, dtype=np.float64) for part in (A, C, W, V))
    _check(A, C, W, V)
    unseen = unseen_modes(A, C, discrete=discrete)
    if unseen:
        raise ValueError(
            f"no measurement shows {' and '.join(mode.words(states) for mode in unseen)}, which "
            "does not die out, so its covariance grows without bound; measure it or leave it out"
        )
    part = without_undriven(A, W, C, discrete=discrete)
    if not part.A.size:
        zero = np.zeros_like(A)
        return SteadyKalman(zero, zero, np.zeros_like(C.T), np.zeros(0), part.modes)
    small = np.asarray((_dare if discrete else _care)(part.A, part.C, part.W, V))
    if np.isnan(small).any():
        small = _by_schur(part, V, discrete)
    if np.isnan(small).any():
        raise ValueError(
            "the Riccati equation was not solved, although every mode is seen and driven; the "
            f"model lies too near to one without a steady filter: its poles are {_listed(A)}"
        )
    traced = jnp.asarray(small), jnp.asarray(part.C), jnp.asarray(V)
    after = np.asarray(updated(*traced)) if discrete else small
    gain = np.asarray((steady_gain if discrete else bucy_gain)(*traced))
    closed = part.A - (part.A @ gain if discrete else gain) @ part.C
    T = part.T
    poles = np.linalg.eigvals(closed)
    return SteadyKalman(T @ small @ T.T, T @ after @ T.T, T @ gain, poles, part.modes)


def _by_schur(part: Reduction, V: np.ndarray, discrete: bool) -> np.ndarray:
    """scipy's solution by ordered Schur vectors, for noise a factor 1e12 apart; NaN where none."""
    solve = scipy.linalg.solve_discrete_are if discrete else scipy.linalg.solve_continuous_are
    try:
        return np.asarray(solve(part.A.T, part.C.T, part.W, V))
    except (np.linalg.LinAlgError, ValueError):
        return np.full_like(part.A, np.nan)


def _check(A: np.ndarray, C: np.ndarray, W: np.ndarray, V: np.ndarray) -> None:
    n, m = len(A), len(C)
    if (A.shape, C.shape, W.shape, V.shape) != ((n, n), (m, n), (n, n), (m, m)):
        raise ValueError(
            f"A {A.shape}, C {C.shape}, W {W.shape} and V {V.shape} do not fit; they are (n, n), "
            "(m, n), (n, n) and (m, m)"
        )
    if not all(np.isfinite(part).all() for part in (A, C, W, V)):
        raise ValueError("A, C, W or V has entries that are not finite; every entry must be known")
    for name, matrix, positive in (("V", V, True), ("W", W, False)):
        if not np.allclose(matrix, matrix.T, rtol=1e-9, atol=0):
            raise ValueError(f"{name} is not symmetric; a covariance is: give ({name} + {name}')/2")
        deviation = np.sqrt(np.abs(np.diag(matrix)))
        unit = np.where(deviation > 0, deviation, 1.0)
        least = np.linalg.eigvalsh(matrix / np.outer(unit, unit)).min(initial=1.0)
        if least <= 0 if positive else least < -1e-9:
            value = np.linalg.eigvalsh(matrix).min()
            kind = "positive definite" if positive else "positive semi-definite"
            raise ValueError(
                f"{name} is not {kind}: its smallest eigenvalue is {value:.3g}; give a covariance"
            )


def _listed(A: np.ndarray) -> str:
    return ", ".join(f"{value:.4g}" for value in np.linalg.eigvals(A))


Subspace = tuple[np.ndarray, np.ndarray, np.ndarray]


def _unseen(A: np.ndarray, C: np.ndarray, discrete: bool) -> Subspace:
    """Eigenvalues, an orthonormal basis in scaled states, and the scale: x = scale * scaled."""
    return _hidden(np.asarray(A, np.float64), np.asarray(C, np.float64), discrete, grows=True)


def _undriven(A: np.ndarray, W: np.ndarray, discrete: bool) -> Subspace:
    """The same for the transposed model; there y = scaled / scale is a combination of states."""
    A, W = np.asarray(A, np.float64), np.asarray(W, np.float64)
    values, basis, scale = _hidden(A.T, W, discrete, grows=False)
    return values, basis, 1 / scale


def _hidden(A: np.ndarray, C: np.ndarray, discrete: bool, grows: bool) -> Subspace:
    """The invariant subspace of A in the kernel of C with eigenvalues that do not die out."""
    n = len(A)
    rates = A - np.eye(n) if discrete else A
    scale = _scale(rates, C)
    rates = rates / scale[:, None] * scale
    size = np.abs(rates).max(initial=0.0)
    rounding = _EPS * max(1.0, 1 / size) if discrete and size > 0 else _EPS
    unit = rates / size if size > 0 else rates
    basis = _unobservable(unit, C * scale, max(_NOTHING, 1e3 * rounding))
    inner = basis.T @ unit @ basis
    if not inner.size:
        return np.zeros(0), basis, scale
    slack = _slack(inner, rounding)

    def kept(value: complex) -> bool:
        over = value.real + (size * abs(value) ** 2 / 2 if discrete else 0.0)
        reach = slack * (1 + (size * abs(value) if discrete else 0.0))
        return bool(over >= -reach if grows else abs(over) <= reach)

    _, vectors, count = scipy.linalg.schur(inner.astype(complex), output="complex", sort=kept)
    form = vectors[:, :count].conj().T @ inner @ vectors[:, :count]
    chosen = vectors[:, :count]
    values = np.diag(form) * size + (1.0 if discrete else 0.0)
    return values, basis @ chosen, scale


def _slack(inner: np.ndarray, rounding: float) -> float:
    """How far rounding moves an eigenvalue: more where left and right vectors are orthogonal."""
    _, left, right = scipy.linalg.eig(inner, left=True)
    angle = np.abs((left.conj() * right).sum(axis=0)).min()
    return float(min(64 * rounding / max(angle, _EPS), max(_MOST_SLACK, 64 * rounding)))


def _unobservable(A: np.ndarray, C: np.ndarray, nothing: float) -> np.ndarray:
    """Orthonormal basis of the largest subspace of C's kernel that A maps into itself."""
    rows = np.abs(C).max(axis=1, keepdims=True)
    basis = _kernel(C / np.where(rows > 0, rows, 1.0), nothing)
    while basis.shape[1]:
        moved = A @ basis
        kernel = _kernel(moved - basis @ (basis.T @ moved), nothing)
        if kernel.shape[1] == basis.shape[1]:
            break
        basis = basis @ kernel
    return basis


def _kernel(M: np.ndarray, nothing: float) -> np.ndarray:
    _, sizes, vectors = np.linalg.svd(M)
    return np.asarray(vectors[int((sizes > nothing).sum()) :].T)


def _scale(A: np.ndarray, C: np.ndarray) -> np.ndarray:
    """Powers of two, by states, in which the entries of A and of each row of C are most alike.

    Least squares over the logarithms of what is not zero, so a change of units cancels. Unknown
    beside the states' units are that of time and of each row of C.
    """
    n, m = len(A), len(C)
    rows, logs = [], []
    for i, j in np.argwhere((A != 0) & ~np.eye(n, dtype=bool)):
        row = np.zeros(n + 1 + m)
        row[j], row[i], row[n] = 1, -1, 1
        rows.append(row)
        logs.append(-np.log2(abs(A[i, j])))
    for i, j in np.argwhere(C != 0):
        row = np.zeros(n + 1 + m)
        row[j], row[n + 1 + i] = 1, 1
        rows.append(row)
        logs.append(-np.log2(abs(C[i, j])))
    if not rows:
        return np.ones(n)
    return np.asarray(2.0 ** np.round(np.linalg.lstsq(np.array(rows), np.array(logs))[0][:n]))


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
