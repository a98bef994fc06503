"""The part of a step that depends on the parameters alone, evaluated once before the time loop."""

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, TypeAlias

import jax
import jax.core
import numpy as np
from jax.extend.core import Jaxpr, JaxprEqn, Literal, Var

Step: TypeAlias = Callable[[Any, Any], tuple[Any, Any]]
"""From a state and a sample to the next state and an output."""

Swap: TypeAlias = tuple[Callable[..., Any], tuple[int, ...]]
"""A function that may take another's place, and the number of axes of each of its arguments."""

MOVES = frozenset(
    ("broadcast_in_dim", "reshape", "squeeze", "slice", "convert_element_type", "iota", "transpose")
)
"""Operations that a loop does for nothing, while their results would have to be read."""
_ARRAYS = (jax.Array, np.ndarray, jax.ShapeDtypeStruct)


def invariant(
    step: Callable[[Any, Any, Any], tuple[Any, Any]],
    params: Any,
    state: Any,
    sample: Any,
    swapped: Mapping[str, Swap] | None = None,
) -> Step:
    """A step with all that follows from its parameters alone done already.

    XLA does the same in a pass, but the derivative of a product that stands in a loop is summed
    there as well: of G Q G' two products a sample, where one after the loop is enough.

    Args:
        step: a filter's, with the parameters first.
        params: the parameters, any pytree.
        state: one state, or its shapes.
        sample: one sample's inputs, or their shapes.
        swapped: as of :func:`split`.

    >>> import jax.numpy as jnp
    >>> step = lambda p, s, u: (s * jnp.exp(p) + u, s)
    >>> once = invariant(step, jnp.array(0.0), jnp.zeros(()), jnp.zeros(()))
    >>> float(once(jnp.array(1.0), jnp.array(2.0))[0])
    3.0
    """
    before, rest = split(step, params, state, sample, swapped)
    return partial(rest, before(params))


def split(
    step: Callable[[Any, Any, Any], tuple[Any, Any]],
    params: Any,
    state: Any,
    sample: Any,
    swapped: Mapping[str, Swap] | None = None,
) -> tuple[Callable[[Any], list[Any]], Callable[[list[Any], Any, Any], tuple[Any, Any]]]:
    """A step in two: what follows from the parameters alone, and the rest.

    Args:
        step: a filter's, with the parameters first.
        params: the parameters, any pytree, or their shapes.
        state: one state, or its shapes.
        sample: one sample's inputs, or their shapes.
        swapped: functions that take the place of functions with a derivative of their own
            (``jax.custom_jvp``) of these names, where the arguments have as many axes as told:
            of filters side by side they have more.

    Returns:
        A function from parameters to arrays, and one from these, a state and a sample to the next
        state and an output.
    """
    leaves, tree = jax.tree.flatten(params)
    arrays = [i for i, leaf in enumerate(leaves) if isinstance(leaf, _ARRAYS)]

    def of(given: list[Any], state: Any, sample: Any) -> tuple[Any, Any]:
        filled = list(leaves)
        for i, leaf in zip(arrays, given, strict=True):
            filled[i] = leaf
        return step(jax.tree.unflatten(tree, filled), state, sample)

    given = [leaves[i] for i in arrays]
    closed, shapes = jax.make_jaxpr(of, return_shape=True)(given, state, sample)
    jaxpr, answer = closed.jaxpr, jax.tree.structure(shapes)
    fixed, varying = jaxpr.invars[: len(given)], jaxpr.invars[len(given) :]
    early, after = _parted(jaxpr, [*jaxpr.constvars, *fixed])
    inner = _part(jaxpr, [*early.outvars, *varying], after, jaxpr.outvars)

    def before(params: Any) -> list[Any]:
        own = jax.tree.leaves(params)
        return list(jax.core.eval_jaxpr(early, (), *closed.consts, *(own[i] for i in arrays)))

    def rest(known: list[Any], state: Any, sample: Any) -> tuple[Any, Any]:
        flat = _done(inner, [*known, *jax.tree.leaves((state, sample))], swapped or {})
        found: tuple[Any, Any] = jax.tree.unflatten(answer, flat)
        return found

    return before, rest


def _done(jaxpr: Jaxpr, given: list[Any], swapped: Mapping[str, Swap]) -> list[Any]:
    """The results of a formula, with functions put in the place of others."""
    values: dict[Var, Any] = dict(zip(jaxpr.invars, given, strict=True))

    def value(atom: Any) -> Any:
        return atom.val if isinstance(atom, Literal) else values[atom]

    for eqn in jaxpr.eqns:
        arguments = [value(atom) for atom in eqn.invars]
        other, axes = swapped.get(_name(eqn), (None, ()))
        if other is not None and axes == tuple(map(np.ndim, arguments)):
            found = jax.tree.leaves(other(*arguments))
        else:
            variables = list(dict.fromkeys(_variables(eqn.invars)))
            alone = _part(jaxpr, variables, [eqn], eqn.outvars)
            found = jax.core.eval_jaxpr(alone, (), *(values[v] for v in variables))
        values.update(zip(eqn.outvars, found, strict=True))
    return [value(atom) for atom in jaxpr.outvars]


def _name(eqn: JaxprEqn) -> str:
    if eqn.primitive.name != "custom_jvp_call":
        return ""
    name: str = eqn.params["call_jaxpr"].jaxpr.debug_info.func_name
    return name


def _parted(jaxpr: Jaxpr, known: list[Var]) -> tuple[Jaxpr, list[JaxprEqn]]:
    """The operations before the loop and those in it; both hold moves of data that both need."""
    fixed = set(known)
    early: list[JaxprEqn] = []
    late: list[JaxprEqn] = []
    for eqn in jaxpr.eqns:
        if not eqn.effects and all(isinstance(v, Literal) or v in fixed for v in eqn.invars):
            fixed.update(eqn.outvars)
            early.append(eqn)
        else:
            late.append(eqn)
    wanted = {v for eqn in late for v in _variables(eqn.invars)} | set(_variables(jaxpr.outvars))
    needed: set[Var] = set()
    before: list[JaxprEqn] = []
    for eqn in reversed(early):
        if eqn.primitive.name in MOVES and not wanted.isdisjoint(eqn.outvars):
            late.insert(0, eqn)
            wanted |= set(_variables(eqn.invars))
            wanted -= set(eqn.outvars)
        if not (needed | wanted).isdisjoint(eqn.outvars):
            before.insert(0, eqn)
            needed |= set(_variables(eqn.invars))
    handed = [v for v in (*known, *(v for eqn in before for v in eqn.outvars)) if v in wanted]
    return _part(jaxpr, known, before, handed), late


def _part(jaxpr: Jaxpr, invars: Any, eqns: list[JaxprEqn], outvars: Any) -> Jaxpr:
    info = jaxpr.debug_info.with_unknown_names()
    part: Jaxpr = jaxpr.replace(
        constvars=[], invars=list(invars), eqns=eqns, outvars=list(outvars), debug_info=info
    )
    return part


def _variables(atoms: Iterable[Any]) -> list[Var]:
    return [v for v in atoms if not isinstance(v, Literal)]
