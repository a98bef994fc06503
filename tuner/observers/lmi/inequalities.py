"""The matrix inequalities of both designs, as programs in the entries of a model."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tuner.convex import Answer, ConvexProgram, building
from tuner.observers.lmi.model import Model


def _cvxpy() -> Any:
    """cvxpy, whose stubs do not say what it exports; loaded when it is first used."""
    import cvxpy

    return cvxpy


def values_of(model: Model) -> dict[str, np.ndarray]:
    """Values of the parameters that both designs' programs have in common."""
    B, D = _noise_roots(model)
    return {"A": model.A, "B": B, "C": model.C, "D": D, "M": model.M}


def _noise_roots(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """B and D with unit noise u in w = B u and v = D u; as many columns as sizes allow."""
    joint = np.block([[model.W, model.S], [model.S.T, model.V]])
    values, vectors = np.linalg.eigh(joint)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return root[: len(model.A)], root[len(model.A) :]


@dataclass(frozen=True)
class _Common:
    """The expressions both designs are made of, given cvxpy's parameters and variables."""

    Y: Any
    Z: Any
    parameters: dict[str, Any]
    values: dict[str, np.ndarray]
    noise: Any
    drift: Any


def _common(model: Model) -> _Common:
    cp = _cvxpy()
    n, m, _ = model.sizes
    values = values_of(model)
    p = {name: cp.Parameter(value.shape, name=name) for name, value in values.items()}
    Y, Z = cp.Variable((n, n), symmetric=True), cp.Variable((n, m))
    drift = Y @ p["A"] - Z @ p["C"]
    driven = Y @ p["B"] - Z @ p["D"]
    ones = np.eye(driven.shape[1])
    if model.discrete:
        none = np.zeros((n, driven.shape[1]))
        noise = cp.bmat([[Y, drift, driven], [drift.T, Y, none], [driven.T, none.T, ones]])
    else:
        noise = cp.bmat([[-(drift + drift.T), driven], [driven.T, ones]])
    return _Common(Y, Z, p, values, noise >> 0, drift)


def least_variance(model: Model, *, capped: bool) -> ConvexProgram:
    """Minimise trace N where N >= M Y^-1 M' and Y^-1 is a bound on the error's covariance."""
    cp = _cvxpy()
    with building():
        b = _common(model)
        N = cp.Variable((len(model.M), len(model.M)), symmetric=True)
        M = b.parameters["M"]
        constraints = {"noise": b.noise, "errors": cp.bmat([[N, M], [M.T, b.Y]]) >> 0}
        if capped:
            cap = b.parameters["cap"] = cp.Parameter(nonneg=True, name="cap")
            constraints["cap"] = cap * np.eye(b.Y.shape[0]) - b.Y >> 0
        problem = cp.Problem(cp.Minimize(cp.trace(N)), list(constraints.values()))
        read = {"Y": b.Y, "Z": b.Z, "N": N}
        return ConvexProgram("least variance", problem, b.parameters, read, constraints, b.values)


def least_share(model: Model) -> ConvexProgram:
    """Minimise t where all variances of M e are at most t and the decay is at least a given one."""
    cp = _cvxpy()
    with building():
        b = _common(model)
        t = cp.Variable()
        decay = b.parameters["decay"] = cp.Parameter(nonneg=True, name="decay")
        if model.discrete:
            rows = [[b.Y, b.drift], [b.drift.T, decay * b.Y]]
            constraints = {"noise": b.noise, "decay": cp.bmat(rows) >> 0}
        else:
            left = -(b.drift + b.drift.T) - decay * b.Y
            constraints = {"noise": b.noise, "decay": left >> 0}
        for i in range(len(model.M)):
            row = b.parameters["M"][i : i + 1]
            block = cp.bmat([[cp.reshape(t, (1, 1), order="C"), row], [row.T, b.Y]])
            constraints[f"error {i}"] = block >> 0
        problem = cp.Problem(cp.Minimize(t), list(constraints.values()))
        read = {"Y": b.Y, "Z": b.Z, "t": t}
        return ConvexProgram("least share", problem, b.parameters, read, constraints, b.values)


def largest_covariance(model: Model) -> ConvexProgram:
    """Maximise trace X where no observer's covariance is below X: the Riccati inequality."""
    cp = _cvxpy()
    with building():
        n, _, _ = model.sizes
        X = cp.Variable((n, n), symmetric=True)
        # Products of two parameters with one variable break cvxpy's rules: A and C are constants.
        A, C, values = model.A, model.C, {"W": model.W, "V": model.V}
        p = {name: cp.Parameter(value.shape, name=name) for name, value in values.items()}
        if model.discrete:
            rows = [
                [A @ X @ A.T - X + p["W"], A @ X @ C.T],
                [C @ X @ A.T, C @ X @ C.T + p["V"]],
            ]
        else:
            rows = [[A @ X + X @ A.T + p["W"], X @ C.T], [C @ X, p["V"]]]
        constraints = {"Riccati": cp.bmat(rows) >> 0}
        problem = cp.Problem(cp.Minimize(-cp.trace(X)), list(constraints.values()))
        return ConvexProgram("Riccati inequality", problem, p, {"X": X}, constraints, values)


def gain_of(answer: Answer, model: Model) -> np.ndarray:
    """The gain of a point; none of it where there is no point."""
    if "Y" not in answer.variables:
        return np.zeros((len(model.A), len(model.C)))
    Y, Z = answer.variables["Y"], answer.variables["Z"]
    return np.asarray(np.linalg.lstsq(Y, Z, rcond=0.0)[0])
