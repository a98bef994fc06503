"""The regression as a parametrised convex program."""

import numpy as np
from numpy.typing import ArrayLike

from tuner.convex import ConvexProgram, building
from tuner.possibilistic.window import window


def tanaka_program(t: ArrayLike, h: float = 0.0) -> ConvexProgram:
    """Tanaka's linear program for given regressors, built once for any samples.

    Parameters are ``x`` and ``e`` (0 unless given), ``(m,)``; variables ``center`` and ``spread``,
    ``(k + 1,)``; constraints ``above`` and ``below``, whose multipliers are those of
    :func:`tuner.tanaka`. Where several points are optimal the solver ends between them.

    Args:
        t: regressors without the intercept, ``(m,)`` or ``(m, k)``.
        h: degree to which samples have to belong to the band.

    Raises:
        ValueError: as :func:`tuner.tanaka`.

    >>> from tuner.convex import solve
    >>> program = tanaka_program([0.0, 1.0, 2.0, 3.0])
    >>> solve(program, {"x": [1.0, 3.0, 5.0, 7.0]}).variables["center"].round(6).tolist()
    [1.0, 2.0]
    """
    import cvxpy as cp

    zeros = np.zeros(len(np.asarray(t)))
    of = window(t, zeros, h, None).of
    columns = of.columns * of.scale
    size = np.abs(columns)
    with building():
        x, e = cp.Parameter(len(zeros), name="x"), cp.Parameter(len(zeros), name="e", nonneg=True)
        center, spread = cp.Variable(columns.shape[1]), cp.Variable(columns.shape[1], nonneg=True)
        room = (1 - h) * (size @ spread - e)
        rows = {"above": columns @ center + room >= x, "below": room - columns @ center >= -x}
        problem = cp.Problem(cp.Minimize(size.sum(axis=0) @ spread), list(rows.values()))
        return ConvexProgram(
            "Tanaka's regression",
            problem,
            {"x": x, "e": e},
            {"center": center, "spread": spread},
            rows,
            {"x": zeros, "e": zeros},
        )
