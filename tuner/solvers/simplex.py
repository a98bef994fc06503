"""Nelder and Mead's simplex search, with the rules of MATLAB's fminsearch."""

from collections.abc import Callable

import numpy as np

from tuner.solvers.minimum import Minimum


def boxed(
    function: Callable[[np.ndarray], float],
    z: np.ndarray,
    box: tuple[np.ndarray, np.ndarray],
    *,
    step: float,
    tolerance: float,
    limit: int,
) -> Minimum:
    """Minimise within a box, from a simplex with one step along each coordinate.

    Args:
        function: what is minimised; never called outside the box.
        z: the start, ``(n,)``.
        box: lowest and highest z, ``(n,)`` each.
        step: edge of the first simplex.
        tolerance: size of the last simplex.
        limit: of evaluations and of iterations.

    >>> box = np.array([0.0, 0.0]), np.array([1.0, 1.0])
    >>> start, cost = np.full(2, 0.9), lambda z: z @ z - 4 * z[1]
    >>> boxed(cost, start, box, step=0.5, tolerance=1e-6, limit=400).z.round(5).tolist()
    [0.0, 1.0]
    """
    # A step that would leave the box goes the other way.
    edge = np.where(z + step <= box[1], step, -step)
    simplex = np.vstack([z, z + np.diag(edge)])
    return nelder_mead(function, simplex, xtol=tolerance, ftol=np.inf, limit=limit, box=box)


def fminsearch(function: Callable[[np.ndarray], float], start: np.ndarray) -> Minimum:
    """MATLAB's ``fminsearch(function, start)`` with its default options.

    The first simplex changes each coordinate by 5 %, or by 0.00025 where it is zero; the search
    ends when the simplex and its values are both smaller than 1e-4 (absolute), or after 200
    evaluations or iterations per coordinate. For coordinates near 1e-6 that tolerance is met by
    the first simplex already: the search then stops after n + 1 evaluations where it began.

    >>> fminsearch(lambda x: (x[0] - 3.0) ** 2, np.array([1.0])).value < 1e-8
    True
    """
    start = np.asarray(start, dtype=float)
    moved = np.where(start != 0, 1.05 * start, 0.00025)
    simplex = np.vstack([start, np.where(np.eye(len(start), dtype=bool), moved, start)])
    return nelder_mead(function, simplex, xtol=1e-4, ftol=1e-4, limit=200 * len(start))


def nelder_mead(
    function: Callable[[np.ndarray], float],
    simplex: np.ndarray,
    *,
    xtol: float,
    ftol: float,
    limit: int,
    box: tuple[np.ndarray, np.ndarray] | None = None,
) -> Minimum:
    """Minimise by the simplex method of Lagarias, Reeds, Wright and Wright, SIAM J. Optim. 1998.

    Args:
        function: what is minimised; infinite where it is not defined.
        simplex: the first n + 1 points, ``(n + 1, n)``.
        xtol, ftol: the search ends when no point is further from the best one than xtol in any
            coordinate, and no value further than ftol.
        limit: of evaluations and of iterations.
        box: lowest and highest points; points outside are moved onto the box.
    """
    count = 0

    def value(point: np.ndarray) -> float:
        nonlocal count
        count += 1
        return function(point)

    def inside(point: np.ndarray) -> np.ndarray:
        return point if box is None else np.minimum(np.maximum(point, box[0]), box[1])

    points = inside(np.array(simplex, dtype=float))
    values = np.array([value(point) for point in points])
    finished, iterations = False, 0
    while not finished and count < limit and iterations < limit:
        order = np.argsort(values, kind="stable")
        points, values = points[order], values[order]
        finished = _small(points, values, xtol, ftol)
        if finished:
            break
        iterations += 1
        replacement = _replace_worst(points, values, value, inside)
        if replacement is None:
            points[1:] = inside(points[0] + 0.5 * (points[1:] - points[0]))
            values[1:] = [value(point) for point in points[1:]]
        else:
            points[-1], values[-1] = replacement
    best = int(np.argmin(values))
    ended = "simplex within tolerance" if finished else f"stopped after {count} evaluations"
    return Minimum(points[best], float(values[best]), count, finished, ended)


def _small(points: np.ndarray, values: np.ndarray, xtol: float, ftol: float) -> bool:
    near = np.abs(points[1:] - points[0]).max() <= xtol
    # Infinite values are equal, though their difference is not a number.
    return bool(near and (values[-1] == values[0] or values[-1] - values[0] <= ftol))


def _replace_worst(
    points: np.ndarray,
    values: np.ndarray,
    value: Callable[[np.ndarray], float],
    inside: Callable[[np.ndarray], np.ndarray],
) -> tuple[np.ndarray, float] | None:
    """Reflect, expand or contract the worst of the sorted points; None asks for a shrink."""
    centre, worst = points[:-1].sum(axis=0) / (len(points) - 1), points[-1]

    def probe(factor: float) -> tuple[np.ndarray, float]:
        point = inside((1 + factor) * centre - factor * worst)
        return point, value(point)

    reflected = probe(1.0)
    if reflected[1] < values[0]:
        expanded = probe(2.0)
        return expanded if expanded[1] < reflected[1] else reflected
    if reflected[1] < values[-2]:
        return reflected
    if reflected[1] < values[-1]:
        outside = probe(0.5)
        return outside if outside[1] <= reflected[1] else None
    within = probe(-0.5)
    return within if within[1] < values[-1] else None
