"""The cases of plain functions by family: random numbers, and optima that follow from them."""

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np

from benchmarks.statuses import functions as f
from benchmarks.statuses.case import EDGE, LIMITED, MANY, POSITIVE, THRESHOLD, WIDE, Case, stated

Make: TypeAlias = Callable[[np.random.Generator, int], Case]
"""From random numbers and the case's number to the case."""


def _power_of_ten(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10 ** rng.uniform(low, high))


def _place(rng: np.random.Generator, reach: float = 2.5) -> np.ndarray:
    return rng.uniform(-reach, reach, 2)


def flat(across: tuple[float, float] | None, *, told: bool) -> Make:
    """A ridge, exact or with what is across it between two powers of ten."""

    def make(rng: np.random.Generator, number: int) -> Case:
        c, k = _power_of_ten(rng, -3, 3), _power_of_ten(rng, -0.5, 1.5)
        s = rng.choice([0.0, -1.0, 1.0, rng.uniform(-2, 2)])
        at, e = _place(rng, 1.5), 0.0 if across is None else _power_of_ten(rng, *across)
        numbers = [c, k, s, at[0] + s * at[1], e, at[1] - s * at[0]]
        kind = "ridge" if across is None else "near ridge" if told else "weak ridge"
        return stated("flat", kind, number, f.ridge, POSITIVE, numbers, c, at, flat=told)

    return make


def bent(rng: np.random.Generator, number: int) -> Case:
    """A flat valley along a curve."""
    numbers = [_power_of_ten(rng, -2, 2), _power_of_ten(rng, 0, 1), rng.uniform(0.5, 1.5)]
    return stated("flat", "bent", number, f.bent, LIMITED, numbers, numbers[0], [0, 0], flat=None)


def corner(rng: np.random.Generator, number: int) -> Case:
    """Absolute values."""
    c, at, w = _power_of_ten(rng, -2, 1), _place(rng), 10 ** rng.uniform(-1, 1, 2)
    space = (POSITIVE, LIMITED)[number % 2]
    return stated("kinked", "corner", number, f.corner, space, [c, *w, *at], c, at, smooth=False)


def largest(rng: np.random.Generator, number: int) -> Case:
    """The largest of two."""
    c, at = _power_of_ten(rng, -2, 1), _place(rng)
    numbers = [c, *at, rng.uniform(0.2, 2), rng.uniform(0.2, 2)]
    return stated("kinked", "largest", number, f.largest, POSITIVE, numbers, c, at, smooth=False)


def crease(rng: np.random.Generator, number: int) -> Case:
    """A crease with a parabola along its bottom."""
    c, at = _power_of_ten(rng, -2, 1), _place(rng, 1.5)
    numbers = [c, _power_of_ten(rng, -0.5, 1), rng.uniform(-2, 2), _power_of_ten(rng, -1, 0), *at]
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
    c, rate, n = _power_of_ten(rng, -3, 0), _power_of_ten(rng, -1, 0.3), _power_of_ten(rng, -1, 1)
    at = np.log([rate, n])
    return stated("kinked", "worst", number, f.worst, POSITIVE, [c, rate, n], c, at, smooth=False)


def rounded(rng: np.random.Generator, number: int) -> Case:
    """A rounded bowl."""
    c, at = _power_of_ten(rng, -1, 1), _place(rng)
    numbers = [c, _power_of_ten(rng, -2, 0), _power_of_ten(rng, -0.5, 0.5), *at]
    return stated("staircase", "rounded", number, f.rounded, POSITIVE, numbers, c, at, smooth=False)


def counted(rng: np.random.Generator, number: int) -> Case:
    """A settling time: the best rate makes one more sample settle."""
    step, slope = rng.uniform(0.02, 0.2), rng.uniform(0.01, 0.2)
    n = _power_of_ten(rng, -0.5, 0.5)
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
    c, at, w = _power_of_ten(rng, -1, 1), _place(rng), rng.uniform(0.7, 4, 2)
    return stated(
        "staircase", "floors", number, f.floors, LIMITED, [c, *w, *at], c, at, smooth=False
    )


def confused(rng: np.random.Generator, number: int) -> Case:
    """A threshold between two heaps of samples."""
    c, k, n = _power_of_ten(rng, -2, 0), _power_of_ten(rng, -1, 0.5), rng.uniform(-2, 2)
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


def saddle(rng: np.random.Generator, number: int) -> Case:
    """Two equal wells, begun between them: with one start or with four."""
    c, n = _power_of_ten(rng, -1, 1), rng.choice([0.0, rng.uniform(-2, 2)])
    w = rng.uniform(0.5, 2)
    numbers = [c, _power_of_ten(rng, -0.5, 1), 0.0, w, 0.0, n]
    starts = (1, 4)[number % 2]
    return stated(
        "multimodal", "saddle", number, f.double, LIMITED, numbers, c, [w, n], starts=starts
    )


def crossed(rng: np.random.Generator, number: int) -> Case:
    """Two equal wells along a diagonal, begun at the saddle between them."""
    c, e = _power_of_ten(rng, -1, 1), rng.uniform(0.01, 0.5)
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
    c, h, angle = _power_of_ten(rng, -0.5, 1), _power_of_ten(rng, -0.5, 1), rng.uniform(0, np.pi)
    at = -0.75 * np.array([np.cos(angle), np.sin(angle)])
    best = c - 27 / 256 * h
    numbers, starts = [c, h, angle, 0.0, 0.0], (1, 4)[number % 2]
    return stated(
        "multimodal", "monkey", number, f.monkey, LIMITED, numbers, best, at, starts=starts
    )


def inflection(rng: np.random.Generator, number: int) -> Case:
    """Begun where a slope is level."""
    c, h, n = _power_of_ten(rng, 0, 1), _power_of_ten(rng, -0.5, 0.5), rng.choice([0.0, 1.0])
    numbers, starts = [c, h, 0.0, n], (1, 4)[number % 2]
    best, at = c - 27 / 256 * h, [-0.75, n]
    return stated(
        "multimodal", "inflection", number, f.inflection, LIMITED, numbers, best, at, starts=starts
    )


def edge_saddle(rng: np.random.Generator, number: int) -> Case:
    """Begun on a limit where it is level and falls inwards."""
    c, h, w = _power_of_ten(rng, -1, 1), _power_of_ten(rng, -0.5, 0.5), rng.uniform(1, 4)
    numbers = [c, h, -4.0, w, 0.0, rng.uniform(-2, 2)]
    at = [-4 + w, numbers[5]]
    return stated("limits", "edge saddle", number, f.double, EDGE, numbers, c, at, starts=1)


def tilted(rng: np.random.Generator, number: int) -> Case:
    """Two wells of different depth."""
    s, w = rng.uniform(-1, 1), rng.uniform(0.8, 2)
    h, n = _power_of_ten(rng, -0.5, 0.5), rng.uniform(-2, 2)
    t = rng.uniform(0.1, 0.8) * h * rng.choice([-1, 1])
    numbers = [_power_of_ten(rng, 0, 1), h, s, w, t, n]
    return stated("multimodal", "tilted", number, f.double, LIMITED, numbers, several=True)


def waves(rng: np.random.Generator, number: int) -> Case:
    """Many wells."""
    c, at = _power_of_ten(rng, -1, 1), _place(rng, 2)
    numbers = [c, rng.uniform(0.1, 0.5), rng.uniform(0.1, 1), rng.uniform(2, 5), *at]
    return stated("multimodal", "waves", number, f.waves, LIMITED, numbers, c, at, several=True)


def wells(rng: np.random.Generator, number: int) -> Case:
    """Three wells in a plain."""
    each = [[rng.uniform(0.2, 1), *rng.uniform(-3, 3, 2), rng.uniform(0.4, 1.0)] for _ in range(3)]
    numbers = [_power_of_ten(rng, 0.1, 1), *np.ravel(each)]
    return stated("multimodal", "wells", number, f.wells, LIMITED, numbers, several=True)


def scaled(rng: np.random.Generator, number: int) -> Case:
    """Values of 1e-20 to 1e20 and a condition of up to 1e8."""
    c, at = 10.0 ** rng.choice([-20, -10, 0, 10, 20]), _place(rng)
    k, condition = _power_of_ten(rng, -1, 4), _power_of_ten(rng, 4, 8)
    angle = rng.choice([0.0, rng.uniform(0, np.pi)])
    numbers = [c, c, k, k / condition, angle, *at, 1.0]
    return stated("ill-scaled", "scaled", number, f.turned, POSITIVE, numbers, c, at, flat=None)


def many(rng: np.random.Generator, number: int) -> Case:
    """Five parameters."""
    c, at = _power_of_ten(rng, -2, 2), rng.uniform(-2.5, 2.5, 5)
    numbers = [c, _power_of_ten(rng, 0, 1), _power_of_ten(rng, 0, 3), *at]
    return stated("ill-scaled", "many", number, f.many, MANY, numbers, c, at, flat=None)


def many_corners(rng: np.random.Generator, number: int) -> Case:
    """Five parameters, absolute values."""
    c, at, w = _power_of_ten(rng, -1, 1), rng.uniform(-2.5, 2.5, 5), 10 ** rng.uniform(-0.5, 0.5, 5)
    numbers = [c, *w, *at]
    return stated(
        "kinked", "many corners", number, f.many_corners, MANY, numbers, c, at, smooth=False
    )


def shifted(low: float, high: float, kind: str, sign: tuple[float, ...]) -> Make:
    """A bowl whose least value is of a sign and size; 0 is a size as well."""

    def make(rng: np.random.Generator, number: int) -> Case:
        offset, at = rng.choice(sign) * _power_of_ten(rng, low, high), _place(rng)
        k, condition = _power_of_ten(rng, -0.5, 1), _power_of_ten(rng, 0, 2)
        numbers = [offset, 1.0, k, k / condition, rng.uniform(0, np.pi), *at, 1.0]
        flat = None if abs(offset) > 1 else False
        return stated(
            "ill-scaled", kind, number, f.turned, POSITIVE, numbers, offset, at, flat=flat
        )

    return make


def banana(rng: np.random.Generator, number: int) -> Case:
    """Rosenbrock's valley."""
    c, m = _power_of_ten(rng, -2, 2), rng.uniform(-1.5, 1.5)
    numbers = [c, _power_of_ten(rng, 1, 3), m]
    return stated("ill-scaled", "banana", number, f.banana, LIMITED, numbers, c, [m, m**2])


def wide(rng: np.random.Generator, number: int) -> Case:
    """A bowl in numbers of six digits, for which a step of 1 is nothing."""
    c, at = _power_of_ten(rng, -2, 2), _place(rng)
    numbers = [c, c, 1.0, rng.uniform(0.1, 1), rng.uniform(0, np.pi), *at, 1e5]
    return stated("ill-scaled", "wide", number, f.turned, WIDE, numbers, c, 1e5 * at, flat=None)


def at_limit(rng: np.random.Generator, number: int) -> Case:
    """Limits that hold the optimum, along one coordinate or both."""
    c, m, n = _power_of_ten(rng, 0, 2), rng.uniform(-3, 3), rng.uniform(-3, 3)
    sides, g = rng.choice([-1.0, 1.0], 2), 10 ** rng.uniform(-1, 1, 2)
    both = number % 3 == 0
    first = [5 * g[0] * sides[0], 0.0, m]
    second = [5 * g[1] * sides[1], 0.0, n] if both else [0.0, g[1], n]
    at = np.array([-4 * sides[0], -4 * sides[1] if both else n])
    numbers = np.array([c + 50 * g[0] + 50 * g[1], *first, *second])
    best = float(f.sliding(np, at, numbers))
    return stated("limits", "at a limit", number, f.sliding, LIMITED, numbers, best, at)


def beyond(rng: np.random.Generator, number: int) -> Case:
    """A search box that leaves out the optimum."""
    c, k = _power_of_ten(rng, -1, 1), _power_of_ten(rng, -1, 1)
    side, n, end = rng.choice([-1.0, 1.0]), rng.uniform(-2, 2), float(np.log(100))
    numbers = [c, 0.0, k, side * (end + rng.uniform(0.3, 2)), 0.0, k, n]
    at = np.array([side * end, n])
    best = float(f.sliding(np, at, np.array(numbers)))
    return stated("limits", "beyond", number, f.sliding, POSITIVE, numbers, best, at, beyond=True)


def fading(rng: np.random.Generator, number: int) -> Case:
    """A fall towards a limit that no point reaches."""
    numbers = np.array([_power_of_ten(rng, -3, -1), _power_of_ten(rng, -1, 1), rng.uniform(-2, 2)])
    at = np.array([np.log(100), numbers[2]])
    best = float(f.fading(np, at, numbers))
    return stated(
        "limits", "fading", number, f.fading, POSITIVE, numbers, best, at, beyond=True, flat=None
    )


def inside(rng: np.random.Generator, number: int) -> Case:
    """An optimum just within the search box."""
    c, k = _power_of_ten(rng, -1, 1), _power_of_ten(rng, -0.5, 1)
    side, n, end = rng.choice([-1.0, 1.0]), rng.uniform(-2, 2), float(np.log(100))
    at = np.array([side * (end - rng.uniform(0.05, 0.5)), n])
    numbers = [c, 0.0, k, at[0], 0.0, k, n]
    return stated("limits", "inside", number, f.sliding, POSITIVE, numbers, c, at)


def quartic(rng: np.random.Generator, number: int) -> Case:
    """Powers of four and six: no curvature at the optimum."""
    c, at = _power_of_ten(rng, -2, 2), _place(rng)
    first, second = ((2, 2), (2, 1), (3, 2))[number % 3]
    angle = rng.choice([0.0, rng.uniform(0, np.pi)])
    numbers = [c, first, second, angle, *at, _power_of_ten(rng, -0.5, 1)]
    return stated("quartic", "power", number, f.power, POSITIVE, numbers, c, at)


def round_quartic(rng: np.random.Generator, number: int) -> Case:
    """The square of a bowl."""
    c, at = _power_of_ten(rng, -2, 2), _place(rng)
    numbers = [c, _power_of_ten(rng, -0.5, 1), *at]
    return stated("quartic", "round", number, f.round_quartic, POSITIVE, numbers, c, at)


def ripple(rng: np.random.Generator, number: int) -> Case:
    """A bowl with ripples."""
    c, at = _power_of_ten(rng, -1, 1), _place(rng)
    numbers = [c, _power_of_ten(rng, -6, -4.3), _power_of_ten(rng, 2, 4), *at]
    return stated("misleading", "ripple", number, f.ripple, POSITIVE, numbers, c, at, smooth=False)


def seam(rng: np.random.Generator, number: int) -> Case:
    """Two branches."""
    c, at = _power_of_ten(rng, -1, 1), _place(rng)
    numbers = [c, _power_of_ten(rng, 0, 2), *at]
    return stated("misleading", "seam", number, f.seam, POSITIVE, numbers, c, at)


def held(rng: np.random.Generator, number: int) -> Case:
    """Half a gradient."""
    c, at = _power_of_ten(rng, -1, 1), _place(rng)
    return stated("misleading", "held", number, f.held, POSITIVE, [c, *at], c, at, smooth=False)


def cone(rng: np.random.Generator, number: int) -> Case:
    """A distance."""
    c, at = _power_of_ten(rng, -1, 1), _place(rng)
    numbers = [c, _power_of_ten(rng, -1, 1), *at]
    return stated("misleading", "cone", number, f.cone, POSITIVE, numbers, c, at, smooth=False)


def squares(rng: np.random.Generator, number: int) -> Case:
    """An exponential without noise."""
    rate, n, c = _power_of_ten(rng, -1, 0.3), _power_of_ten(rng, -1, 1), _power_of_ten(rng, -6, 6)
    at = np.log([rate, n])
    return stated("perfect", "squares", number, f.squares, POSITIVE, [rate, n, c], 0.0, at)


def line(rng: np.random.Generator, number: int) -> Case:
    """A line without noise."""
    at, c = _place(rng), _power_of_ten(rng, -6, 6)
    return stated("perfect", "line", number, f.line, LIMITED, [*at, c], 0.0, at)


def begun(rng: np.random.Generator, number: int) -> Case:
    """A perfect fit that the search begins with."""
    c = _power_of_ten(rng, -6, 6)
    if number % 2:
        return stated("perfect", "begun", number, f.line, LIMITED, [0, 0, c], 0.0, [0, 0])
    return stated("perfect", "begun", number, f.squares, POSITIVE, [1, 1, c], 0.0, [0, 0])


def root(rng: np.random.Generator, number: int) -> Case:
    """A root of a mean square that vanishes."""
    at, c = _place(rng), _power_of_ten(rng, -6, 6)
    return stated("perfect", "root", number, f.root, LIMITED, [*at, c], 0.0, at, smooth=False)


def plan() -> Iterator[tuple[Make, int]]:
    """How many cases of which kind."""
    yield from ((flat(None, told=True), 10), (flat((-8, -5), told=True), 10))
    yield from ((flat((-1.5, -0.5), told=False), 8), (bent, 6))
    yield from ((corner, 8), (largest, 7), (crease, 7), (deviations, 6), (worst, 6))
    yield from ((many_corners, 3), (many, 4), (monkey, 3), (inflection, 3), (edge_saddle, 3))
    yield from ((rounded, 10), (counted, 12), (floors, 6), (confused, 8))
    yield from ((saddle, 6), (crossed, 6), (tilted, 8), (waves, 8), (wells, 6))
    yield from ((scaled, 10), (shifted(-3, 3, "negative", (-1.0,)), 8))
    yield from ((shifted(-9, -3, "crossing", (-1.0, 1.0)), 8), (banana, 6), (wide, 6))
    yield from ((at_limit, 10), (beyond, 6), (fading, 4), (inside, 6))
    yield from ((quartic, 12), (round_quartic, 8))
    yield from ((ripple, 7), (seam, 5), (held, 4), (cone, 5))
    yield from ((squares, 8), (line, 6), (begun, 4), (root, 6))
