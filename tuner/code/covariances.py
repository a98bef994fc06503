"""Covariances to try a filter's step on."""

import numpy as np

_HUGE, _BEYOND = 1 / 2, (1.0, 4.0)
"""Share of covariances that are huge, and by how many powers of ten more than the precision has."""
_UNEVEN = 1e-5
"""Difference of mirrored entries, over the largest, that rounding may make."""


def symmetric(near: np.ndarray) -> bool:
    """Whether all are symmetric matrices but for rounding, and not other numbers in a square."""
    if near.ndim != 3 or near.shape[1] != near.shape[2]:
        return False
    apart = np.abs(np.nan_to_num(near - near.transpose(0, 2, 1))).max(axis=(1, 2), initial=0)
    return bool((apart <= _UNEVEN * largest(near)).all())


def largest(near: np.ndarray) -> np.ndarray:
    """The largest number in each, or one."""
    size = np.abs(np.nan_to_num(near)).max(axis=tuple(range(1, near.ndim)), initial=0)
    return np.where(size > 0, size, 1.0)


def definite(draw: np.random.Generator, near: np.ndarray, far: np.ndarray) -> np.ndarray:
    """Matrices that stay symmetric and definite where the given ones are."""
    count, n = near.shape[:2]
    scales = 10 ** (0.5 * far[:, None] * draw.uniform(-1, 1, (count, n)))
    root = draw.normal(size=(count, n, n)) * np.sqrt(largest(near) / n)[:, None, None]
    more = root @ root.transpose(0, 2, 1) * draw.choice([0.0, 0.1, 1.0], count)[:, None, None]
    whole = near + more * (far[:, None, None] > 0)
    return np.asarray(whole * scales[:, :, None] * scales[:, None, :])


def some_huge(
    draw: np.random.Generator, near: np.ndarray, values: np.ndarray, digits: float
) -> np.ndarray:
    """Matrices of which some have variances alone, beyond what the precision has digits for.

    All noise of measurements is as small beside them as their rounding. They have no other entries,
    which would be rounding alone after a measurement.

    Args:
        draw: a generator.
        near: given ones, ``(count, n, n)``.
        values: those that the others have.
        digits: powers of ten that the precision has.
    """
    count = len(near)
    by = 10 ** (digits + draw.uniform(*_BEYOND, count))
    huge = draw.random(count) < _HUGE
    alone = near * np.eye(near.shape[1]) * by[:, None, None]
    return np.where(huge[:, None, None], alone, values)
