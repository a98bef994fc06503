"""Cases whose derivatives mislead: kinks, staircases, ripples."""

import numpy as np

from benchmarks.statuses import functions as f
from benchmarks.statuses.case import LIMITED, MANY, POSITIVE, THRESHOLD, Case, stated
from benchmarks.statuses.drawn import Make, place, power_of_ten


def corner(rng: np.random.Generator, number: int) -> Case:
    """Absolute values."""
    c, at, w = power_of_ten(rng, -2, 1), place(rng), 10 ** rng.uniform(-1, 1, 2)
    space = (POSITIVE, LIMITED)[number % 2]
    return stated("kinked", "corner", number, f.corner, space, [c, *w, *at], c, at, smooth=False)


def largest(rng: np.random.Generator, number: int) -> Case:
    """The largest of two."""
    c, at = power_of_ten(rng, -2, 1), place(rng)
    numbers = [c, *at, rng.uniform(0.2, 2), rng.uniform(0.2, 2)]
    return stated("kinked", "largest", number, f.largest, POSITIVE, numbers, c, at, smooth=False)


def crease(rng: np.random.Generator, number: int) -> Case:
    """A crease with a parabola along its bottom."""
    c, at = power_of_ten(rng, -2, 1), place(rng, 1.5)
    numbers = [c, power_of_ten(rng, -0.5, 1), rng.uniform(-2, 2), power_of_ten(rng, -1, 0), *at]
    return stated("kinked", "crease", number, f.crease, POSITIVE, numbers, c, at, smooth=False)


def deviations(rng: np.random.Generator, number: int) -> Case:
    """A line of least absolute deviations: it passes through two of its points."""
    t = np.linspace(-1.0, 1.0, 12)
    y = rng.uniform(-1, 1) + rng.uniform(-1, 1) * t + 0.3 * rng.standard_t(3, 12)
    i, j = np.triu_indices(12, 1)
    slopes = (y[j] - y[i]) / (t[j] - t[i])
    lines = np.stack([y[i] - slopes * t[i], slopes], axis=1)
    lines = lines[(np.abs(lines) < 4).all(axis=1)]
    found = f.deviations(np, lines, y)
    best, at = float(found.min()), lines[found.argmin()]
    return stated("kinked", "deviations", number, f.deviations, LIMITED, y, best, at, smooth=False)


def worst(rng: np.random.Generator, number: int) -> Case:
    """The largest error of an exponential."""
    c, rate, n = power_of_ten(rng, -3, 0), power_of_ten(rng, -1, 0.3), power_of_ten(rng, -1, 1)
    at = np.log([rate, n])
    return stated("kinked", "worst", number, f.worst, POSITIVE, [c, rate, n], c, at, smooth=False)


def many_corners(rng: np.random.Generator, number: int) -> Case:
    """Five parameters, absolute values."""
    c, at, w = power_of_ten(rng, -1, 1), rng.uniform(-2.5, 2.5, 5), 10 ** rng.uniform(-0.5, 0.5, 5)
    numbers = [c, *w, *at]
    return stated(
        "kinked", "many corners", number, f.many_corners, MANY, numbers, c, at, smooth=False
    )


def rounded(rng: np.random.Generator, number: int) -> Case:
    """A rounded bowl."""
    c, at = power_of_ten(rng, -1, 1), place(rng)
    numbers = [c, power_of_ten(rng, -2, 0), power_of_ten(rng, -0.5, 0.5), *at]
    return stated("staircase", "rounded", number, f.rounded, POSITIVE, numbers, c, at, smooth=False)


def counted(rng: np.random.Generator, number: int) -> Case:
    """A settling time: the best rate makes one more sample settle."""
    step, slope = rng.uniform(0.02, 0.2), rng.uniform(0.01, 0.2)
    n = power_of_ten(rng, -0.5, 0.5)
    rates = np.log(20) / f.T[1:] * (1 + 1e-9)
    points = np.log(np.stack([rates[rates < 99], np.full((rates < 99).sum(), n)], axis=1))
    numbers = np.array([step, slope, n])
    found = f.counted(np, points, numbers)
    best, at = float(found.min()), points[found.argmin()]
    space = (POSITIVE, THRESHOLD)[number % 2]
    kind = ("counted", "counted, declared")[number % 2]
    return stated("staircase", kind, number, f.counted, space, numbers, best, at, smooth=False)


def floors(rng: np.random.Generator, number: int) -> Case:
    """Whole steps."""
    c, at, w = power_of_ten(rng, -1, 1), place(rng), rng.uniform(0.7, 4, 2)
    return stated(
        "staircase", "floors", number, f.floors, LIMITED, [c, *w, *at], c, at, smooth=False
    )


def confused(rng: np.random.Generator, number: int) -> Case:
    """A threshold between two heaps of samples."""
    c, k, n = power_of_ten(rng, -2, 0), power_of_ten(rng, -1, 0.5), rng.uniform(-2, 2)
    middle = rng.uniform(-1.5, 1.5)
    heaps = np.where(np.arange(40) % 2 == 0, middle + 0.8, middle - 0.8)
    x = np.exp(heaps + 0.6 * rng.standard_normal(40))
    cuts = np.log(np.sort(x))
    middles = np.append((cuts[:-1] + cuts[1:]) / 2, [cuts[0] - 0.5, cuts[-1] + 0.5])
    points = np.stack([middles, np.full(len(middles), n)], axis=1)
    numbers = np.array([c, k, n, *x])
    found = f.confused(np, points, numbers)
    best, at = float(found.min()), points[found.argmin()]
    declared = number % 2 == 0
    space, kind = (THRESHOLD, "confused, declared") if declared else (POSITIVE, "confused")
    return stated("staircase", kind, number, f.confused, space, numbers, best, at, smooth=False)


def ripple(rng: np.random.Generator, number: int) -> Case:
    """A bowl with ripples."""
    c, at = power_of_ten(rng, -1, 1), place(rng)
    numbers = [c, power_of_ten(rng, -6, -4.3), power_of_ten(rng, 2, 4), *at]
    return stated("misleading", "ripple", number, f.ripple, POSITIVE, numbers, c, at, smooth=False)


def seam(rng: np.random.Generator, number: int) -> Case:
    """Two branches."""
    c, at = power_of_ten(rng, -1, 1), place(rng)
    numbers = [c, power_of_ten(rng, 0, 2), *at]
    return stated("misleading", "seam", number, f.seam, POSITIVE, numbers, c, at)


def held(rng: np.random.Generator, number: int) -> Case:
    """Half a gradient."""
    c, at = power_of_ten(rng, -1, 1), place(rng)
    return stated("misleading", "held", number, f.held, POSITIVE, [c, *at], c, at, smooth=False)


def cone(rng: np.random.Generator, number: int) -> Case:
    """A distance."""
    c, at = power_of_ten(rng, -1, 1), place(rng)
    numbers = [c, power_of_ten(rng, -1, 1), *at]
    return stated("misleading", "cone", number, f.cone, POSITIVE, numbers, c, at, smooth=False)


def plan() -> tuple[tuple[Make, int], ...]:
    """Number of cases of each kind."""
    return (
        (corner, 8),
        (largest, 7),
        (crease, 7),
        (deviations, 6),
        (worst, 6),
        (many_corners, 3),
        (rounded, 10),
        (counted, 12),
        (floors, 6),
        (confused, 8),
        (ripple, 7),
        (seam, 5),
        (held, 4),
        (cone, 5),
    )
