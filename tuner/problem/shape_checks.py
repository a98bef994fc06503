"""One abstract evaluation of a filter, by shapes alone, which finds mistakes before it runs.

Nothing is computed and nothing is compiled. A filter is tried once for the shapes of its
parameters and its inputs, whatever the number of its problems.
"""

from functools import lru_cache
from inspect import signature
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from filters import Lanes, bare
from objectives import Data, is_fold
from tuner.problem.facts import check_frozen
from tuner.problem.mistakes import described, refusal
from tuner.problem.model_shapes import check_model
from tuner.problem.step_checks import check_operations, check_outputs, check_state


def check_shapes(
    name: str, filter: Any, build: Any, space: Any, objective: Any, data: Data
) -> None:
    """Refuse a filter, parameters, inputs or a truth that the time loop cannot take.

    Args:
        name: of the problem.
        filter: the filter.
        build: from values by name to its parameters.
        space: the parameters.
        objective: the objective that judges its outputs.
        data: its inputs and the truth with which its outputs are compared, time first.

    Raises:
        ValueError: one sentence: which method of which class, what, and the way out.
    """
    check_class(filter)
    _check_objective(objective)
    params = _params(name, build, space)
    check_model(name, params)
    lanes = (filter.count,) if isinstance(filter, Lanes) else ()
    alone: Any = filter.filter if isinstance(filter, Lanes) else filter
    sample = jax.tree.map(lambda leaf: _one(name, leaf, len(lanes)), data.inputs)
    leaves, kind = jax.tree.flatten((params, sample))
    outputs = _tried(alone, tuple(leaves), kind)
    each = jax.tree.map(lambda one: _behind(lanes, one), outputs)
    samples = tuple(np.shape(leaf)[:1] for leaf in jax.tree.leaves(data.inputs)[:1])
    judged, kept = jax.tree.flatten((each, jax.tree.map(_whole, data.truth)))
    _judged(type(bare(filter)).__name__, objective, sum(samples, ()), tuple(judged), kept)


def _params(name: str, build: Any, space: Any) -> Any:
    """The filter's parameters, by their shapes."""
    try:
        z = jax.ShapeDtypeStruct((space.size,), jnp.float64)
        return jax.eval_shape(lambda at: build(space.constrain(at)), z)
    except Exception as error:
        raise refusal(f"the parameters of {name}", error) from error


def check_class(filter: Any) -> None:
    """Refuse anything but a filter, or one that cannot be the key of a compilation.

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


def _check_objective(objective: Any) -> None:
    try:
        hash(objective)
    except TypeError:
        raise ValueError(_unhashable(objective)) from None


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
    """The message about the field that cannot be hashed."""
    cls = type(filter).__name__
    for field in getattr(filter, "__dataclass_fields__", {}):
        value = getattr(filter, field)
        try:
            hash(value)
        except TypeError:
            return (
                f"the field {field} of {cls} is a {type(value).__name__}, which cannot be hashed; "
                "make it a tuple, or a parameter if it is an array"
            )
    return f"{cls} cannot be hashed, so no compilation can be kept for it; leave out its __eq__"


def _one(name: str, leaf: Any, lanes: int = 0) -> jax.ShapeDtypeStruct:
    """One sample of an input of one recording, by its shape."""
    whole = _whole(leaf)
    if not whole.shape:
        raise ValueError(
            f"the inputs of {name} hold a single number, and time is their first axis; give an "
            "array (N, ...)"
        )
    return jax.ShapeDtypeStruct(whole.shape[1 + lanes :], whole.dtype)


def _whole(leaf: Any) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct(np.shape(leaf), getattr(leaf, "dtype", np.asarray(leaf).dtype))


def _behind(axes: tuple[int, ...], one: Any) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct(axes + one.shape, one.dtype)


@lru_cache(maxsize=256)
def _judged(
    name: str, objective: Any, many: tuple[int, ...], leaves: tuple[Any, ...], kind: Any
) -> None:
    """Refuse outputs and a truth that the objective cannot take."""
    outputs, truth = jax.tree.unflatten(kind, leaves)
    what = f"the objective {type(objective).__name__}"
    try:
        if is_fold(objective):
            sample = jax.tree.map(lambda leaf: _one(name, leaf), truth)
            total = jax.eval_shape(objective.init)
            jax.eval_shape(objective.update, total, outputs, sample)
            return
        what = f"the objective {getattr(objective, '__name__', type(objective).__name__)}"
        stacked = jax.tree.map(
            lambda one: jax.ShapeDtypeStruct(many + one.shape, one.dtype), outputs
        )
        value = jax.eval_shape(objective, stacked, truth)
    except Exception as error:
        shapes = {str(leaf.shape) for leaf in jax.tree.leaves(truth)}
        held = f", with outputs {described(outputs)} a sample and a truth of {', '.join(shapes)}"
        raise refusal(f"{what} on {name}{held if shapes else ''}", error) from error
    if getattr(value, "shape", None) != ():
        raise ValueError(
            f"{what} returns {described(value)}, and one number is needed; take its mean"
        )


@lru_cache(maxsize=256)
def _tried(filter: Any, leaves: tuple[Any, ...], kind: Any) -> Any:
    """The outputs of the filter in a sample, by their shapes."""
    params, sample = jax.tree.unflatten(kind, leaves)
    name = type(bare(filter)).__name__
    try:
        state = jax.eval_shape(filter.init, params)
    except Exception as error:
        raise refusal(f"{name}.init", error) from error
    try:
        jaxpr, after = jax.make_jaxpr(filter.step, return_shape=True)(params, state, sample)
    except Exception as error:
        raise refusal(f"{name}.step", error) from error
    if not isinstance(after, tuple) or hasattr(after, "_fields") or len(after) != 2:
        raise ValueError(
            f"{name}.step returns {described(after)}; return the two (state, outputs) as a tuple"
        )
    check_state(name, state, after[0])
    check_outputs(name, filter, after[1])
    check_operations(name, jaxpr)
    return after[1]
