"""The noise parameters that differences of measurements determine, alone or only together."""

from dataclasses import dataclass

import numpy as np

from tuner.identifiability.windows import Differences

_NO_TRACE = 1e-8
"""Singular value, of columns of length 1, below which a combination leaves no trace: rounding
leaves 1e-12, and 1e-8 would take 10^16 samples to be seen."""
_NO_EFFECT = 1e-12
"""A noise parameter's effect, relative to that without cancellation, that counts as none."""
_ZERO = 1e-6  # share of a number in a combination that is rounding
_WINDOWS = 64


@dataclass(frozen=True, eq=False)
class Rank:
    """The rank of p unknown noise parameters.

    Attributes:
        rank: number of combinations that are determined.
        undetermined: combinations along which nothing that is measured changes, reduced so that
            each has as few numbers as can be, ``(p - rank, p)``.
    """

    rank: int
    undetermined: np.ndarray


def rank_of(differences: Differences) -> Rank:
    """The rank of the map from the noise's numbers to the covariances of differences."""
    few = differences.M[1:, :_WINDOWS]
    p = len(few)
    columns = few.reshape(p, int(np.prod(few.shape[1:]))).T
    sizes = np.linalg.norm(columns, axis=0)
    silent = sizes <= _NO_EFFECT * differences.sizes
    units = np.where(silent, 1.0, sizes)
    _, values, Vt = np.linalg.svd(
        np.vstack([columns * ~silent / units, np.zeros((p, p))]), full_matrices=False
    )
    rank = int((values > _NO_TRACE).sum())
    # In multiples of the value that has an effect of size 1, reduced, and back.
    return Rank(rank, _reduced(Vt[rank:]) / units)


def _reduced(rows: np.ndarray) -> np.ndarray:
    """Reduced row echelon form by complete pivoting, rounding left out."""
    left, done = rows.copy(), []
    for i in range(len(left)):
        rest = np.abs(left[i:])
        at, column = np.unravel_index(rest.argmax(), rest.shape)
        left[[i, i + at]] = left[[i + at, i]]
        left[i] /= left[i, column]
        for j in range(len(left)):
            if j != i:
                left[j] -= left[j, column] * left[i]
        done.append(column)
    return np.where(np.abs(left) > _ZERO, left, 0.0)


def sentences(rank: Rank, names: tuple[str, ...], fixable: tuple[str, ...]) -> tuple[str, ...]:
    """Undetermined parameters, a sentence for each group that can replace each other.

    Args:
        rank: of the numbers.
        names: of the parameters.
        fixable: those of the names, or of their parameters, that can be held at a value.

    >>> only_sum = Rank(1, np.array([[1.0, -1.0]]))
    >>> sentences(only_sum, ("Q22", "R"), ("", "R"))[0].partition(": ")[2]
    'only Q22 + R is determined; fix one, --fix R=VALUE'
    """
    left = set(range(len(rank.undetermined)))
    sentences = []
    while left:
        group, members = {left.pop()}, set[int]()
        while True:
            members = {int(i) for g in group for i in np.flatnonzero(rank.undetermined[g])}
            more = {g for g in left if set(np.flatnonzero(rank.undetermined[g])) & members}
            if not more:
                break
            group |= more
            left -= more
        among = sorted(members)
        null = rank.undetermined[sorted(group)][:, among]
        sentences.append(_sentence([names[i] for i in among], null, [fixable[i] for i in among]))
    return tuple(sentences)


def _sentence(names: list[str], null: np.ndarray, fixable: list[str]) -> str:
    given = [name for name in fixable if name]
    hint = f", --fix {given[-1]}=VALUE" if given else ""
    if len(names) == 1:
        fix = f"; fix it{hint}" if given else ""
        return f"{names[0]} leaves no trace in what is measured: it is not determined{fix}"
    together = f"{', '.join(names[:-1])} and {names[-1]}"
    if len(null) == len(names):
        return f"{together} leave no trace in what is measured: none is determined; fix them{hint}"
    combinations = [_combination(names, row) for row in _determined(null)]
    only = (
        f"only {' and '.join(combinations)} {'is' if len(combinations) == 1 else 'are'} determined"
    )
    count = "one" if len(null) == 1 else str(len(null))
    return f"{together} cannot be told apart by what is measured: {only}; fix {count}{hint}"


def _determined(null: np.ndarray) -> np.ndarray:
    """Combinations that do not change along the rows of null, reduced."""
    sizes = np.abs(null).max(axis=0)
    _, _, Vt = np.linalg.svd(null / sizes)
    return np.asarray(_reduced(Vt[len(null) :]) / sizes)


def _combination(names: list[str], row: np.ndarray) -> str:
    first = row[np.flatnonzero(row)[0]]
    words = ""
    for name, number in zip(names, row / first, strict=True):
        if not number:
            continue
        size = abs(number)
        term = name if abs(size - 1) < _ZERO else f"{size:.4g} {name}"
        words += (f" {'-' if number < 0 else '+'} " if words else "") + term
    return words
