"""Python functions as CasADi calls them."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import casadi

Evaluate = Callable[..., Any]


def python_function(
    name: str,
    sizes: Sequence[int],
    shape: "casadi.Sparsity",
    evaluate: Evaluate,
    jacobian: Evaluate | None = None,
) -> "casadi.Callback":
    """A function of vectors with the given sizes, and its Jacobian by the first of them.

    Args:
        name: what CasADi calls it.
        sizes: of its arguments.
        shape: of its result, a sparsity pattern.
        evaluate: from the arguments, each ``(size,)``, to the result.
        jacobian: from the arguments and the result to the Jacobian.

    Returns:
        A function that must be kept alive as long as anything that calls it.
    """
    import casadi

    class Function(casadi.Callback):
        """CasADi's way to call back: a class with these very methods."""

        def __init__(self) -> None:
            casadi.Callback.__init__(self)
            self.derivative: casadi.Callback | None = None
            self.construct(name, {})

        def get_n_in(self) -> int:
            return len(sizes)

        def get_sparsity_in(self, i: int) -> "casadi.Sparsity":
            return casadi.Sparsity.dense(sizes[i], 1)

        def get_sparsity_out(self, i: int) -> "casadi.Sparsity":
            return shape

        def eval(self, given: Sequence["casadi.DM"]) -> list["casadi.DM"]:
            found = evaluate(*(argument.full().ravel() for argument in given))
            return [casadi.DM(np.asarray(found, float))]

        def has_jacobian(self) -> bool:
            return jacobian is not None

        def get_jacobian(self, *_: Any) -> "casadi.Callback":
            if jacobian is None:
                raise TypeError(f"{name} has no Jacobian")
            dense = casadi.Sparsity.dense(shape.rows(), sizes[0])
            both = [*sizes, shape.rows()]
            self.derivative = python_function(f"jac_{name}", both, dense, jacobian)
            return self.derivative

    return Function()
