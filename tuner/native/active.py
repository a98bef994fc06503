"""The parameters of a filter that depend on a point."""

from collections.abc import Callable
from typing import Any

import jax
import numpy as np
from jax import Array

from tuner.code.graph import Graph, TooLargeError
from tuner.code.interpreter import objects
from tuner.code.primitives import interpreter
from tuner.code.refused import NoCounterpartError

_MOST = 50_000


def moved(build: Callable[[Array], Any], size: int) -> list[np.ndarray]:
    """The coordinates of a point that each number of the parameters depends on.

    By scalars where the way from point to parameters is made of operations that a graph has, else
    by whole arrays: a number more than need be costs time and changes nothing.

    Args:
        build: the map from a point to parameters.
        size: of a point.

    Returns:
        For each leaf of the parameters truth values of its shape and ``(size,)``.
    """
    closed = jax.make_jaxpr(build)(np.zeros(size))
    try:
        return _by_numbers(closed, size)
    except (NoCounterpartError, TooLargeError):
        return _by_arrays(closed, size)


def _by_numbers(closed: Any, size: int) -> list[np.ndarray]:
    graph = Graph(most=_MOST)
    z = np.array([graph.input(k) for k in range(size)] or 0, object)
    leaves = objects(graph, interpreter(graph).closed(closed, [z.reshape(size)]))
    by: list[frozenset[int]] = []
    for node in graph.nodes:
        own = {node.value} if node.op == "input" else set()
        by.append(frozenset(own.union(*(by[k] for k in node.args))))
    return [_spread(leaf, lambda entry: by[entry], size) for leaf in leaves]


def _spread(leaf: np.ndarray, by: Callable[[Any], frozenset[int]], size: int) -> np.ndarray:
    out = np.zeros((*leaf.shape, size), bool)
    for index in np.ndindex(leaf.shape):
        out[index][list(by(leaf[index]))] = True
    return out


def _by_arrays(closed: Any, size: int) -> list[np.ndarray]:
    jaxpr = closed.jaxpr
    live = set(jaxpr.invars)
    for equation in jaxpr.eqns:
        if any(not hasattr(atom, "val") and atom in live for atom in equation.invars):
            live |= set(equation.outvars)
    return [
        np.full((*out.aval.shape, size), not hasattr(out, "val") and out in live)
        for out in jaxpr.outvars
    ]
