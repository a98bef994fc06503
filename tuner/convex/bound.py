"""The lower bound that a dual point proves, recomputed from the program's data."""

from typing import Any

import numpy as np

from tuner.convex.cones import kind_of, outside

MARGIN = 10.0
"""Size, relative to the solution, of the points for which the lower bound holds."""


def dual_bound(data: dict[str, Any], x: np.ndarray, z: np.ndarray, s: np.ndarray) -> float | None:
    """The bound from z on min x'Px / 2 + c'x with b - Ax in K; None for cones not checked here.

    From Px + c + A'z = r and z in K* follows the bound -x'Px/2 - b'z + r'y for every admissible
    y; the dual residual r and z's distance from K* are made up for by the size of x and s.
    """
    if kind_of(data) == "conic":
        return None
    curved = data["P"] @ x if "P" in data else np.zeros_like(x)
    residual = curved + data["c"] + data["A"].T @ z
    slack = MARGIN * (np.abs(residual) @ np.abs(x) + outside(z, data["dims"]) * np.linalg.norm(s))
    return float(-x @ curved / 2 - data["b"] @ z - slack)
