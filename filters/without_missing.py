"""The step of a filter on samples in which nothing is missing, and how its parts depend on them."""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple, TypeAlias

import jax
import jax.core
import jax.numpy as jnp
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, JaxprEqn, Literal, Var

from filters.invariant import MOVES

Step: TypeAlias = Callable[[Any, Any, Any], tuple[Any, Any]]
"""From parameters, a state and a sample to the next state and an output."""
_LINEAR = MOVES | {
    "add",
    "add_any",
    "concatenate",
    "copy",
    "copy_p",
    "neg",
    "optimization_barrier",
    "pad",
    "reduce_sum",
    "stack",
    "sub",
}
_PRODUCTS = {"mul", "dot_general"}
_CALLS = {"jit": "jaxpr", "closed_call": "call_jaxpr", "core_closed_call": "call_jaxpr"} | {
    f"custom_{kind}_call": "call_jaxpr" for kind in ("jvp", "vjp")
}
KNOWN, AFFINE, NONLINEAR = range(3)
"""How a number follows from a state and a sample: not at all; by a formula a x + b whose a and b
depend on neither; in any other way."""


class _Value(NamedTuple):
    """A value in a formula.

    Attributes:
        value: the value.
        fixed: whether it follows from the parameters alone.
        sampled: whether it is made of numbers of the sample, by sums and products with what is
            fixed: no such value is missing.
    """

    value: Any
    fixed: bool = False
    sampled: bool = False


def without_missing(step: Step, params: Any, state: Any, sample: Any) -> Step:
    """A step for samples without a missing number: what it asks of NaN in them is answered.

    Args:
        step: a filter's, with the parameters first.
        params: the parameters, or their shapes.
        state: one state, or its shapes.
        sample: one sample's inputs, or their shapes.

    Returns:
        A step for arguments of the same shapes.

    >>> step = lambda p, s, u: (jnp.where(jnp.isnan(u), s, p * u), s)
    >>> once = without_missing(step, 1.0, 1.0, 1.0)
    >>> print(jax.make_jaxpr(once)(1.0, 1.0, 1.0))
    { lambda ; a:f64[] b:f64[] c:f64[]. let d:f64[] = mul a c in (d, b) }
    """
    closed, shapes = jax.make_jaxpr(step, return_shape=True)(params, state, sample)
    tree = jax.tree.structure(shapes)

    def complete(params: Any, state: Any, sample: Any) -> tuple[Any, Any]:
        given = [_Value(leaf, fixed=True) for leaf in jax.tree.leaves(params)]
        given += [_Value(leaf) for leaf in jax.tree.leaves(state)]
        given += [_Value(leaf, sampled=True) for leaf in jax.tree.leaves(sample)]
        found = [result.value for result in _evaluated(closed, given)]
        result: tuple[Any, Any] = jax.tree.unflatten(tree, found)
        return result

    return complete


def dependence(closed: ClosedJaxpr, given: Iterable[int]) -> list[int]:
    """How results follow from what is given: ``KNOWN``, ``AFFINE`` or ``NONLINEAR``.

    Args:
        closed: the formula, without calls in it.
        given: the same of its arguments.
    """
    jaxpr = closed.jaxpr
    kinds: dict[Var, int] = dict.fromkeys(jaxpr.constvars, KNOWN)
    kinds |= dict(zip(jaxpr.invars, given, strict=True))

    def of(atom: Any) -> int:
        return KNOWN if isinstance(atom, Literal) else kinds[atom]

    for eqn in jaxpr.eqns:
        kind = _kind(eqn, [of(atom) for atom in eqn.invars])
        kinds.update(dict.fromkeys(eqn.outvars, kind))
    return [of(atom) for atom in jaxpr.outvars]


def needed(closed: ClosedJaxpr) -> list[bool]:
    """Which of its arguments a formula reads for its results."""
    wanted = {v for v in closed.jaxpr.outvars if not isinstance(v, Literal)}
    for eqn in reversed(closed.jaxpr.eqns):
        if not wanted.isdisjoint(eqn.outvars):
            wanted |= {v for v in eqn.invars if not isinstance(v, Literal)}
    return [v in wanted for v in closed.jaxpr.invars]


def _kind(eqn: JaxprEqn, operands: list[int]) -> int:
    name, most = eqn.primitive.name, max(operands, default=KNOWN)
    if most != AFFINE:
        return most
    others_known = operands.count(AFFINE) == 1
    floats = all(jnp.issubdtype(_aval(v).dtype, jnp.floating) for v in eqn.outvars)
    straight = (
        (name in _LINEAR and floats)
        or (name in _PRODUCTS and others_known)
        or (name == "div" and operands[1] == KNOWN)
        or (name == "select_n" and operands[0] == KNOWN)
        or (name in ("dynamic_slice", "gather") and others_known and operands[0] == AFFINE)
    )
    return AFFINE if straight else NONLINEAR


def _evaluated(closed: ClosedJaxpr, given: list[_Value]) -> list[_Value]:
    jaxpr = closed.jaxpr
    values = {var: _Value(c, True) for var, c in zip(jaxpr.constvars, closed.consts, strict=True)}
    values |= dict(zip(jaxpr.invars, given, strict=True))

    def of(atom: Any) -> _Value:
        return _Value(atom.val, fixed=True) if isinstance(atom, Literal) else values[atom]

    for eqn in jaxpr.eqns:
        operands = [of(atom) for atom in eqn.invars]
        inner = eqn.params.get(_CALLS.get(eqn.primitive.name, ""))
        if inner is not None:
            found = _evaluated(inner, operands)
        else:
            found = _answered(jaxpr, eqn, operands) or _done(jaxpr, eqn, operands)
        values |= dict(zip(eqn.outvars, found, strict=True))
    return [of(atom) for atom in jaxpr.outvars]


def _answered(jaxpr: Jaxpr, eqn: JaxprEqn, operands: list[_Value]) -> list[_Value]:
    """The result of an operation that the answers to earlier questions determine; else nothing."""
    name, values = eqn.primitive.name, [operand.value for operand in operands]
    if name == "ne" and operands[0].sampled and eqn.invars[0] is eqn.invars[1]:
        # A number differs from itself where it is NaN.
        return [_Value(np.zeros(_aval(eqn.outvars[0]).shape, bool), fixed=True)]
    if name == "select_n" and _one(values[0]):
        return [operands[1 + int(np.ravel(values[0])[0])]]
    if name in ("and", "or") and _aval(eqn.outvars[0]).dtype == bool:
        first, second = operands if _one(values[0]) else operands[::-1]
        if _one(first.value):
            return [second if bool(np.ravel(first.value)[0]) == (name == "and") else first]
    if values and all(isinstance(value, np.ndarray | np.generic) for value in values):
        with jax.ensure_compile_time_eval():
            found = _done(jaxpr, eqn, operands)
        return [each._replace(value=np.asarray(each.value)) for each in found]
    return []


def _aval(var: Var) -> Any:
    return var.aval


def _one(value: Any) -> bool:
    """Whether it is an answer, and everywhere the same."""
    return isinstance(value, np.ndarray) and value.size > 0 and bool(np.all(value == value.flat[0]))


def _done(jaxpr: Jaxpr, eqn: JaxprEqn, operands: list[_Value]) -> list[_Value]:
    own = {a: o.value for a, o in zip(eqn.invars, operands, strict=True) if isinstance(a, Var)}
    part: Jaxpr = jaxpr.replace(
        constvars=[],
        invars=list(own),
        eqns=[eqn],
        outvars=list(eqn.outvars),
        debug_info=jaxpr.debug_info.with_unknown_names(),
    )
    fixed = all(operand.fixed for operand in operands)
    finite = not fixed and all(operand.fixed or operand.sampled for operand in operands)
    sampled = finite and eqn.primitive.name in _LINEAR | _PRODUCTS
    return [_Value(v, fixed, sampled) for v in jax.core.eval_jaxpr(part, (), *own.values())]
