"""Values and gradients of Kalman filters by size: against C, forwards and backwards.

What is measured here is what `tuner.problem.paths` chooses by.
"""

import ctypes
from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from benchmarks.baseline import Baseline, compiled
from benchmarks.by_c import native
from benchmarks.table import Row, duration
from benchmarks.timing import Call, Times, interleave
from benchmarks.unscented import record, swung
from benchmarks.unscented import seen as seen_from_the_side
from filters import (
    AnyFilter,
    ExtendedKalman,
    ExtendedModel,
    LinearKalman,
    LinearModel,
    Sample,
    Transition,
)
from objectives import Data, InnovationLikelihood, Way, score, score_and_gradient
from tuner import Positive, Problem, Space
from tuner.compiler import NoCodeError, compiler

PART = "Likelihoods of Kalman filters and their gradients"
LINEAR = ((4, 2, 1.7, 2.0), (9, 3, 1.3, 1.5), (15, 3, 1.0, 1.2), (24, 6, 1.6, 1.6))
"""States, measurements, and what a value and a gradient may take over C."""
EXTENDED = (5, 9)
FEW = (1, 2, 4)
SAMPLES, LONG, ROUNDS = 3000, 30_000, 25
AGREED = 1e-9
WHY = "C by hand leaves out Joseph's form and missing samples"


def rows(limit: Baseline | None) -> list[Row]:
    """Linear filters against C in all parameters; both ways by the number of parameters."""
    found = []
    for n, m, most_value, most_gradient in LINEAR:
        found += _against_c(n, m, most_value, most_gradient) if limit is not None else []
    for n, m, *_ in LINEAR[:3]:
        found += _both_ways(f"linear, {n} states", partial(linear, n, m), "backwards", n + m)
    for n in EXTENDED:
        found.append(_over_a_pass(n))
        made = partial(extended, n)
        found += _both_ways(f"extended, {n} states", made, "backwards in parts", n + 2)
    return found


def linear(n: int, m: int, free: int) -> tuple[AnyFilter, Callable[[Array], Any], Any]:
    """Coupled damped oscillators, by logarithms of the variances of their noise."""
    F, H, z = oscillators(n, m)

    def build(at: Array) -> LinearModel:
        every = jnp.exp(jnp.concatenate([at, jnp.zeros(n + m - free)]))
        step = Transition(jnp.asarray(F), jnp.eye(n), jnp.diag(every[:n]))
        return LinearModel(step, jnp.asarray(H), every[n:], jnp.eye(n), jnp.zeros(n))

    return LinearKalman(), build, Sample(jnp.asarray(z))


def extended(n: int, free: int) -> tuple[AnyFilter, Callable[[Array], Any], Any]:
    """The pendulums of :mod:`benchmarks.unscented`, each shaken by itself."""
    inputs = record(n)
    m = inputs.z.shape[1]

    def build(at: Array) -> ExtendedModel:
        every = jnp.exp(jnp.concatenate([at, jnp.zeros(n + 2 - free)]))
        R = every[n] * jnp.ones(m)
        return ExtendedModel(every[:n] * 1e-2, R, jnp.zeros(n), jnp.eye(n) * every[n + 1])

    return ExtendedKalman(swung, _each_shaken, seen_from_the_side), build, inputs


def oscillators(n: int, m: int, samples: int = SAMPLES) -> tuple[np.ndarray, ...]:
    """Transition, measurement rows and a record ``(samples, m)``."""
    rng = np.random.default_rng(n)
    F = np.diag(np.full(n, 0.97)) + 0.2 * (np.eye(n, k=1) - np.eye(n, k=-1))
    mixed = np.eye(n) + 0.3 * rng.standard_normal((n, n)) / np.sqrt(n)
    F = 0.98 * mixed @ F @ np.linalg.inv(mixed) / max(1.0, np.abs(np.linalg.eigvals(F)).max())
    H, x, z = rng.standard_normal((m, n)), np.zeros(n), np.empty((samples, m))
    for k in range(samples):
        x = F @ x + rng.standard_normal(n)
        z[k] = H @ x + rng.standard_normal(m)
    return F, H, z


def problem(n: int, m: int, samples: int = SAMPLES) -> Problem:
    """The same in all variances."""
    F, H, z = oscillators(n, m, samples)
    names = [f"v{k}" for k in range(n + m)]

    def build(values: dict[str, Array]) -> LinearModel:
        every = jnp.stack([values[name] for name in names])
        step = Transition(jnp.asarray(F), jnp.eye(n), jnp.diag(every[:n]))
        return LinearModel(step, jnp.asarray(H), every[n:], jnp.eye(n), jnp.zeros(n))

    space = Space.of(**{name: Positive(1.0, 1e-3, 1e3) for name in names})
    data = Data(Sample(z), np.zeros(len(z)))
    return Problem(
        "oscillators", space, LinearKalman(), build, InnovationLikelihood(), data, steady=False
    )


def by_c(n: int, m: int, samples: int = SAMPLES) -> dict[str, Callable[[], Any]]:
    """Its value and its gradient as a search evaluates them, by compiled C.

    Raises:
        NoCodeError: where there is none.
    """
    compiler()
    one = problem(n, m, samples)
    z = one.space.start()
    with native("on"):
        one.value_and_gradient(z)
        one.value(z)
    if not one.route.choice.startswith("C, "):
        raise AssertionError(f"the gradient of {n} states goes by {one.route.choice}")
    return {"value": lambda: one.value(z), "gradient": lambda: one.value_and_gradient(z)}


def in_c(n: int, m: int, samples: int = SAMPLES) -> dict[str, Callable[[], np.ndarray]]:
    """The same in C at variances of 1: value, and value with derivatives by their logarithms."""
    library = compiled(("kalman.c",), ("-ffast-math", f"-DSTATES={n}", f"-DROWS={m}"))
    F, H, z = (np.ascontiguousarray(a) for a in oscillators(n, m, samples))
    q, r, kept, out = np.ones(n), np.ones(m), np.empty(samples * m * (n + 2)), np.empty(1 + n + m)
    given = [
        ctypes.c_size_t(samples),
        *(a.ctypes.data_as(ctypes.c_void_p) for a in (F, H, q, r, z)),
    ]
    room, result = (a.ctypes.data_as(ctypes.c_void_p) for a in (kept, out))

    def value() -> np.ndarray:
        library.kalman_value(*given, result)
        return out[:1] / (2 * z.size) + np.log(2 * np.pi) / 2

    def gradient() -> np.ndarray:
        library.kalman_gradient(*given, room, result)
        return out / (2 * z.size) + np.log(2 * np.pi) / 2 * (np.arange(1 + n + m) == 0)

    return {"C, value": value, "C, gradient": gradient}


def _each_shaken(q: Array, x: Array, u: Any) -> Array:
    return jnp.diag(q)


def _calls(filter: AnyFilter, build: Any, inputs: Any, free: int) -> dict[str, Call]:
    likelihood, at = InnovationLikelihood(), jnp.zeros(free)
    data = Data(inputs, jnp.zeros(len(inputs.z)))

    @jax.jit
    def value(at: Array, data: Data) -> Array:
        return score(filter, likelihood, build(at), data)

    def gradient(way: Way) -> Call:
        both = jax.jit(
            lambda at, data: score_and_gradient(filter, likelihood, build, at, data, way=way)
        )
        return partial(both, at, data)

    return {
        "value": partial(value, at, data),
        "forwards": gradient("forwards"),
        "backwards": gradient("backwards"),
        "backwards in parts": gradient("backwards in parts"),
    }


def gradient_call(n: int, m: int) -> Call:
    """The gradient of a linear filter in the variances of all its noise."""
    return _calls(*linear(n, m, n + m), n + m)["backwards"]


def over_c(n: int, m: int, rounds: int = 25) -> tuple[float, float]:
    """The time of a value and of a gradient in all parameters, each over C's.

    It is the ratio of the shortest times by the clock: others move by half with what else the
    machine does, and processor time of a thread that has just ended may not be counted yet.
    """
    calls = _calls(*linear(n, m, n + m), n + m)
    ours = {name: calls[name] for name in ("value", "backwards")}
    times = interleave(ours | in_c(n, m), rounds)
    return times.ratio("value", "C, value").best, times.ratio("backwards", "C, gradient").best


def c_over_c(n: int, m: int, rounds: int = 25) -> tuple[float, float]:
    """The same of C that the product compiles.

    Raises:
        NoCodeError: where there is none.
    """
    ours = {f"ours, {name}": call for name, call in by_c(n, m).items()}
    times = interleave(ours | in_c(n, m), rounds)
    return times.ratio("ours, value", "C, value").best, times.ratio(
        "ours, gradient", "C, gradient"
    ).best


def _against_c(n: int, m: int, most_value: float, most_gradient: float) -> list[Row]:
    calls = _calls(*linear(n, m, n + m), n + m)
    c = in_c(n, m)
    value, slope = calls["backwards"]()  # type: ignore[misc]
    wanted = c["C, gradient"]()
    apart = np.abs(np.array([value, *slope]) - wanted).max() / np.abs(wanted[1:]).max()
    if not apart <= AGREED:
        raise AssertionError(f"the gradient of {n} states differs from C's by {apart:.2g}")
    times = interleave({name: calls[name] for name in ("value", "backwards")} | c, ROUNDS)
    whole = ("value", "C, value"), ("backwards", "C, gradient")
    found = [_row(times, f"{n} states, {name}", name, against, None) for name, against in whole]
    return found + _by_c_against_c(n, m, most_value, most_gradient)


def _by_c_against_c(n: int, m: int, most_value: float, most_gradient: float) -> list[Row]:
    """Both as the product computes them where a compiler is found, over C by hand."""
    try:
        ours = by_c(n, m, LONG)
    except NoCodeError as error:
        return [Row(PART, f"{n} states, by compiled C", note=str(error))]
    calls = {f"ours, {name}": call for name, call in ours.items()}
    times = interleave(calls | in_c(n, m, LONG), ROUNDS)
    return [
        _row(times, f"{n} states, {name} by C", f"ours, {name}", f"C, {name}", most, LONG)
        for name, most in (("value", most_value), ("gradient", most_gradient))
    ]


def _both_ways(name: str, made: Callable[[int], Any], back: Way, every: int) -> list[Row]:
    found = []
    for free in (*FEW, every):
        calls = _calls(*made(free), free)
        times = interleave({way: calls[way] for way in ("forwards", back)}, ROUNDS)
        found.append(_row(times, f"{name}, {free} parameters: forwards", "forwards", back, None))
    return found


def _over_a_pass(n: int) -> Row:
    """The choice for an extended filter with 12 parameters, or with all of its own."""
    free = min(12, n + 2)
    calls = _calls(*extended(n, free), free)
    times = interleave({name: calls[name] for name in ("value", "backwards in parts")}, ROUNDS)
    what = f"extended, {n} states, {free} parameters: gradient"
    return _row(times, what, "backwards in parts", "value", 4.0)


def _row(
    times: Times,
    what: str,
    name: str,
    against: str,
    target: float | None,
    samples: int = SAMPLES,
) -> Row:
    ratio = times.ratio(name, against).best  # others move with what else the machine does
    return Row(
        part=PART,
        what=what,
        ours=f"{duration(times.best(name) / samples)} a sample",
        against=f"{against}: {duration(times.best(against) / samples)}",
        figure=ratio,
        best=ratio,
        target=target,
        why=WHY if target is not None else "",
    )


def main() -> None:
    """Print the table."""
    from rich.console import Console

    from benchmarks.baseline import baseline
    from benchmarks.table import markdown, show

    measured = rows(baseline())
    show(measured, Console(width=150))
    print(markdown(measured))


if __name__ == "__main__":
    main()
