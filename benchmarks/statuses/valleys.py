"""Cases of several wells, and those that begin between them."""

import numpy as np

from benchmarks.statuses import functions as f
from benchmarks.statuses.case import EDGE, LIMITED, Case, stated
from benchmarks.statuses.drawn import Make, place, power_of_ten


def saddle(rng: np.random.Generator, number: int) -> Case:
    """Two equal wells, begun between them: with one start or with four."""
    c, n = power_of_ten(rng, -1, 1), rng.choice([0.0, rng.uniform(-2, 2)])
    w = rng.uniform(0.5, 2)
    numbers = [c, power_of_ten(rng, -0.5, 1), 0.0, w, 0.0, n]
    starts = (1, 4)[number % 2]
    return stated(
        "multimodal", "saddle", number, f.double, LIMITED, numbers, c, [w, n], starts=starts
    )


def crossed(rng: np.random.Generator, number: int) -> Case:
    """Two equal wells along a diagonal, begun at the saddle between them."""
    c, e = power_of_ten(rng, -1, 1), rng.uniform(0.01, 0.5)
    at = rng.uniform(-2, 2, 2) if number % 3 == 0 else np.zeros(2)
    # On the diagonal (x^2 - 1)^2 + 2 e x^2 is least where x^2 = 1 - e.
    best, x = c + e**2 + 2 * e * (1 - e), np.sqrt(1 - e)
    starts = (1, 4)[number % 2]
    return stated(
        "multimodal",
        "crossed",
        number,
        f.crossed,
        LIMITED,
        [c, e, *at],
        best,
        at + x,
        starts=starts,
    )


def monkey(rng: np.random.Generator, number: int) -> Case:
    """Begun at a saddle that has no curvature: least 3/4 away along three ways."""
    c, h, angle = power_of_ten(rng, -0.5, 1), power_of_ten(rng, -0.5, 1), rng.uniform(0, np.pi)
    at = -0.75 * np.array([np.cos(angle), np.sin(angle)])
    best = c - 27 / 256 * h
    numbers, starts = [c, h, angle, 0.0, 0.0], (1, 4)[number % 2]
    return stated(
        "multimodal", "monkey", number, f.monkey, LIMITED, numbers, best, at, starts=starts
    )


def inflection(rng: np.random.Generator, number: int) -> Case:
    """Begun where a slope is level."""
    c, h, n = power_of_ten(rng, 0, 1), power_of_ten(rng, -0.5, 0.5), rng.choice([0.0, 1.0])
    numbers, starts = [c, h, 0.0, n], (1, 4)[number % 2]
    best, at = c - 27 / 256 * h, [-0.75, n]
    return stated(
        "multimodal", "inflection", number, f.inflection, LIMITED, numbers, best, at, starts=starts
    )


def edge_saddle(rng: np.random.Generator, number: int) -> Case:
    """Begun on a limit where it is level and falls inwards."""
    c, h, w = power_of_ten(rng, -1, 1), power_of_ten(rng, -0.5, 0.5), rng.uniform(1, 4)
    numbers = [c, h, -4.0, w, 0.0, rng.uniform(-2, 2)]
    at = [-4 + w, numbers[5]]
    return stated("limits", "edge saddle", number, f.double, EDGE, numbers, c, at, starts=1)


def tilted(rng: np.random.Generator, number: int) -> Case:
    """Two wells of different depth."""
    s, w = rng.uniform(-1, 1), rng.uniform(0.8, 2)
    h, n = power_of_ten(rng, -0.5, 0.5), rng.uniform(-2, 2)
    t = rng.uniform(0.1, 0.8) * h * rng.choice([-1, 1])
    numbers = [power_of_ten(rng, 0, 1), h, s, w, t, n]
    return stated("multimodal", "tilted", number, f.double, LIMITED, numbers, several=True)


def waves(rng: np.random.Generator, number: int) -> Case:
    """Many wells."""
    c, at = power_of_ten(rng, -1, 1), place(rng, 2)
    numbers = [c, rng.uniform(0.1, 0.5), rng.uniform(0.1, 1), rng.uniform(2, 5), *at]
    return stated("multimodal", "waves", number, f.waves, LIMITED, numbers, c, at, several=True)


def wells(rng: np.random.Generator, number: int) -> Case:
    """Three wells in a plain."""
    each = [[rng.uniform(0.2, 1), *rng.uniform(-3, 3, 2), rng.uniform(0.4, 1.0)] for _ in range(3)]
    numbers = [power_of_ten(rng, 0.1, 1), *np.ravel(each)]
    return stated("multimodal", "wells", number, f.wells, LIMITED, numbers, several=True)


def plan() -> tuple[tuple[Make, int], ...]:
    """Number of cases of each kind."""
    return (
        (monkey, 3),
        (inflection, 3),
        (edge_saddle, 3),
        (saddle, 6),
        (crossed, 6),
        (tilted, 8),
        (waves, 8),
        (wells, 6),
    )
