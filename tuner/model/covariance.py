"""Matrices and covariances of expressions."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from tuner.model.expression import ZERO, Node

Rows: TypeAlias = tuple[tuple[Node, ...], ...]


@dataclass(frozen=True)
class Covariance:
    """A symmetric matrix of expressions.

    Attributes:
        rows: all of it.
        full: whether an entry off its diagonal is not 0.
    """

    rows: Rows
    full: bool

    @classmethod
    def of(cls, rows: Rows) -> "Covariance":
        """The covariance of a whole matrix."""
        pairs = ((i, j) for i in range(len(rows)) for j in range(len(rows)) if i != j)
        return cls(rows, any(rows[i][j] != ZERO for i, j in pairs))

    @classmethod
    def diagonal(cls, variances: Sequence[Node]) -> "Covariance":
        """The covariance of independent variances."""
        size = range(len(variances))
        rows = (tuple(variances[i] if i == j else ZERO for j in size) for i in size)
        return cls(tuple(rows), False)

    @property
    def variances(self) -> tuple[Node, ...]:
        """The diagonal."""
        return tuple(row[i] for i, row in enumerate(self.rows))
