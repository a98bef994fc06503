"""Linear programs from their matrices."""

import numpy as np
from numpy.typing import ArrayLike

from tuner.convex.clarabel import building
from tuner.convex.program import ConvexProgram


def linear_program(
    c: ArrayLike,
    A_ub: ArrayLike | None = None,
    b_ub: ArrayLike | None = None,
    A_eq: ArrayLike | None = None,
    b_eq: ArrayLike | None = None,
    low: ArrayLike | None = None,
    high: ArrayLike | None = None,
    *,
    name: str = "linear program",
) -> ConvexProgram:
    """Minimise c'x where A_ub x <= b_ub, A_eq x = b_eq and low <= x <= high.

    Its parameters are the arguments that were given, under their names, so that it may be solved
    for others of the same shapes; ``low`` and ``high`` then list the finite bounds alone. Its
    variable is ``x``, its constraints are ``ub``, ``eq``, ``low`` and ``high``.

    Args:
        c: costs, ``(n,)``.
        A_ub, b_ub: inequalities, ``(k, n)`` and ``(k,)``.
        A_eq, b_eq: equalities, ``(l, n)`` and ``(l,)``.
        low, high: bounds, ``(n,)`` or a number, infinite where there is none.
        name: of the program.

    Raises:
        ValueError: for shapes that do not fit, or a matrix without its right-hand side.

    >>> from tuner.convex import solve
    >>> program = linear_program([-1.0, -2.0], [[1.0, 1.0]], [4.0], low=0.0, high=3.0)
    >>> solve(program).variables["x"].round(6).tolist()
    [1.0, 3.0]
    >>> solve(program, {"b_ub": [5.0]}).variables["x"].round(6).tolist()
    [2.0, 3.0]
    """
    costs = _array("c", c, 1)
    values = {"c": costs}
    values |= _rows("A_ub", A_ub, "b_ub", b_ub, costs.size)
    values |= _rows("A_eq", A_eq, "b_eq", b_eq, costs.size)
    bounds = {"low": low, "high": high}
    finite = {k: _finite(k, v, costs.size) for k, v in bounds.items() if v is not None}
    values |= {k: bound for k, (_, bound) in finite.items() if bound.size}
    return _built(name, values, {k: where for k, (where, _) in finite.items()})


def _built(name: str, values: dict[str, np.ndarray], where: dict[str, np.ndarray]) -> ConvexProgram:
    """The program of the given arguments; ``where`` selects the entries that have bounds."""
    import cvxpy as cp

    with building():
        x = cp.Variable(values["c"].size)
        p = {key: cp.Parameter(value.shape, name=key) for key, value in values.items()}
        constraints = {}
        if "b_ub" in p:
            constraints["ub"] = p["A_ub"] @ x <= p["b_ub"]
        if "b_eq" in p:
            constraints["eq"] = p["A_eq"] @ x == p["b_eq"]
        if "low" in p:
            constraints["low"] = p["low"] <= x[where["low"]]
        if "high" in p:
            constraints["high"] = x[where["high"]] <= p["high"]
        problem = cp.Problem(cp.Minimize(p["c"] @ x), list(constraints.values()))
        return ConvexProgram(name, problem, p, {"x": x}, constraints, values)


def _array(name: str, value: ArrayLike, dimensions: int) -> np.ndarray:
    array = np.asarray(value, float)
    if array.ndim != dimensions or not array.size:
        raise ValueError(
            f"{name} has shape {array.shape}, but needs {dimensions} dimension(s) and an entry"
        )
    return array


def _rows(
    matrix: str, A: ArrayLike | None, side: str, b: ArrayLike | None, size: int
) -> dict[str, np.ndarray]:
    if A is None and b is None:
        return {}
    if A is None or b is None:
        raise ValueError(f"{matrix} and {side} belong together; give both or neither")
    rows, bound = _array(matrix, A, 2), _array(side, b, 1)
    if rows.shape != (bound.size, size):
        raise ValueError(f"{matrix} has shape {rows.shape}, but needs {(bound.size, size)}")
    return {matrix: rows, side: bound}


def _finite(name: str, bound: ArrayLike, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Where a bound is finite, and its values there."""
    given = np.asarray(bound, float)
    if given.shape not in ((), (size,)):
        raise ValueError(f"{name} has shape {given.shape}, but needs {(size,)} or a number")
    full = np.broadcast_to(given, (size,))
    none = -np.inf if name == "low" else np.inf
    there = np.flatnonzero(full != none)
    return there, full[there]
