"""JAX functions of small models as CasADi expressions: one description, two derivatives.

The function is traced to JAX's list of operations, and each is repeated on CasADi's scalars, kept
in NumPy arrays of objects. What has no counterpart there (loops, factorisations) is refused.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from jax.extend import core

if TYPE_CHECKING:
    import casadi

Rule: TypeAlias = Callable[..., np.ndarray]


class NoCounterpartError(ValueError):
    """An operation that CasADi's scalars do not have."""


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
    (result,) = _evaluate(traced.jaxpr, traced.consts, [z])
    import casadi

    return [casadi.SX(entry) for entry in np.ravel(result)]


def _evaluate(
    jaxpr: core.Jaxpr, consts: Sequence[Any], arguments: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """The operations one after another."""
    known: dict[Any, np.ndarray] = {}
    known.update(zip(jaxpr.constvars, map(np.asarray, consts), strict=True))
    known.update(zip(jaxpr.invars, arguments, strict=True))

    def read(atom: Any) -> np.ndarray:
        return np.asarray(atom.val) if isinstance(atom, core.Literal) else known[atom]

    for equation in jaxpr.eqns:
        name, given = equation.primitive.name, [read(atom) for atom in equation.invars]
        inner = _inner(equation.params)
        if all(np.asarray(array).dtype != object for array in given):
            found = _constant(equation, given)
        elif name in _INLINED and inner is not None:
            found = _evaluate(inner.jaxpr, inner.consts, given)
        elif name in _RULES:
            found = [_RULES[name](*given, **equation.params)]
        else:
            raise NoCounterpartError(f"{name} has no counterpart in CasADi")
        known.update(zip(equation.outvars, found, strict=True))
    return [read(atom) for atom in jaxpr.outvars]


def _constant(equation: Any, given: list[np.ndarray]) -> list[np.ndarray]:
    """What depends on no symbol JAX works out itself."""
    found = equation.primitive.bind(*given, **equation.params)
    return [
        np.asarray(part) for part in (found if equation.primitive.multiple_results else [found])
    ]


_INLINED = frozenset({"jit", "pjit", "closed_call", "custom_jvp_call", "custom_vjp_call"})


def _inner(params: Mapping[str, Any]) -> core.ClosedJaxpr | None:
    for key in ("jaxpr", "call_jaxpr"):
        if isinstance(params.get(key), core.ClosedJaxpr):
            closed: core.ClosedJaxpr = params[key]
            return closed
    return None


def _each(name: str) -> Rule:
    """A function of scalars, applied entry by entry; CasADi has NumPy's names."""

    def rule(*given: np.ndarray, **_: Any) -> np.ndarray:
        import casadi

        return np.asarray(np.frompyfunc(getattr(casadi, name), len(given), 1)(*given), object)

    return rule


def _plain(function: Callable[..., Any]) -> Rule:
    """Arithmetic that scalars bring themselves."""

    def rule(*given: np.ndarray, **_: Any) -> np.ndarray:
        return np.asarray(np.frompyfunc(function, len(given), 1)(*given), object)

    return rule


def _power(x: np.ndarray, *, y: int, **_: Any) -> np.ndarray:
    return _plain(lambda entry: entry**y)(x)


def _choose(which: np.ndarray, *cases: np.ndarray, **_: Any) -> np.ndarray:
    if len(cases) != 2:
        raise NoCounterpartError("a choice among more than two has no counterpart in CasADi")
    import casadi

    return np.asarray(np.frompyfunc(casadi.if_else, 3, 1)(which, cases[1], cases[0]), object)


def _broadcast(
    x: np.ndarray,
    *dynamic: np.ndarray,
    shape: tuple[int, ...],
    broadcast_dimensions: tuple[int, ...],
    **_: Any,
) -> np.ndarray:
    axes = [1] * len(shape)
    for axis, size in zip(broadcast_dimensions, np.shape(x), strict=True):
        axes[axis] = size
    return np.broadcast_to(np.reshape(x, axes), shape)


def _slice(
    x: np.ndarray,
    *,
    start_indices: tuple[int, ...],
    limit_indices: tuple[int, ...],
    strides: tuple[int, ...] | None,
    **_: Any,
) -> np.ndarray:
    steps = strides or (1,) * len(start_indices)
    return x[tuple(map(slice, start_indices, limit_indices, steps))]


def _product(a: np.ndarray, b: np.ndarray, *, dimension_numbers: Any, **_: Any) -> np.ndarray:
    (left, right), batches = dimension_numbers
    if any(batches):
        raise NoCounterpartError("a batch of products has no counterpart in CasADi")
    return np.asarray(np.tensordot(a, b, axes=(left, right)), object)


_RULES: dict[str, Rule] = {
    **{
        name: _each(name) for name in ("exp", "log", "log1p", "expm1", "sqrt", "sin", "cos", "tanh")
    },
    "max": _each("fmax"),
    "min": _each("fmin"),
    "abs": _each("fabs"),
    "add": _plain(lambda a, b: a + b),
    "add_any": _plain(lambda a, b: a + b),
    "sub": _plain(lambda a, b: a - b),
    "mul": _plain(lambda a, b: a * b),
    "div": _plain(lambda a, b: a / b),
    "pow": _plain(lambda a, b: a**b),
    "neg": _plain(lambda a: -a),
    "square": _plain(lambda a: a * a),
    "lt": _plain(lambda a, b: a < b),
    "le": _plain(lambda a, b: a <= b),
    "gt": _plain(lambda a, b: a > b),
    "ge": _plain(lambda a, b: a >= b),
    "logistic": _plain(lambda a: 1 / (1 + np.e ** (-a))),
    "integer_pow": _power,
    "select_n": _choose,
    "broadcast_in_dim": _broadcast,
    "slice": _slice,
    "dot_general": _product,
    "reshape": lambda x, *, new_sizes, **_: np.reshape(x, new_sizes),
    "squeeze": lambda x, *, dimensions, **_: np.squeeze(x, axis=dimensions),
    "expand_dims": lambda x, *, dimensions, **_: np.expand_dims(x, dimensions),
    "transpose": lambda x, *, permutation, **_: np.transpose(x, permutation),
    "concatenate": lambda *parts, dimension, **_: np.concatenate(parts, axis=dimension),
    "stack": lambda *parts, axis, **_: np.stack(parts, axis=axis),
    "reduce_sum": lambda x, *, axes, **_: np.asarray(np.sum(x, axis=axes), object),
    "convert_element_type": lambda x, **_: x,
    "stop_gradient": lambda x, **_: x,
    "copy": lambda x, **_: x,
    "rev": lambda x, *, dimensions, **_: np.flip(x, dimensions),
}
"""How each operation of JAX is done on arrays of scalars."""
