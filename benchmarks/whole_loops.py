"""A check that time loops are compiled as a whole: ``python -m benchmarks.whole_loops``.

A loop that XLA does not compile as a whole is interpreted operation by operation, with the same
results. The compiled text shows which it is, so nothing has to be timed. The check takes the cases
that break first: a gradient at one point, and at 8 and 64 side by side.
"""

import sys
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import (
    AnyFilter,
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    LinearKalman,
    LinearModel,
    Sample,
    Transition,
)
from objectives import Data, InnovationLikelihood, Way, score, score_and_gradient

WHOLE = "xla_cpu_small_call"
"""XLA's name for a loop that it compiles as a whole."""
LANES = (8, 64)
QUICKLY = {"xla_backend_optimization_level": 0}
"""The compiled code is not run, and loops are chosen before it is optimised."""
Built = Callable[[Array], Any]


def interpreted(function: Callable[..., Any], *given: Any) -> bool:
    """Whether a function's time loop would be interpreted."""
    text = jax.jit(function).lower(*given).compile(compiler_options=QUICKLY).as_text()
    return WHOLE not in text and " while(" in text


def large() -> Iterator[tuple[str, bool]]:
    """Of filters large enough to lose their loops: their names, and whether they did."""
    for n, filter, build, inputs in (_linear(4), _linear(9), _extended(9)):
        name = f"{type(filter).__name__} of {n} states"
        yield from ((f"{name}, {what}", lost) for what, lost in _of(filter, build, inputs))


def _of(filter: AnyFilter, build: Built, inputs: Any) -> Iterator[tuple[str, bool]]:
    likelihood, data, point = InnovationLikelihood(), Data(inputs, jnp.zeros(3)), jnp.zeros(2)

    def gradient(at: Array, way: Way) -> Any:
        return score_and_gradient(filter, likelihood, build, at, data, way=way)

    yield "value", interpreted(lambda at: score(filter, likelihood, build(at), data), point)
    yield "gradient backwards", interpreted(partial(gradient, way="backwards"), point)
    side_by_side = jax.vmap(partial(gradient, way="forwards"))
    yield "64 gradients", interpreted(side_by_side, jnp.zeros((64, 2)))


def battery() -> Iterator[tuple[str, bool]]:
    """Of every filter in tests/filters/battery.py."""
    from filters import run
    from tests.filters.battery import CASES

    for case in CASES:
        inputs = case.inputs(case.measured)

        def total(point: Array, case: Any = case, inputs: Any = inputs) -> Array:
            leaves = jax.tree.leaves(run(case.filter, case.build(point), inputs)[1])
            numbers = [leaf for leaf in leaves if jnp.issubdtype(leaf.dtype, jnp.floating)]
            return jnp.stack([jnp.nansum(leaf) for leaf in numbers]).sum()

        gradient, point = _forwards(total), jnp.asarray(case.point)
        yield f"{case.name}, gradient", interpreted(gradient, point)
        for lanes in LANES:
            points = jnp.broadcast_to(point, (lanes, *point.shape))
            yield f"{case.name}, {lanes} gradients", interpreted(jax.vmap(gradient), points)


def _forwards(function: Callable[[Array], Array]) -> Callable[[Array], Any]:
    def both(point: Array) -> Any:
        along = jnp.eye(point.shape[-1])
        return jax.vmap(lambda way: jax.jvp(function, (point,), (way,)))(along)

    return both


def _linear(n: int) -> tuple[int, AnyFilter, Built, Any]:
    def build(at: Array) -> LinearModel:
        q, r = jnp.exp(at)
        step = Transition(jnp.asarray(_coupled(n)), jnp.eye(n), q * jnp.eye(n))
        return LinearModel(step, jnp.eye(2, n), r * jnp.ones(2), jnp.eye(n), jnp.zeros(n))

    return n, LinearKalman(), build, Sample(jnp.zeros((3, 2)))


def _extended(n: int) -> tuple[int, AnyFilter, Built, Any]:
    def build(at: Array) -> ExtendedModel:
        q, r = jnp.exp(at)
        return ExtendedModel(q, r * jnp.ones(2), jnp.zeros(n), jnp.eye(n))

    return n, ExtendedKalman(_swung, _shaken, _seen), build, ExtendedSample(jnp.zeros((3, 2)))


def _coupled(n: int) -> np.ndarray:
    return np.eye(n) + 0.1 * np.eye(n, k=1) - 0.05 * np.eye(n, k=-1)


def _swung(q: Array, x: Array, u: Any) -> Array:
    return jnp.asarray(_coupled(len(x))) @ jnp.sin(x)


def _shaken(q: Array, x: Array, u: Any) -> Array:
    return q * jnp.eye(len(x))


def _seen(q: Array, x: Array, u: Any) -> Array:
    return jnp.sin(x[:2])


def main() -> int:
    """Print what is interpreted, and return the exit code."""
    wrong = [name for found in (large(), battery()) for name, lost in found if lost]
    for name in wrong:
        print(f"{name}: its time loop is interpreted", file=sys.stderr)
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
