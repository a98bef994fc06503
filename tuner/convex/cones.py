"""Products of cones in the solver's order: their class, and the distance from their duals."""

from typing import Any

import numpy as np


def kind_of(data: dict[str, Any]) -> str:
    """The class of compiled data: lp, qp, socp, sdp, or conic for any other."""
    dims = data["dims"]
    if dims.exp or dims.p3d or getattr(dims, "pnd", None):
        return "conic"
    if dims.psd:
        return "sdp"
    if dims.soc:
        return "socp"
    return "qp" if "P" in data and data["P"].nnz else "lp"


def outside(z: np.ndarray, dims: Any) -> float:
    """The Euclidean distance of z from the dual of the product of cones."""
    first = dims.zero + dims.nonneg
    distance = np.linalg.norm(np.minimum(z[dims.zero : first], 0.0)) ** 2
    for size in dims.soc:
        block = z[first : first + size]
        distance += max(float(np.linalg.norm(block[1:]) - block[0]), 0.0) ** 2
        first += size
    for order in dims.psd:
        size = order * (order + 1) // 2
        negative = np.minimum(np.linalg.eigvalsh(matrix(z[first : first + size], order)), 0.0)
        distance += negative @ negative
        first += size
    return float(np.sqrt(distance))


def matrix(triangle: np.ndarray, order: int) -> np.ndarray:
    """The symmetric matrix of a scaled upper triangle, column after column."""
    full = np.zeros((order, order))
    columns, rows = np.tril_indices(order)
    full[rows, columns] = triangle / np.where(rows == columns, 1.0, np.sqrt(2.0))
    return full + np.triu(full, 1).T
