"""One abstract evaluation of a filter, by shapes alone: mistakes are told before anything runs.

Nothing is computed and nothing is compiled. A filter is tried once for the shapes of its
parameters and its inputs, however many problems it is in.
"""

from functools import lru_cache
from inspect import signature
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from filters import Lanes, bare
from tuner.problem.facts import check_frozen
from tuner.problem.mistakes import described, told
from tuner.problem.model_shapes import check_model
from tuner.problem.stepped import check_operations, check_outputs, check_state


def try_out(name: str, filter: Any, build: Any, space: Any, inputs: Any) -> None:
    """Refuse a filter, parameters or inputs that the time loop cannot take.

    Args:
        name: of the problem.
        filter: the filter.
        build: from values by name to its parameters.
        space: the parameters.
        inputs: what it runs over, time first.

    Raises:
        ValueError: one sentence: which method of which class, what, and the way out.
    """
    check_class(filter)
    try:
        z = jax.ShapeDtypeStruct((space.size,), jnp.float64)
        params = jax.eval_shape(lambda at: build(space.constrain(at)), z)
    except Exception as error:
        raise told(f"the parameters of {name}", error) from error
    check_model(name, params)
    if isinstance(filter, Lanes):
        filter, inputs = filter.filter, jax.tree.map(lambda leaf: leaf[:, 0], inputs)
    sample = jax.tree.map(lambda leaf: _one(name, leaf), inputs)
    leaves, kind = jax.tree.flatten((params, sample))
    _tried(filter, tuple(leaves), kind)


def check_class(filter: Any) -> None:
    """Refuse what is no filter, or one that cannot stand for a compilation.

    Raises:
        ValueError: one sentence.
    """
    if isinstance(filter, type):
        raise ValueError(f"{filter.__name__} is a class; give a filter of it, {filter.__name__}()")
    cls = type(filter)
    check_frozen(cls)
    for method, given in (("init", ("params",)), ("step", ("params", "state", "inputs"))):
        _check_method(cls.__name__, filter, method, given)
    try:
        hash(filter)
    except TypeError:
        raise ValueError(_unhashable(filter)) from None


def _check_method(name: str, filter: Any, method: str, given: tuple[str, ...]) -> None:
    write = f"write def {method}(self, {', '.join(given)})"
    if not callable(getattr(filter, method, None)):
        raise ValueError(f"{name} has no method {method}; {write}")
    own = signature(getattr(filter, method))
    try:
        own.bind(*given)
    except TypeError:
        raise ValueError(
            f"{name}.{method} takes {own}, and the time loop gives it {' and '.join(given)}; "
            f"{write}"
        ) from None


def _unhashable(filter: Any) -> str:
    """Which field it is that cannot be hashed."""
    cls = type(filter).__name__
    for field in getattr(filter, "__dataclass_fields__", {}):
        value = getattr(filter, field)
        try:
            hash(value)
        except TypeError:
            return (
                f"the field {field} of {cls} holds a {type(value).__name__}, which is no key of a "
                "compilation; make it a tuple, or a parameter if it is an array"
            )
    return f"{cls} cannot be hashed, so no compilation can be kept for it; leave out its __eq__"


def _one(name: str, leaf: Any) -> jax.ShapeDtypeStruct:
    """One sample of an input, by its shape."""
    shape, dtype = np.shape(leaf), getattr(leaf, "dtype", np.asarray(leaf).dtype)
    if not shape:
        raise ValueError(
            f"the inputs of {name} hold a single number, and time is their first axis; give an "
            "array (N, ...)"
        )
    return jax.ShapeDtypeStruct(shape[1:], dtype)


@lru_cache(maxsize=256)
def _tried(filter: Any, leaves: tuple[Any, ...], kind: Any) -> None:
    params, sample = jax.tree.unflatten(kind, leaves)
    name = type(bare(filter)).__name__
    try:
        state = jax.eval_shape(filter.init, params)
    except Exception as error:
        raise told(f"{name}.init", error) from error
    try:
        jaxpr, after = jax.make_jaxpr(filter.step, return_shape=True)(params, state, sample)
    except Exception as error:
        raise told(f"{name}.step", error) from error
    if not isinstance(after, tuple) or hasattr(after, "_fields") or len(after) != 2:
        raise ValueError(
            f"{name}.step returns {described(after)}; return the two (state, outputs) as a tuple"
        )
    check_state(name, state, after[0])
    check_outputs(name, filter, after[1])
    check_operations(name, jaxpr)
