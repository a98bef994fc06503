"""JAX functions of small models as CasADi expressions: one description, two derivatives.

The function is traced to JAX's list of operations, and each is repeated on CasADi's scalars, kept
in NumPy arrays of objects. What has no counterpart there is refused.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from tuner.code.primitives import interpreter
from tuner.code.refused import NoCounterpartError

if TYPE_CHECKING:
    import casadi

_FUNCTIONS = {"max": "fmax", "min": "fmin", "abs": "fabs"}
"""Functions whose names in CasADi differ from JAX and NumPy."""
_OPERATORS: Mapping[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "pow": lambda a, b: a**b,
    "neg": lambda a: -a,
    "lt": lambda a, b: a < b,
    "le": lambda a, b: a <= b,
    "gt": lambda a, b: a > b,
    "ge": lambda a, b: a >= b,
    "eq": lambda a, b: a == b,
    "ne": lambda a, b: a != b,
}


def expressions(
    function: Callable[[Array], Array], symbols: Sequence["casadi.SX"]
) -> list["casadi.SX"]:
    """A function ``(n,)`` to ``(m,)`` or ``()`` as m expressions of n symbols.

    Raises:
        NoCounterpartError: names the operation that cannot be translated.

    >>> import casadi
    >>> x = [casadi.SX.sym("a"), casadi.SX.sym("b")]
    >>> expressions(lambda z: jnp.exp(z[0]) * z[1], x)
    [SX((exp(a)*b))]
    """
    traced = jax.make_jaxpr(function)(jnp.zeros(len(symbols)))
    z = np.empty(len(symbols), object)
    z[:] = list(symbols)
    (result,) = interpreter(_Scalars(), unrolls=False).closed(traced, [z])
    import casadi

    return [casadi.SX(entry) for entry in np.ravel(result)]


class _Scalars:
    """CasADi's scalars as the entries of an interpreter."""

    def constant(self, value: Any) -> Any:
        """A number; truth values as 0 and 1."""
        return float(value)

    def apply(self, op: str, *entries: Any) -> Any:
        """An operator, or a function, most of which CasADi calls as NumPy does."""
        import casadi

        if op in _OPERATORS:
            return _OPERATORS[op](*entries)
        function = getattr(casadi, _FUNCTIONS.get(op, op), None)
        if function is None:
            raise NoCounterpartError(f"{op} has no counterpart in CasADi")
        return function(*entries)

    def choose(self, condition: Any, no: Any, yes: Any) -> Any:
        """One of two; both are evaluated."""
        import casadi

        return casadi.if_else(condition, yes, no)

    def convert(self, entry: Any, dtype: np.dtype) -> Any:
        """CasADi has one kind of number."""
        return entry
