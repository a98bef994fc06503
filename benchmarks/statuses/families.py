"""Cases that are smooth by family: numbers at random, and optima that follow from them."""

import numpy as np

from benchmarks.statuses import functions as f
from benchmarks.statuses.case import LIMITED, MANY, POSITIVE, WIDE, Case, stated
from benchmarks.statuses.drawn import Make, place, power_of_ten


def flat(across: tuple[float, float] | None, *, told: bool) -> Make:
    """A ridge, exact or with a curvature across it between two powers of ten."""

    def make(rng: np.random.Generator, number: int) -> Case:
        c, k = power_of_ten(rng, -3, 3), power_of_ten(rng, -0.5, 1.5)
        s = rng.choice([0.0, -1.0, 1.0, rng.uniform(-2, 2)])
        at, e = place(rng, 1.5), 0.0 if across is None else power_of_ten(rng, *across)
        numbers = [c, k, s, at[0] + s * at[1], e, at[1] - s * at[0]]
        kind = "ridge" if across is None else "near ridge" if told else "weak ridge"
        return stated("flat", kind, number, f.ridge, POSITIVE, numbers, c, at, flat=told)

    return make


def bent(rng: np.random.Generator, number: int) -> Case:
    """A flat valley along a curve."""
    numbers = [power_of_ten(rng, -2, 2), power_of_ten(rng, 0, 1), rng.uniform(0.5, 1.5)]
    return stated("flat", "bent", number, f.bent, LIMITED, numbers, numbers[0], [0, 0], flat=None)


def scaled(rng: np.random.Generator, number: int) -> Case:
    """Values of 1e-20 to 1e20 and a condition of up to 1e8."""
    c, at = 10.0 ** rng.choice([-20, -10, 0, 10, 20]), place(rng)
    k, condition = power_of_ten(rng, -1, 4), power_of_ten(rng, 4, 8)
    angle = rng.choice([0.0, rng.uniform(0, np.pi)])
    numbers = [c, c, k, k / condition, angle, *at, 1.0]
    return stated("ill-scaled", "scaled", number, f.turned, POSITIVE, numbers, c, at, flat=None)


def many(rng: np.random.Generator, number: int) -> Case:
    """Five parameters."""
    c, at = power_of_ten(rng, -2, 2), rng.uniform(-2.5, 2.5, 5)
    numbers = [c, power_of_ten(rng, 0, 1), power_of_ten(rng, 0, 3), *at]
    return stated("ill-scaled", "many", number, f.many, MANY, numbers, c, at, flat=None)


def shifted(low: float, high: float, kind: str, sign: tuple[float, ...]) -> Make:
    """A bowl whose least value is of a sign and size; 0 is a size as well."""

    def make(rng: np.random.Generator, number: int) -> Case:
        offset, at = rng.choice(sign) * power_of_ten(rng, low, high), place(rng)
        k, condition = power_of_ten(rng, -0.5, 1), power_of_ten(rng, 0, 2)
        numbers = [offset, 1.0, k, k / condition, rng.uniform(0, np.pi), *at, 1.0]
        flat = None if abs(offset) > 1 else False
        return stated(
            "ill-scaled", kind, number, f.turned, POSITIVE, numbers, offset, at, flat=flat
        )

    return make


def banana(rng: np.random.Generator, number: int) -> Case:
    """Rosenbrock's valley."""
    c, m = power_of_ten(rng, -2, 2), rng.uniform(-1.5, 1.5)
    numbers = [c, power_of_ten(rng, 1, 3), m]
    return stated("ill-scaled", "banana", number, f.banana, LIMITED, numbers, c, [m, m**2])


def wide(rng: np.random.Generator, number: int) -> Case:
    """A bowl in numbers of six digits, for which a step of 1 is nothing."""
    c, at = power_of_ten(rng, -2, 2), place(rng)
    numbers = [c, c, 1.0, rng.uniform(0.1, 1), rng.uniform(0, np.pi), *at, 1e5]
    return stated("ill-scaled", "wide", number, f.turned, WIDE, numbers, c, 1e5 * at, flat=None)


def at_limit(rng: np.random.Generator, number: int) -> Case:
    """Limits that hold the optimum, along one coordinate or both."""
    c, m, n = power_of_ten(rng, 0, 2), rng.uniform(-3, 3), rng.uniform(-3, 3)
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
    c, k = power_of_ten(rng, -1, 1), power_of_ten(rng, -1, 1)
    side, n, end = rng.choice([-1.0, 1.0]), rng.uniform(-2, 2), float(np.log(100))
    numbers = [c, 0.0, k, side * (end + rng.uniform(0.3, 2)), 0.0, k, n]
    at = np.array([side * end, n])
    best = float(f.sliding(np, at, np.array(numbers)))
    return stated("limits", "beyond", number, f.sliding, POSITIVE, numbers, best, at, beyond=True)


def fading(rng: np.random.Generator, number: int) -> Case:
    """A fall towards a limit that no point reaches."""
    numbers = np.array([power_of_ten(rng, -3, -1), power_of_ten(rng, -1, 1), rng.uniform(-2, 2)])
    at = np.array([np.log(100), numbers[2]])
    best = float(f.fading(np, at, numbers))
    return stated(
        "limits", "fading", number, f.fading, POSITIVE, numbers, best, at, beyond=True, flat=None
    )


def inside(rng: np.random.Generator, number: int) -> Case:
    """An optimum just within the search box."""
    c, k = power_of_ten(rng, -1, 1), power_of_ten(rng, -0.5, 1)
    side, n, end = rng.choice([-1.0, 1.0]), rng.uniform(-2, 2), float(np.log(100))
    at = np.array([side * (end - rng.uniform(0.05, 0.5)), n])
    numbers = [c, 0.0, k, at[0], 0.0, k, n]
    return stated("limits", "inside", number, f.sliding, POSITIVE, numbers, c, at)


def quartic(rng: np.random.Generator, number: int) -> Case:
    """Powers of four and six: no curvature at the optimum."""
    c, at = power_of_ten(rng, -2, 2), place(rng)
    first, second = ((2, 2), (2, 1), (3, 2))[number % 3]
    angle = rng.choice([0.0, rng.uniform(0, np.pi)])
    numbers = [c, first, second, angle, *at, power_of_ten(rng, -0.5, 1)]
    return stated("quartic", "power", number, f.power, POSITIVE, numbers, c, at)


def round_quartic(rng: np.random.Generator, number: int) -> Case:
    """The square of a bowl."""
    c, at = power_of_ten(rng, -2, 2), place(rng)
    numbers = [c, power_of_ten(rng, -0.5, 1), *at]
    return stated("quartic", "round", number, f.round_quartic, POSITIVE, numbers, c, at)


def squares(rng: np.random.Generator, number: int) -> Case:
    """An exponential without noise."""
    rate, n, c = power_of_ten(rng, -1, 0.3), power_of_ten(rng, -1, 1), power_of_ten(rng, -6, 6)
    at = np.log([rate, n])
    return stated("perfect", "squares", number, f.squares, POSITIVE, [rate, n, c], 0.0, at)


def line(rng: np.random.Generator, number: int) -> Case:
    """A line without noise."""
    at, c = place(rng), power_of_ten(rng, -6, 6)
    return stated("perfect", "line", number, f.line, LIMITED, [*at, c], 0.0, at)


def begun(rng: np.random.Generator, number: int) -> Case:
    """A perfect fit that the search begins with."""
    c = power_of_ten(rng, -6, 6)
    if number % 2:
        return stated("perfect", "begun", number, f.line, LIMITED, [0, 0, c], 0.0, [0, 0])
    return stated("perfect", "begun", number, f.squares, POSITIVE, [1, 1, c], 0.0, [0, 0])


def root(rng: np.random.Generator, number: int) -> Case:
    """A root of a mean square that vanishes."""
    at, c = place(rng), power_of_ten(rng, -6, 6)
    return stated("perfect", "root", number, f.root, LIMITED, [*at, c], 0.0, at, smooth=False)


def plan() -> tuple[tuple[Make, int], ...]:
    """Number of cases of each kind."""
    return (
        (flat(None, told=True), 10),
        (flat((-8, -5), told=True), 10),
        (flat((-1.5, -0.5), told=False), 8),
        (bent, 6),
        (many, 4),
        (scaled, 10),
        (shifted(-3, 3, "negative", (-1.0,)), 8),
        (shifted(-9, -3, "crossing", (-1.0, 1.0)), 8),
        (banana, 6),
        (wide, 6),
        (at_limit, 10),
        (beyond, 6),
        (fading, 4),
        (inside, 6),
        (quartic, 12),
        (round_quartic, 8),
        (squares, 8),
        (line, 6),
        (begun, 4),
        (root, 6),
    )
