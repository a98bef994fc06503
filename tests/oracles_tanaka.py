"""Tanaka's possibilistic regression in exact fractions, by enumeration, and what it must give.

Nothing here uses the project. For data t (m, k), x (m), spreads e (m) >= 0 and 0 <= h < 1, with
t_j = (1, t_j1, .., t_jk), the intercept first:

    minimise    J = sum_j c'|t_j|
    subject to  |x_j - p't_j| <= (1 - h) (c'|t_j| - e_j),  c >= 0.

It is always feasible and bounded. The optimal face is the set of all optimal (p, c). It is the
sum of a polytope and of the directions (d, 0) with t_j'd = 0 for all j; if a regressor is zero in
every row, its c is free upwards as well. So the face is a bounded polytope if the columns
(1, t_1, .., t_k) are independent, and `fit` lists its vertices: every basic solution of the 2m
rows and c >= 0 is tried, with p = 0 in the columns that depend on earlier ones.

`unique`: the face is one point (p, c).

Tie-break: the point of the face with the least

    sum_j (x_j - p't_j)^2 + sum_i c_i^2,

both sums unweighted, i from 0, x_j the centres, e not used. It is the vector (x - Tp, c) nearest
the origin, so Tp and c are unique; p is if the columns are independent, and else the shortest p
is taken, which the notes do not ask for. The nearest point of a polytope is found over all sets
of affinely independent vertices: it lies in the interior of the simplex of one of them, at the
point of its affine hull that is nearest the origin.

For crisp data h scales the face, p unchanged and c(h) = c(0) / (1 - h). The tie-break point does
not follow: (1 - h)^2 weighs the residuals against c(0). `scaled`, |(1 - h) c|^2 in place of
|c|^2, gives p independent of h here too. Both are the same at h = 0, and in SETS.

`strip` is a second method for one regressor t >= 0. With y_j = x_j +- (1 - h) e_j the lines
p't +- (1 - h) c't lie above all y+ and below all y-, and J only depends on their values at the
mean time: they support the two hulls there, with slopes in intervals. If no pair of slopes has
c1 >= 0, c1 = 0 and the strip is parallel (Chebyshev); if none has c0 >= 0, which needs t > 0 in
all rows, c0 = 0 and the strip is proportional to t: the parallel one of (1/t, x/t).
"""

import math
from fractions import Fraction
from itertools import combinations
from operator import mul
from typing import NamedTuple

INF = math.inf


class Fit(NamedTuple):
    """Everything exact; intervals are (low, high) over the optimal face, or infinite.

    p and c are the tie-break point, the optimum itself if unique. vertices are those of the face,
    as (p, c), with p = 0 in dependent columns. above, below and spread are multipliers >= 0 of
    p't_j + (1-h) c'|t_j| >= x_j + (1-h) e_j, of (1-h) c'|t_j| - p't_j >= (1-h) e_j - x_j, c >= 0.
    """

    J: Fraction
    unique: bool
    p: tuple
    c: tuple
    p_range: tuple
    c_range: tuple
    vertices: tuple
    above: tuple
    below: tuple
    spread: tuple


class Set(NamedTuple):
    """A row of the table, h = 0, as printed. None: not unique; p and c are then the tie-break."""

    t: tuple
    x: tuple
    e: tuple
    J: str
    p: tuple
    c: tuple
    unique: bool


SETS = {
    "Tanaka, crisp": Set(
        (1, 2, 3, 4, 5),
        ("8", "6.4", "9.5", "13.5", "13"),
        ("0",) * 5,
        "103/12",
        ("89/20", "11/6"),
        ("103/60", "0"),
        True,
    ),
    "Tanaka, fuzzy": Set(
        (1, 2, 3, 4, 5),
        ("8", "6.4", "9.5", "13.5", "13"),
        ("1.8", "2.2", "2.6", "2.6", "2.4"),
        "77/4",
        ("77/20", "21/10"),
        ("77/20", "0"),
        True,
    ),
    "line": Set(
        (0, 1, 2, 3, 4),
        ("1", "3/2", "2", "5/2", "3"),
        ("0",) * 5,
        "0",
        ("1", "1/2"),
        ("0", "0"),
        True,
    ),
    "constant": Set(
        (0, 1, 2, 3, 4), ("7/10",) * 5, ("0",) * 5, "0", ("7/10", "0"), ("0", "0"), True
    ),
    "both signs": Set(
        (-2, -1, 0, 1, 2),
        ("3", "-1", "1/2", "1", "-2"),
        ("0",) * 5,
        "31/4",
        ("0", "-3/8"),
        ("1/2", "7/8"),
        True,
    ),
    "tie": Set((0, 0, 1), ("0", "1", "1/2"), ("0",) * 3, "3/2", ("1/2", "0"), ("1/2", "0"), False),
    "no rank": Set(
        (2, 2, 2), ("0", "1", "3"), ("0",) * 3, "9/2", ("3/10", "3/5"), ("3/10", "3/5"), False
    ),
}

# Not in the notes. Data opening like a wedge away from t = 0: c0 = 0 binds, and c1 does not.
WEDGE = Set((1, 2, 3, 4), ("0", "0", "0", "9"), ("0",) * 4, "10", ("-3", "2"), ("0", "1"), True)
# h: p and c of the tie-break for t = 0, 1, 2, x = 0, 1, 0; `scaled`: p as at h = 0
TIE_BY_H = {
    "0": (("3/8", "1/8"), ("3/8", "1/8")),
    "1/2": (("3/10", "1/5"), ("3/5", "2/5")),
}


def fractions(values):
    """Exact; decimals as text."""
    return [Fraction(v) for v in values]


def dot(a, b):
    """Sum of products."""
    return sum((u * v for u, v in zip(a, b, strict=True)), Fraction(0))


def columns(t):
    """Rows (1, t_j1, .., t_jk); t is (m, k), or (m) for one regressor."""
    return [[Fraction(1), *fractions(row if hasattr(row, "__len__") else [row])] for row in t]


def whole(row):
    """The row times the least common denominator, as integers, and that denominator."""
    scale = math.lcm(*(v.denominator for v in row))
    return [int(v * scale) for v in row], scale


def solve(rows):
    """The solution of n integer rows (a, b), a z = b, as numerators and a denominator > 0.

    Gauss and Jordan without fractions, after Bareiss: every division is exact. None if singular.
    """
    n, rows, previous = len(rows), [list(row) for row in rows], 1
    for i in range(n):
        pivot = next((r for r in range(i, n) if rows[r][i]), None)
        if pivot is None:
            return None
        rows[i], rows[pivot] = rows[pivot], rows[i]
        top = rows[i]
        for r in range(n):
            if r != i:
                f = rows[r][i]
                rows[r] = [
                    (top[i] * a - f * b) // previous for a, b in zip(rows[r], top, strict=True)
                ]
        previous = top[i]
    sign = 1 if previous > 0 else -1
    return [sign * row[n] for row in rows], sign * previous


def solved(rows):
    """The same for rows of fractions."""
    solution = solve([whole(row)[0] for row in rows])
    return None if solution is None else [Fraction(v, solution[1]) for v in solution[0]]


def independent(T):
    """Columns of T that do not depend on earlier ones, and a basis of the null space of T."""
    n, rows, kept = len(T[0]), [list(row) for row in T], []
    for i in range(n):
        done = len(kept)
        pivot = next((r for r in range(done, len(rows)) if rows[r][i]), None)
        if pivot is None:
            continue
        rows[done], rows[pivot] = rows[pivot], rows[done]
        rows[done] = [v / rows[done][i] for v in rows[done]]
        for r in range(len(rows)):
            if r != done:
                f = rows[r][i]
                rows[r] = [a - f * b for a, b in zip(rows[r], rows[done], strict=True)]
        kept.append(i)
    null = []
    for i in range(n):
        if i not in kept:
            d = [Fraction(int(j == i)) for j in range(n)]
            for r, j in enumerate(kept):
                d[j] = -rows[r][i]
            null.append(d)
    return kept, null


def shortest(p, null):
    """P plus the combination of the null vectors that makes it shortest."""
    if not null:
        return p
    weights = solved([[*(dot(a, b) for b in null), -dot(a, p)] for a in null])
    for w, d in zip(weights, null, strict=True):
        p = [a + w * b for a, b in zip(p, d, strict=True)]
    return p


def nearest(points):
    """Weights of the points whose mean, the point of their hull nearest the origin, they give."""
    n, best = len(points), None
    gram = [[dot(a, b) for b in points] for a in points]
    differences = [[a - b for a, b in zip(p, points[0], strict=True)] for p in points[1:]]
    largest = 1 + (len(independent(differences)[0]) if n > 1 else 0)
    one, none = Fraction(1), Fraction(0)
    for size in range(1, largest + 1):
        for chosen in combinations(range(n), size):
            rows = [[*(gram[i][j] for j in chosen), one, none] for i in chosen]
            w = solved([*rows, [one] * size + [none, one]])
            if w is None or min(w[:size]) < 0:
                continue
            value = -w[size]  # the squared distance: gram w + multiplier = 0, and w sums to 1
            if best is None or value < best[0]:
                best = value, dict(zip(chosen, w[:size], strict=True))
    return [best[1].get(i, none) for i in range(n)]


def constraints(T, x, h, e, kept):
    """Rows (a, b), a z >= b, of z = (p of the kept columns, s), s = (1 - h) c: 2m, then s >= 0."""
    rows = [
        [*(sign * row[i] for i in kept), *map(abs, row), sign * xj + (1 - h) * ej]
        for sign in (1, -1)
        for row, xj, ej in zip(T, x, e, strict=True)
    ]
    for i in range(len(T[0])):
        rows.append([Fraction(int(j == len(kept) + i)) for j in range(len(rows[0]))])
    return rows


def optima(rows, cost):
    """Least cost'z under the rows, and the optimal vertices z with their bases."""
    rows, (cost, scale) = [whole(row)[0] for row in rows], whole(cost)
    best, found = None, {}
    for basis in combinations(range(len(rows)), len(cost)):
        solution = solve([rows[i] for i in basis])
        if solution is None:
            continue
        z, d = solution
        value = Fraction(sum(map(mul, cost, z)), d * scale)
        if best is not None and value > best:
            continue
        if any(sum(map(mul, row, [*z, -d])) < 0 for row in rows):
            continue
        if value != best:
            best, found = value, {}
        found.setdefault(tuple(Fraction(v, d) for v in z), []).append(basis)
    return best, found


def multipliers(rows, cost, bases):
    """Those of the first basis that has none below 0: cost = sum_i y_i a_i. One has to exist."""
    for basis in bases:
        y = solved([[*(rows[i][j] for i in basis), cost[j]] for j in range(len(cost))])
        if min(y) >= 0:
            y = dict(zip(basis, y, strict=True))
            return [y.get(i, Fraction(0)) for i in range(len(rows))]
    raise AssertionError("no optimal basis has multipliers >= 0")


def fit(t, x, h=0, e=None, scaled=False):
    """The optimum; the number of bases tried is 2m + k + 1 over 2k + 2."""
    T, x, h = columns(t), fractions(x), Fraction(h)
    m, n = len(T), len(T[0])
    e = [Fraction(0)] * m if e is None else fractions(e)
    if not 0 <= h < 1 or min(e) < 0 or len(x) != m:
        raise ValueError("0 <= h < 1, e >= 0, one t for each x")
    kept, null = independent(T)
    rows = constraints(T, x, h, e, kept)
    total = [sum(map(abs, column)) for column in zip(*T, strict=True)]
    cost = [Fraction(0)] * len(kept) + total
    value, found = optima(rows, cost)

    vertices = []
    for z in found:
        p = [z[kept.index(i)] if i in kept else Fraction(0) for i in range(n)]
        vertices.append((tuple(p), tuple(v / (1 - h) for v in z[len(kept) :])))
    weigh = 1 - h if scaled else 1
    weights = nearest(
        [
            [xj - dot(p, row) for xj, row in zip(x, T, strict=True)] + [weigh * v for v in c]
            for p, c in vertices
        ]
    )
    ps, cs = (
        [list(column) for column in zip(*half, strict=True)] for half in zip(*vertices, strict=True)
    )
    free = [any(d[i] for d in null) for i in range(n)]
    y = multipliers(rows, cost, [basis for bases in found.values() for basis in bases])
    return Fit(
        J=value / (1 - h),
        unique=len(vertices) == 1 and not null,
        p=tuple(shortest([dot(weights, column) for column in ps], null)),
        c=tuple(dot(weights, column) for column in cs),
        p_range=tuple(
            (-INF, INF) if f else (min(v), max(v)) for v, f in zip(ps, free, strict=True)
        ),
        c_range=tuple((min(v), max(v) if w else INF) for v, w in zip(cs, total, strict=True)),
        vertices=tuple(vertices),
        above=tuple(v / (1 - h) for v in y[:m]),
        below=tuple(v / (1 - h) for v in y[m : 2 * m]),
        spread=tuple(y[2 * m :]),
    )


def proves(result, t, x, h=0, e=None):
    """(p, c) is feasible, costs J, and the multipliers show that nothing costs less."""
    T, x, h = columns(t), fractions(x), Fraction(h)
    e = [Fraction(0)] * len(x) if e is None else fractions(e)
    size = [[abs(v) for v in row] for row in T]
    total = [sum(column) for column in zip(*size, strict=True)]
    feasible = min(result.c) >= 0 and all(
        abs(xj - dot(result.p, row)) <= (1 - h) * (dot(result.c, b) - ej)
        for row, b, xj, ej in zip(T, size, x, e, strict=True)
    )
    both = list(zip(result.above, result.below, strict=True))
    signs = min(result.above + result.below + result.spread) >= 0
    in_p = all(
        sum((u - v) * w for (u, v), w in zip(both, column, strict=True)) == 0
        for column in zip(*T, strict=True)
    )
    in_c = all(
        (1 - h) * sum((u + v) * w for (u, v), w in zip(both, column, strict=True)) + s == g
        for column, s, g in zip(zip(*size, strict=True), result.spread, total, strict=True)
    )
    dual = sum(
        (u - v) * xj + (u + v) * (1 - h) * ej for (u, v), xj, ej in zip(both, x, e, strict=True)
    )
    return feasible and signs and in_p and in_c and dot(total, result.c) == result.J == dual


# ------------------------------------------------------------------- one regressor, t >= 0


class Strip(NamedTuple):
    """J and the intervals of p1 and c1 over the face; kind: hulls, parallel or proportional."""

    J: Fraction
    p1: tuple
    c1: tuple
    kind: str
    unique: bool


def support(t, y, mean):
    """The least value at `mean` of a line above all (t, y), and the interval of its slopes."""
    points = list(zip(t, y, strict=True))
    left = [point for point in points if point[0] < mean]
    right = [point for point in points if point[0] > mean]
    heights = [v for s, v in points if s == mean]
    heights += [(v * (b - mean) + w * (mean - a)) / (b - a) for a, v in left for b, w in right]
    value = max(heights)
    low = max((w - value) / (b - mean) for b, w in right)
    high = min((value - v) / (mean - a) for a, v in left)
    return value, (low, high)


def parallel(t, above, below):
    """Least width of a strip around all points: the width, the slopes' interval, its centre.

    The width is convex in the slope and linear between the slopes of pairs of points.
    """
    slopes = [
        (y[j] - y[i]) / (t[j] - t[i])
        for y in (above, below)
        for i, j in combinations(range(len(t)), 2)
        if t[i] != t[j]
    ]
    best = None
    for s in sorted(slopes):
        top = max(y - s * v for v, y in zip(t, above, strict=True))
        bottom = min(y - s * v for v, y in zip(t, below, strict=True))
        if best is None or top - bottom < best[0]:
            best = top - bottom, []
        if top - bottom == best[0]:
            best[1].append((s, (top + bottom) / 2))
    return best[0], best[1][0], best[1][-1]


def strip(t, x, h=0, e=None, number=Fraction):
    """J and the intervals for t >= 0, at least two of them different, without a linear program.

    With number=float it is fast; then `unique` means nothing and a wrong branch costs rounding.
    """
    t, x, h, e = (list(map(number, v)) for v in (t, x, [h], [0] * len(x) if e is None else e))
    h = h[0]
    above = [v + (1 - h) * w for v, w in zip(x, e, strict=True)]
    below = [v - (1 - h) * w for v, w in zip(x, e, strict=True)]
    m, mean = len(t), sum(t) / len(t)
    U, (a0, a1) = support(t, above, mean)
    L, (b1, b0) = support(t, [-v for v in below], mean)
    L, b0, b1 = -L, -b0, -b1
    limit = (U - L) / mean  # 0 <= a - b <= limit: c1 >= 0 and c0 >= 0
    if a1 < b0:
        kind = "parallel"
        width, low, high = parallel(t, above, below)
        J, unique = m * width / 2, low == high
        p1, c1 = (low[0], high[0]), (number(0), number(0))
    elif a0 - b1 > limit and min(t) > 0:
        kind = "proportional"
        above = [v / w for v, w in zip(above, t, strict=True)]
        below = [v / w for v, w in zip(below, t, strict=True)]
        width, low, high = parallel([1 / v for v in t], above, below)
        J, unique = m * mean * width / 2, low == high
        p1, c1 = tuple(sorted((low[1], high[1]))), (width / 2, width / 2)
    else:
        kind, J = "hulls", m * (U - L) / 2
        low = 2 * b0 if a0 < b0 else a0 + max(b0, a0 - limit)
        high = 2 * a1 if a1 < b1 else b1 + min(a1, b1 + limit)
        p1, c1 = (low / 2, high / 2), (max(number(0), a0 - b1) / 2, min(limit, a1 - b0) / 2)
        unique = p1[0] == p1[1] and c1[0] == c1[1]
    c1 = tuple(v / (1 - h) for v in c1)
    return Strip(J / (1 - h), p1, c1, kind, unique)
