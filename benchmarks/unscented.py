"""The unscented and the iterated filter beside the extended one, of 2, 5 and 9 states."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from benchmarks.table import Row, duration
from benchmarks.timing import Call, Times, interleave
from filters import AnyFilter, ExtendedKalman, ExtendedModel, ExtendedSample, UnscentedKalman, run

PART = "Unscented and iterated beside extended"
SIZES, SAMPLES, ROUNDS = (2, 5, 9), 5000, 25
AGREED = 0.5  # rad; further apart they would not do the same work
SPRING, GRADIENT = 0.05, "gradient, "
NOISE = np.array([0.01, 0.5])
"""Variance of the state's noise per sample, and of a measurement."""


def rows() -> list[Row]:
    """A pass and a gradient by two numbers, of every size."""
    return [row for n in SIZES for row in _of(n)]


def filters() -> dict[str, AnyFilter]:
    """The filters to time."""
    model = swung, shaken, seen
    return {
        "extended": ExtendedKalman(*model),
        "unscented": UnscentedKalman(*model),
        "iterated 3 times": ExtendedKalman(*model, iterations=3),
    }


def swung(p: Array, x: Array, u: Any) -> Array:
    """A ring of overdamped pendulums, each pulled by the next."""
    return x + SPRING * (jnp.roll(x, -1) - x - jnp.sin(x))


def shaken(p: Array, x: Array, u: Any) -> Array:
    """Independent noises."""
    return p[0] * jnp.eye(len(x), dtype=x.dtype)


def seen(p: Array, x: Array, u: Any) -> Array:
    """Every other one from the side."""
    return jnp.sin(x[::2]) + 0.3 * x[::2]


def record(n: int) -> ExtendedSample:
    """Measurements of n pendulums, ``(SAMPLES, (n + 1) // 2)``."""
    rng, x, z = np.random.default_rng(n), np.zeros(n), []
    for _ in range(SAMPLES):
        x = x + SPRING * (np.roll(x, -1) - x - np.sin(x)) + 0.1 * rng.standard_normal(n)
        z.append(np.sin(x[::2]) + 0.3 * x[::2] + np.sqrt(0.5) * rng.standard_normal((n + 1) // 2))
    return ExtendedSample(jnp.asarray(np.array(z)))


def passed(filter: AnyFilter, n: int, noise: Array, inputs: ExtendedSample) -> Array:
    """The estimates, ``(N, n)``."""
    R = jnp.full((n + 1) // 2, 1.0) * noise[1]
    found: Array = run(filter, ExtendedModel(noise, R, jnp.zeros(n), jnp.eye(n)), inputs)[1].x
    return found


def evaluations(n: int) -> dict[str, Call]:
    """Passes, and sums over their squares with two derivatives."""
    inputs, noise, every = record(n), jnp.asarray(NOISE), jnp.eye(2)
    calls: dict[str, Call] = {}
    for name, filter in filters().items():
        one = partial(passed, filter, n)

        def slopes(noise: Array, inputs: ExtendedSample, one: Any = one) -> Any:
            power = lambda at: (one(at, inputs) ** 2).sum()  # noqa: E731
            by = lambda way: jax.jvp(power, (noise,), (way,))  # noqa: E731
            return jax.vmap(by, out_axes=(None, 0))(every)

        calls[name] = partial(jax.jit(one), noise, inputs)
        calls[f"{GRADIENT}{name}"] = partial(jax.jit(slopes), noise, inputs)
    return calls


def _of(n: int) -> list[Row]:
    calls = evaluations(n)
    apart = np.abs(np.asarray(calls["unscented"]()) - np.asarray(calls["extended"]())).max()
    if not apart <= AGREED:
        raise AssertionError(f"unscented and extended filter differ by {apart:.2g}")
    times = interleave(calls, ROUNDS)
    return [_row(times, name, n) for name in calls if not name.endswith("extended")]


def _row(times: Times, name: str, n: int) -> Row:
    base = f"{GRADIENT}extended" if name.startswith(GRADIENT) else "extended"
    ratio = times.ratio(name, base)
    return Row(
        part=PART,
        what=f"{name}, {n} states",
        ours=f"{duration(times.median(name) / SAMPLES)} a sample",
        against=f"extended: {duration(times.median(base) / SAMPLES)}",
        figure=ratio.median,
        best=ratio.best,
    )
