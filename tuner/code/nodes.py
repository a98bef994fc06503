"""Nodes of a graph of scalars, and the queries that simplification needs."""

from typing import Any, NamedTuple, Protocol

import numpy as np

from tuner.code.operations import Kind
from tuner.code.points import Points


class Node(NamedTuple):
    """One scalar.

    Attributes:
        op: of :mod:`tuner.code.operations`, or ``constant``, ``input``, ``choose``, ``convert``.
        args: numbers of the nodes it is made of; ``choose`` has the condition, yes and no.
        value: of a constant; of an input, its name.
        kind: of the scalar.
    """

    op: str
    args: tuple[int, ...] = ()
    value: Any = None
    kind: Kind = "real"


class Nodes(Protocol):
    """A graph of scalars; see :class:`tuner.code.graph.Graph`."""

    nodes: list[Node]
    points: Points
    precision: type[np.floating]
    halves: bool
    means: set[int]

    def constant(self, value: Any) -> int:
        """A number."""
        ...

    def apply(self, op: str, *entries: int) -> int:
        """One operation, simplified."""
        ...

    def choose(self, condition: int, no: int, yes: int) -> int:
        """One of two."""
        ...

    def is_constant(self, entry: int, value: float | None = None) -> bool:
        """Whether a node is a constant, or a given one."""
        ...
