"""A second opinion: the same program by HiGHS, which ends at a vertex."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from tuner.regression.window import window


class Vertex(NamedTuple):
    """An optimal vertex.

    Attributes:
        center, spread: ``(k + 1,)``.
        objective: the sum of the spreads at all samples.
        determined: whether t determines the center; if not, it is the shortest one.
    """

    center: np.ndarray
    spread: np.ndarray
    objective: float
    determined: bool


def tanaka_simplex(
    t: ArrayLike, x: ArrayLike, h: float = 0.0, e: ArrayLike | None = None
) -> Vertex:
    """One optimum of :func:`tuner.tanaka`'s program, by the simplex method of HiGHS.

    Its objective is that of :func:`tuner.tanaka`; its center is another one where several are
    optimal.

    Raises:
        ValueError: as :func:`tuner.tanaka`.
        ArithmeticError: where HiGHS does not converge.

    >>> tanaka_simplex([0.0, 1.0, 2.0], [1.0, 1.5, 2.0]).center.round(9).tolist()
    [1.0, 0.5]
    """
    from scipy.optimize import linprog

    task = window(t, x, h, e)
    of = task.of
    bounds = [(None, None)] * of.rank + [(0, None)] * (len(of.cost) - of.rank)
    rows = 2 * len(task.values)  # the rest are the bounds
    found = linprog(
        of.cost,
        A_ub=-of.rows[:rows],
        b_ub=-task.sides[:rows],
        bounds=bounds,
        method="highs-ds",
        options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
    )
    if found.status:
        raise ArithmeticError(f"HiGHS did not converge: {found.message}")
    center, spread = task.restored(np.asarray(found.x))
    determined = of.rank == len(center)
    return Vertex(center, spread, float(found.fun) * task.size / (1 - h), determined)
