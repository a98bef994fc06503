"""The matrix inequalities of both designs, as programs in the entries of a system."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from objectives import LinearSystem
from tuner.convex import Answer, ConvexProgram, building
from tuner.observers.lmi.design import Design


def _cvxpy() -> Any:
    """The module cvxpy, whose stubs lack its exports; loaded on first use."""
    import cvxpy

    return cvxpy


def values_of(design: Design) -> dict[str, np.ndarray]:
    """Values of the parameters that both designs' programs have in common."""
    B, D = _noise_roots(design.system)
    return {"A": design.system.A, "B": B, "C": design.system.C, "D": D, "M": design.M}


def _noise_roots(system: LinearSystem) -> tuple[np.ndarray, np.ndarray]:
    """B and D with unit noise u in w = B u and v = D u; as many columns as sizes allow."""
    joint = np.block([[system.W, system.S], [system.S.T, system.V]])
    values, vectors = np.linalg.eigh(joint)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    return root[: len(system.A)], root[len(system.A) :]


@dataclass(frozen=True)
class _Common:
    """The expressions common to both designs, from cvxpy's parameters and variables."""

    Y: Any
    Z: Any
    parameters: dict[str, Any]
    values: dict[str, np.ndarray]
    noise: Any
    drift: Any


def _common(design: Design) -> _Common:
    cp = _cvxpy()
    n, m, _ = design.sizes
    values = values_of(design)
    p = {name: cp.Parameter(value.shape, name=name) for name, value in values.items()}
    Y, Z = cp.Variable((n, n), symmetric=True), cp.Variable((n, m))
    drift = Y @ p["A"] - Z @ p["C"]
    driven = Y @ p["B"] - Z @ p["D"]
    ones = np.eye(driven.shape[1])
    if design.system.discrete:
        none = np.zeros((n, driven.shape[1]))
        noise = cp.bmat([[Y, drift, driven], [drift.T, Y, none], [driven.T, none.T, ones]])
    else:
        noise = cp.bmat([[-(drift + drift.T), driven], [driven.T, ones]])
    return _Common(Y, Z, p, values, noise >> 0, drift)


def variance_program(design: Design, *, capped: bool) -> ConvexProgram:
    """Minimise trace N where N >= M Y^-1 M' and Y^-1 is a bound on the error's covariance."""
    cp = _cvxpy()
    with building():
        b = _common(design)
        N = cp.Variable((len(design.M), len(design.M)), symmetric=True)
        M = b.parameters["M"]
        constraints = {"noise": b.noise, "errors": cp.bmat([[N, M], [M.T, b.Y]]) >> 0}
        if capped:
            cap = b.parameters["cap"] = cp.Parameter(nonneg=True, name="cap")
            constraints["cap"] = cap * np.eye(b.Y.shape[0]) - b.Y >> 0
        problem = cp.Problem(cp.Minimize(cp.trace(N)), list(constraints.values()))
        read = {"Y": b.Y, "Z": b.Z, "N": N}
        return ConvexProgram("least variance", problem, b.parameters, read, constraints, b.values)


def share_program(design: Design) -> ConvexProgram:
    """Minimise t where all variances of M e are at most t and the decay is at least a given one."""
    cp = _cvxpy()
    with building():
        b = _common(design)
        t = cp.Variable()
        decay = b.parameters["decay"] = cp.Parameter(nonneg=True, name="decay")
        if design.system.discrete:
            rows = [[b.Y, b.drift], [b.drift.T, decay * b.Y]]
            constraints = {"noise": b.noise, "decay": cp.bmat(rows) >> 0}
        else:
            left = -(b.drift + b.drift.T) - decay * b.Y
            constraints = {"noise": b.noise, "decay": left >> 0}
        for i in range(len(design.M)):
            row = b.parameters["M"][i : i + 1]
            block = cp.bmat([[cp.reshape(t, (1, 1), order="C"), row], [row.T, b.Y]])
            constraints[f"error {i}"] = block >> 0
        problem = cp.Problem(cp.Minimize(t), list(constraints.values()))
        read = {"Y": b.Y, "Z": b.Z, "t": t}
        return ConvexProgram("least share", problem, b.parameters, read, constraints, b.values)


def riccati_program(design: Design) -> ConvexProgram:
    """Maximise trace X where no observer's covariance is below X: the Riccati inequality."""
    cp = _cvxpy()
    with building():
        n, _, _ = design.sizes
        X = cp.Variable((n, n), symmetric=True)
        # Products of two parameters with one variable break cvxpy's rules: A, C, S are constants.
        s = design.system
        A, C, S, values = s.A, s.C, s.S, {"W": s.W, "V": s.V}
        p = {name: cp.Parameter(value.shape, name=name) for name, value in values.items()}
        if s.discrete:
            rows = [
                [A @ X @ A.T - X + p["W"], A @ X @ C.T + S],
                [C @ X @ A.T + S.T, C @ X @ C.T + p["V"]],
            ]
        else:
            rows = [[A @ X + X @ A.T + p["W"], X @ C.T + S], [C @ X + S.T, p["V"]]]
        constraints = {"Riccati": cp.bmat(rows) >> 0}
        problem = cp.Problem(cp.Minimize(-cp.trace(X)), list(constraints.values()))
        return ConvexProgram("Riccati inequality", problem, p, {"X": X}, constraints, values)


def gain_of(answer: Answer, design: Design) -> np.ndarray:
    """The gain of a point; zero where there is no point."""
    if "Y" not in answer.variables:
        return np.zeros(design.sizes[:2])
    Y, Z = answer.variables["Y"], answer.variables["Z"]
    return np.asarray(np.linalg.lstsq(Y, Z, rcond=0.0)[0])
