"""Kinds of objective: they decide how far a value can be trusted.

A likelihood counts in nats that add up over the numbers of a record, so that a difference has a
meaning of its own. A mean square is a mean over samples whose scatter can be seen. Of any other
cost nothing is known but its value.
"""

from typing import Any, Literal, Protocol, TypeAlias, TypeGuard

from jax import Array

Kind: TypeAlias = Literal["likelihood", "mean square", "root mean square", "cost"]


class Additive(Protocol):
    """An objective that is a sum of terms, one for each number of a record, over their count.

    Attributes:
        kind: a likelihood's value is the mean itself, in nats a number; a root mean square is the
            root of a multiple of it.
    """

    kind: Kind

    def added(self, output: Any, truth: Any) -> tuple[Array, Array]:
        """Each number's term of the sum, and whether it counts: of one shape, ``(...,)``."""
        ...


def kind_of(objective: Any) -> Kind:
    """The kind that an objective states; a cost where it states none.

    >>> kind_of(lambda outputs, truth: outputs.max())
    'cost'
    """
    kind: Kind = getattr(objective, "kind", "cost")
    return kind


def is_additive(objective: Any) -> TypeGuard[Additive]:
    """Whether an objective provides the term of each number."""
    return kind_of(objective) != "cost"
