"""Differences of neighbouring measurements, which do not depend on a record's initial state.

P measurements of a linear model are z = O x + e, with the state x before the first of them and
noise e. A basis A of all rows with A O = 0 leaves differences r = A z that noise alone causes, of
the covariance A (C_0 + sum of theta_i C_i) A': linear in what is unknown of the noise.

Source: Dunik, Kost and Straka, Design of measurement difference autocovariance method for
estimation of process and measurement noise covariances, Automatica 90, 2018. The differences of
longer windows hold no more than those of 2 n + 1 instants and how they are correlated.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tuner.identifiability.linear_form import NoiseModel
from tuner.identifiability.noise import NoModelError

_ROWS = 48
"""Measurements of a window, so that slow states show; more where the model has many states."""
_MOST_ROWS = 160
_MEMORY = 4e6
"""Memory limit for the noise of all windows' steps, in numbers."""
_MOST = 8000
"""Measurements in all windows together."""
_GAP = 2000
"""Longest gap, in samples, that a window may span."""
_LARGEST_NOISE_RATIO = 1e8
"""Largest noise of a window over the usual one, as of a gap of some tens of steps."""
_ROUNDING = 4e-16
_NONE = 1e-9  # of the largest singular value
_GROWTH = 1e3  # of a growing state's remainder in a window's differences


@dataclass(frozen=True, eq=False)
class Differences:
    """Differences of K windows, each of d numbers.

    Attributes:
        r: their values, ``(K, d)``.
        M: the covariance of what is known of the noise, and that of each unknown at 1,
            ``(1 + p, K, d, d)``.
        sizes: of the covariance that each unknown at 1 would have but for cancellation, ``(p,)``.
    """

    r: np.ndarray
    M: np.ndarray
    sizes: np.ndarray

    def windows(self, chosen: Sequence[int] | np.ndarray) -> "Differences":
        """The differences of some windows alone."""
        return Differences(self.r[chosen], self.M[:, chosen], self.sizes)


def differences(recordings: tuple[NoiseModel, ...], rows: int | None = None) -> Differences:
    """The differences of recordings, in windows that do not overlap.

    Args:
        recordings: of one model.
        rows: measurements in a window; None chooses.

    Raises:
        NoModelError: where no recording has more measurements than the model has states.
    """
    n, m = recordings[0].F.shape[-1], len(recordings[0].H)
    scale = scales(recordings)
    seen = [np.argwhere(np.isfinite(model.z)) for model in recordings]
    most = max(1, *map(len, seen))
    if rows is None:
        wanted = max(_ROWS, min(_MOST_ROWS, m * (2 * n + 1)))
        rows = min(-(-wanted // m) * m, most)
        lengths = np.array([len(each) for each in seen])
        if (lengths >= rows).sum() < len(seen) / 2:
            rows = max(int(np.median(lengths)), min(m * (2 * n + 1), most))
    while True:
        found = _of_rows(recordings, seen, rows, scale)
        if found is not None:
            return found
        if rows <= 2 * n + 1:
            raise NoModelError(
                f"the number of measurements in a recording is {most} at most, too few to "
                f"determine the noise of a model of order {n}"
            )
        rows = max(rows // 2, 2 * n + 1)


def scales(recordings: tuple[NoiseModel, ...]) -> np.ndarray:
    """A typical step of each measurement, ``(m,)``, so that its unit does not matter."""
    found = []
    for i in range(len(recordings[0].H)):
        columns = [model.z[:, i] / model.sigma[:, i] for model in recordings]
        there = [c[np.isfinite(c)] for c in columns]
        steps = np.concatenate([np.diff(c) for c in there])
        largest = np.abs(steps).max(initial=0.0)
        spread = largest * np.sqrt(np.mean((steps / largest) ** 2)) if largest else 0.0
        level = max((np.abs(c).max(initial=0.0) for c in there), default=0.0)
        found.append(spread or level or 1.0)
    return np.array(found)


def _of_rows(
    recordings: tuple[NoiseModel, ...], seen: list[np.ndarray], rows: int, scale: np.ndarray
) -> Differences | None:
    """The differences in windows of so many measurements; None without any window."""
    p, n = recordings[0].Q.shape[1], recordings[0].F.shape[-1]
    windows = [
        (model, places)
        for model, all_places in zip(recordings, seen, strict=True)
        for places in _consecutive(all_places, rows)
    ]
    most = batch(p, n, rows)
    if len(windows) > most:
        windows = [windows[i] for i in np.linspace(0, len(windows) - 1, most).astype(int)]
    if not windows:
        return None
    found = of_windows(windows, rows, scale)
    if found is None:
        return None
    differences, kept = found
    return differences.windows(np.flatnonzero(kept)) if kept.any() else None


def batch(p: int, n: int, rows: int) -> int:
    """Number of windows processed at once, for p noises, n states and so many measurements."""
    return max(int(min(_MOST, _MEMORY / (p * n * n), _MEMORY * 8 / (p * rows)) / rows), 1)


def _consecutive(places: np.ndarray, rows: int) -> list[np.ndarray]:
    """Windows ``(rows, 2)`` of sample and measurement, one after the other, without long gaps."""
    count = len(places) // rows
    windows = places[: count * rows].reshape(count, rows, 2)
    gaps = np.diff(windows[:, :, 0], axis=1).max(axis=1, initial=0)
    return list(windows[gaps <= _GAP])


def of_windows(
    windows: list[tuple[NoiseModel, np.ndarray]], rows: int, scale: np.ndarray
) -> tuple[Differences, np.ndarray] | None:
    """The differences of windows, and which windows are usable, ``(K,)`` of bool.

    Args:
        windows: each a recording, and sample and number of its measurements, ``(rows, 2)``.
        rows: measurements in each.
        scale: a size of each measurement, as :func:`scales`.

    Returns:
        None where the windows are too short for the model, or a state grows too much in them.
    """
    models = list({id(model): model for model, _ in windows}.values())
    place = {id(model): i for i, model in enumerate(models)}
    lane = np.array([place[id(model)] for model, _ in windows])
    at = np.stack([places for _, places in windows])  # (K, rows, 2)
    sigma = np.stack([models[i].sigma[tuple(w.T)] for i, w in zip(lane, at, strict=True)])
    z = np.stack([models[i].z[tuple(w.T)] for i, w in zip(lane, at, strict=True)])
    z = z / scale[at[:, :, 1]]
    first, alike = _alike(models, lane, at, sigma)
    lane, at, sigma = lane[first], at[first], sigma[first]
    steps, pushes = _steps(models, lane, at[:, :, 0])
    H = models[0].H[at[:, :, 1]] / scale[at[:, :, 1], None]  # (U, rows, n)
    onset, C, s, growth = _response(steps, pushes, H)
    R = models[0].R / np.outer(scale, scale)
    own = R[:, at[:, :, 1, None], at[:, None, :, 1]]  # (1 + p, U, rows, rows)
    together = at[:, :, 0, None] == at[:, None, :, 0]
    C = C + own * together * sigma[:, :, None] * sigma[:, None, :]
    if growth > _GROWTH:
        return None
    A = _annihilator(onset)
    if not A.shape[1]:
        return None
    free = z - s[alike]
    r = np.einsum("kda,ka->kd", A[alike], free)
    # Rounding residue of cancelled numbers is 0, or a straight line would have a noise.
    r = np.where(np.abs(r) > _ROUNDING * np.abs(free).max(axis=1, keepdims=True), r, 0.0)
    M = A @ C @ np.swapaxes(A, 1, 2)
    kept = np.isfinite(r).all(axis=1) & _of_usual_length(C, alike)
    return Differences(r, M[:, alike], _sizes(models, scale)), kept


def _alike(
    models: list[NoiseModel], lane: np.ndarray, at: np.ndarray, sigma: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Windows whose model is the same: the first of each kind ``(U,)``, each one's kind ``(K,)``.

    Where a known input moves the state, each window is of its own kind.
    """
    if any(model.push.any() for model in models):
        return np.arange(len(at)), np.arange(len(at))
    kinds: dict[tuple[Any, ...], int] = {}
    first: list[int] = []
    alike = np.zeros(len(at), int)
    for k, (i, places) in enumerate(zip(lane.tolist(), at, strict=True)):
        begin, end = places[0, 0], places[-1, 0]
        relative = places - (begin, 0)
        which = models[i].which[begin + 1 : end + 1]
        kind = i, relative.tobytes(), which.tobytes(), sigma[k].tobytes()
        if kind not in kinds:
            kinds[kind] = len(first)
            first.append(k)
        alike[k] = kinds[kind]
    return np.array(first), alike


def _of_usual_length(C: np.ndarray, alike: np.ndarray) -> np.ndarray:
    """Which windows are of usual length, ``(K,)``: noise over a long gap would hide all others."""
    sizes = np.abs(C).max(axis=(2, 3))[:, alike]
    usual = np.median(sizes, axis=1, keepdims=True)
    return np.asarray(
        (sizes <= _LARGEST_NOISE_RATIO * np.where(usual > 0, usual, np.inf)).all(axis=0)
    )


def _sizes(models: list[NoiseModel], scale: np.ndarray) -> np.ndarray:
    """Size of each parameter's share of n steps' measurements, without cancellation, ``(p,)``."""
    first = models[0]
    H = np.abs(first.H) / scale[:, None]
    F = _usual(first.F, first.which)
    reach, power = np.zeros_like(H), H
    for _ in range(len(F)):
        reach, power = reach + power, power @ F
    Q = _usual(first.Q, first.which)
    R = np.abs(first.R) / np.outer(scale, scale)
    whole = reach @ Q @ reach.T + R
    return np.asarray(whole[1:].max(axis=(1, 2)))


def _usual(steps: np.ndarray, which: np.ndarray) -> np.ndarray:
    """The median magnitude of each entry over a record's steps, of which few are unlike."""
    if (which == which[0]).all():
        return np.asarray(np.abs(steps[which[0]]))
    return np.asarray(np.median(np.abs(steps[which]), axis=0))


def _steps(
    models: list[NoiseModel], lane: np.ndarray, at: np.ndarray
) -> tuple[tuple[np.ndarray, np.ndarray], np.ndarray]:
    """The steps from each of a window's measurements to the next.

    Returns:
        Transitions ``(K, rows, n, n)`` and noise ``(K, rows, 1 + p, n, n)``, and what the known
        input adds, ``(K, rows, n)``; of the first row the identity and nothing.
    """
    K, rows = at.shape
    n, p = models[0].F.shape[-1], models[0].Q.shape[1]
    F = np.broadcast_to(np.eye(n), (K, rows, n, n)).copy()
    Q, s = np.zeros((K, rows, p, n, n)), np.zeros((K, rows, n))
    gaps = np.diff(at, axis=1, prepend=at[:, :1])
    which = [model.which for model in models]
    for step in range(1, int(gaps.max(initial=0)) + 1):
        k, a = np.nonzero(gaps >= step)
        sample = at[k, a] - gaps[k, a] + step
        for i, model in enumerate(models):
            own = lane[k] == i
            if not own.any():
                continue
            kk, aa, tt = k[own], a[own], sample[own]
            move = model.F[which[i][tt]]
            F[kk, aa] = move @ F[kk, aa]
            turned = move[:, None] @ Q[kk, aa] @ np.swapaxes(move, 1, 2)[:, None]
            Q[kk, aa] = turned + model.Q[which[i][tt]]
            s[kk, aa] = np.einsum("kij,kj->ki", move, s[kk, aa]) + model.push[tt]
    return (F, Q), s


def _response(
    steps: tuple[np.ndarray, np.ndarray], pushes: np.ndarray, H: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """The response of measurements to the state before, to the noise and to the known input.

    Returns:
        O of the module's words, ``(K, rows, n)``, covariances ``(1 + p, K, rows, rows)``, inputs
        ``(K, rows)``, and by how much a state grows over a window.
    """
    F, Q = steps
    K, rows, n, _ = F.shape
    p = Q.shape[2]
    onset, inputs = np.zeros((K, rows, n)), np.zeros((K, rows))
    C = np.zeros((p, K, rows, rows))
    through = np.broadcast_to(np.eye(n), (K, n, n))
    P, known = np.zeros((p, K, n, n)), np.zeros((K, n))
    crossed = np.zeros((p, K, n, rows))  # covariance of the state with each measurement before
    for a in range(rows):
        move, h = F[:, a], H[:, a]
        back = np.swapaxes(move, 1, 2)
        through = move @ through
        P = move @ P @ back + np.moveaxis(Q[:, a], 1, 0)
        known = np.einsum("kij,kj->ki", move, known) + pushes[:, a]
        crossed[..., :a] = move @ crossed[..., :a]
        crossed[..., a] = np.einsum("pkij,kj->pki", P, h)
        onset[:, a] = np.einsum("kj,kji->ki", h, through)
        row = np.einsum("kj,pkja->pka", h, crossed[..., : a + 1])
        C[:, :, a, : a + 1] = row
        C[:, :, : a + 1, a] = row
        inputs[:, a] = np.einsum("kj,kj->k", h, known)
    growth = (
        float(np.abs(np.linalg.eigvals(through)).max()) if np.isfinite(through).all() else np.inf
    )
    return onset, C, inputs, growth


def _annihilator(onset: np.ndarray) -> np.ndarray:
    """Orthonormal rows A ``(K, d, rows)`` with A O = 0, of the least d that all windows have."""
    sizes = np.abs(onset).max(axis=1, keepdims=True)
    U, sizes, _ = np.linalg.svd(onset / np.where(sizes > 0, sizes, 1.0))
    rank = int((sizes > _NONE * sizes[:, :1]).sum(axis=1).max())
    return np.swapaxes(U[:, :, rank:], 1, 2)
