"""Steady-state equations in batches, against scipy one after another."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import scipy.linalg

from benchmarks.table import Row, duration
from benchmarks.timing import interleave
from objectives import dare, lyapunov

PART = "A thousand steady-state equations, n = 3"
COUNT, STATES = 1000, 3
TARGET = 20.0  # ms for the batch
AGREED = 1e-6  # of the largest entry: scipy's accuracy in the worst of a thousand random models
WHY = "the target is in milliseconds of an otherwise idle machine"

Solve = Callable[..., jax.Array]


def rows() -> list[Row]:
    """Ours with gradients in ms for the batch, and scipy without against ours without."""
    F, H, Q, R = _models()
    A = F - 2.5 * np.eye(STATES)
    riccati = lambda F, H, Q, R: scipy.linalg.solve_discrete_are(F.T, H.T, Q, R)  # noqa: E731
    sylvester = lambda A, Q: scipy.linalg.solve_continuous_lyapunov(A, -Q)  # noqa: E731
    return [
        *_pair("DAREs", dare, riccati, (F, H, Q, R)),
        *_pair("Lyapunov equations", lyapunov, sylvester, (A, Q)),
    ]


def _models() -> tuple[np.ndarray, ...]:
    draw = np.random.default_rng(0)
    F, B = draw.standard_normal((2, COUNT, STATES, STATES))
    F *= (draw.uniform(0.3, 1.2, COUNT) / np.abs(np.linalg.eigvals(F)).max(axis=1))[:, None, None]
    H, R = draw.standard_normal((COUNT, 1, STATES)), np.exp(draw.standard_normal((COUNT, 1, 1)))
    return F, H, B @ B.transpose(0, 2, 1), R


def _pair(
    name: str, ours: Solve, theirs: Callable[..., np.ndarray], model: tuple[np.ndarray, ...]
) -> list[Row]:
    values = jax.jit(jax.vmap(ours))
    every = tuple(range(len(model)))
    trace = jax.value_and_grad(lambda *one: jnp.trace(ours(*one)), argnums=every)
    gradients = jax.jit(jax.vmap(trace))
    loop = lambda: np.array([theirs(*one) for one in zip(*model, strict=True)])  # noqa: E731
    expected = loop()
    size = np.abs(expected).max(axis=(1, 2), keepdims=True)
    difference = float((np.abs(np.asarray(values(*model)) - expected) / size).max())
    if not difference <= AGREED:
        raise AssertionError(f"{name} differ from scipy's by {difference:.1g} of their size")
    calls = {
        "gradients": lambda: gradients(*model),
        "values": lambda: values(*model),
        "scipy": loop,
    }
    times = interleave(calls, 5, {"gradients": 5, "values": 5})
    ratio = times.ratio("scipy", "values")
    note = f"values differ by {difference:.1g} of their size at most"
    return [
        Row(
            part=PART,
            what=f"{name} with gradients",
            ours=duration(times.median("gradients")),
            figure=1e3 * times.median("gradients"),
            best=1e3 * times.best("gradients"),
            unit="ms",
            target=TARGET,
            note=note,
            why=WHY,
        ),
        Row(
            part=PART,
            what=f"{name}, values",
            ours=duration(times.median("values")),
            against=f"scipy one by one: {duration(times.median('scipy'))}",
            figure=ratio.median,
            best=ratio.best,
        ),
    ]
