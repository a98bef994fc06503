"""The regression as a parametrised convex program."""

import numpy as np
from numpy.typing import ArrayLike

from tuner.convex import ConvexProgram, building
from tuner.regression.window import Regressors, window

NEAR = 1e4
"""Largest size of regressors that need no scaling; its inverse is the smallest."""


def tanaka_program(t: ArrayLike, h: float = 0.0) -> ConvexProgram:
    """Tanaka's linear program for given regressors, built once for any samples.

    Parameters are ``x`` and ``e`` (0 unless given), ``(m,)``; variables ``center`` and ``spread``,
    ``(k + 1,)``; constraints ``above`` and ``below``, whose multipliers are those of
    :func:`tuner.tanaka`. Where several points are optimal the solver ends between them. It is
    solved to some 1e-8 of the samples' largest, where :func:`tuner.tanaka` is exact.

    Args:
        t: regressors without the intercept, ``(m,)`` or ``(m, k)``.
        h: degree to which samples have to belong to the band.

    Raises:
        ValueError: as :func:`tuner.tanaka`; where t does not determine the center; for regressors
            that are not of a size near 1, and, when it is solved, for samples that are much larger.

    >>> from tuner.convex import solve
    >>> program = tanaka_program([0.0, 1.0, 2.0, 3.0])
    >>> solve(program, {"x": [1.0, 3.0, 5.0, 7.0]}).variables["center"].round(6).tolist()
    [1.0, 2.0]
    """
    import cvxpy as cp

    zeros = np.zeros(np.shape(t)[:1])
    of = window(t, zeros, h, None).of
    _refuse(of)
    columns = of.columns * of.scale
    size = np.abs(columns)
    with building():
        x = cp.Parameter(len(zeros), name="x", bounds=[-NEAR, NEAR])
        e = cp.Parameter(len(zeros), name="e", bounds=[0.0, NEAR])
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


def _refuse(of: Regressors) -> None:
    """Refuses regressors that determine too little, or are too large or small to be solved for."""
    if of.rank < len(of.scale):
        raise ValueError(
            f"t has rank {of.rank} with the intercept and does not determine {len(of.scale)} "
            "coefficients; take more, or other, samples, or tuner.tanaka"
        )
    if not 1 / NEAR <= of.scale.min() <= of.scale.max() <= NEAR:
        raise ValueError(
            f"the largest entries of the regressors are {of.scale.min():g} to {of.scale.max():g}; "
            f"give t in units in which they are {1 / NEAR:g} to {NEAR:g}, or use tuner.tanaka"
        )
