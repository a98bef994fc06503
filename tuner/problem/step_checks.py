"""Checks of one step of a filter, by shapes alone, so that a time loop can run it."""

from typing import Any

import jax
import numpy as np

from filters import bare, channel_facts
from filters.declared import declaration
from tuner.problem.mistakes import described

NARROW = ("float16", "bfloat16", "float32")


def check_state(name: str, before: Any, after: Any) -> None:
    """Refuse a state whose structure or shapes differ after a sample."""
    if not _alike(before, after):
        raise ValueError(
            f"the state is {described(before)} after {name}.init and {described(after)} after "
            f"{name}.step; return the same tuple in both"
        )
    pairs = zip(jax.tree_util.tree_leaves_with_path(before), jax.tree.leaves(after), strict=True)
    for (path, first), then in pairs:
        part = f"the state{jax.tree_util.keystr(path)}"
        if first.shape != then.shape:
            raise ValueError(
                f"{part} has shape {first.shape} after {name}.init and {then.shape} after "
                f"{name}.step; give it one shape"
            )
        if first.dtype != then.dtype and not first.weak_type:
            raise ValueError(
                f"{part} is {first.dtype} after {name}.init and {then.dtype} after {name}.step; "
                f"begin with jnp.zeros({first.shape or ()}), which is float64, and keep to it"
            )
        if then.dtype.name in NARROW:
            raise ValueError(
                f"{part} of {name} is {then.dtype}, and a filter is tuned in float64; take the "
                "kind of the parameters, as in jnp.zeros(3, params.R.dtype)"
            )


def _alike(one: Any, other: Any) -> bool:
    first: Any = jax.tree.structure(one)
    return bool(first == jax.tree.structure(other))


def check_outputs(name: str, filter: Any, outputs: Any) -> None:
    """Refuse outputs that are not those declared."""
    if not hasattr(bare(filter), "outputs"):
        return
    declared, facts = declaration(filter, "outputs"), channel_facts(filter, "outputs")
    if not isinstance(declared, type):
        if len(facts) != 1 or not hasattr(outputs, "shape"):
            raise ValueError(
                f"{name} declares the outputs {', '.join(facts)} by a mapping, which is for one "
                f"Array alone, and step returns {described(outputs)}; declare a NamedTuple"
            )
        found = {next(iter(facts)): outputs}
    else:
        fields = getattr(declared, "_fields", ())
        lacking = [field for field in fields if not hasattr(outputs, field)]
        if lacking:
            raise ValueError(
                f"{name}.step returns {described(outputs)} as outputs, which has no "
                f"{', '.join(lacking)}; return the {declared.__name__} that is declared"
            )
        found = {field: getattr(outputs, field) for field in facts if hasattr(outputs, field)}
    for field, fact in facts.items():
        shape = getattr(found.get(field), "shape", None)
        if shape is None or not fact.axes:
            continue
        # A matrix may name its entries, or the axes of its rows and columns.
        if len(fact.axes) not in (int(np.prod(shape)), *shape[-1:]):
            raise ValueError(
                f"the output {field} of {name} declares {len(fact.axes)} axes "
                f"({', '.join(fact.axes)}), and step returns it in shape {shape}; declare the axes "
                "that there are"
            )
    _check_innovations(name, found)


def _check_innovations(name: str, found: dict[str, Any]) -> None:
    both: dict[str, Any] = {name: found.get(name) for name in ("innovation", "variance")}
    shapes = {name: one.shape for name, one in both.items() if hasattr(one, "shape")}
    if () in shapes.values() or len(set(shapes.values())) > 1:
        told_ = " and ".join(f"{n} in shape {shape}" for n, shape in shapes.items())
        raise ValueError(
            f"{name}.step returns {told_}, and both are (m,) for m measurements; write y[None] for "
            "one number, and the diagonal of a matrix"
        )


def check_operations(name: str, jaxpr: Any) -> None:
    """Refuse single precision and random numbers in the operations of a step."""
    for constant in jaxpr.consts:
        if isinstance(constant, jax.core.Tracer):
            raise ValueError(
                f"{name}.step takes a value of another evaluation, which was kept in a global or "
                "on an object; return it in the state"
            )
        if getattr(constant, "dtype", np.dtype(float)).name in NARROW:
            raise ValueError(
                f"{name}.step takes a constant {constant.dtype}{list(constant.shape)}, and a "
                "filter is tuned in float64; make it with dtype=float, after filters was imported"
            )
    for equation in _equations(jaxpr.jaxpr):
        primitive = equation.primitive.name
        if primitive.startswith(("random_", "threefry")):
            raise ValueError(
                f"{name}.step draws random numbers, and one key gives the same ones in every step; "
                "leave them out, or give them as an input"
            )
        for made in equation.outvars:
            if getattr(getattr(made.aval, "dtype", None), "name", "") in NARROW:
                raise ValueError(
                    f"{name}.step computes in {made.aval.dtype} ({primitive}), and a filter is "
                    "tuned in float64; leave out float32 and astype"
                )


def _equations(jaxpr: Any) -> Any:
    """All operations, including nested ones."""
    for equation in jaxpr.eqns:
        yield equation
        for inner in jax.tree.leaves(list(equation.params.values()), is_leaf=_is_jaxpr):
            if _is_jaxpr(inner):
                yield from _equations(getattr(inner, "jaxpr", inner))


def _is_jaxpr(thing: Any) -> bool:
    return hasattr(thing, "eqns") or hasattr(thing, "jaxpr")
