"""Likelihoods of long records: with constant gains where they have settled, against every step."""

import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from benchmarks.gradients import oscillators
from benchmarks.table import Row, duration
from benchmarks.timing import Call, Times, interleave
from filters import (
    AnyFilter,
    LevelSample,
    LinearKalman,
    LinearModel,
    LocalLevel,
    LocalLevelNoise,
    Sample,
    Settling,
    Transition,
)
from objectives import Data, InnovationLikelihood, Way, score, score_and_gradient
from tuner.native.compiled import Native

PART = "Long records with constant gains"
LENGTHS = (100_000, 1_000_000, 10_000_000)
ROUNDS = 5
AGREED = (1e-12, 1e-10)
"""Tolerance of a value, and of a gradient over its largest entry."""
Made = tuple[AnyFilter, Callable[[Array], Any], Any, int, Way]


def rows() -> list[Row]:
    """A local level up to 10^7 samples, and two larger filters up to 10^6; by XLA and by C."""
    found = [row for length in LENGTHS for row in _rows("local level", *_level(length), length)]
    for n, m in ((4, 2), (9, 3)):
        for length in LENGTHS[: 2 if n == 4 else 1]:
            found += _rows(f"{n} states", *_oscillating(n, m, length), length)
    for length in LENGTHS[:2]:
        found += _in_c("local level", *_level(length)[:4], length)
        found += _in_c("4 states", *_oscillating(4, 2, length)[:4], length)
    return found


def _in_c(
    name: str, filter: AnyFilter, build: Any, inputs: Any, free: int, length: int
) -> list[Row]:
    """C with constant gains against C that takes every step."""
    data, at = Data(inputs, np.zeros(length)), np.zeros(free)
    given = filter, InnovationLikelihood(), build, free, data
    with tempfile.TemporaryDirectory() as folder:
        short, full = (Native(*given, Path(folder), settle=settle) for settle in (True, False))
        record = short.rows(data)
        found = []
        for what in ("value", "value_and_gradient"):
            calls = {
                key: partial(getattr(native, what), at, record, data)
                for key, native in (("short", short), ("full", full))
            }
            one, other = (jax.tree.leaves(call()) for call in calls.values())
            _agree(one, other)
            times = interleave(calls, ROUNDS, clock=time.process_time)
            words = f"10^{np.log10(length):.0f} samples, {what.removeprefix('value_and_')} by C"
            found.append(_row(f"{name}, {words}", times, length))
    return found


def _row(what: str, times: Times, length: int) -> Row:
    ratio = times.ratio("full", "short")
    return Row(
        part=PART,
        what=what,
        ours=f"{duration(times.median('short') / length)} a sample",
        against=f"every step: {duration(times.median('full') / length)}",
        figure=ratio.median,
        best=ratio.best,
        sense="least",
    )


def _level(length: int) -> Made:
    draw = np.random.default_rng(0)
    z = np.cumsum(0.1 * draw.standard_normal(length)) + draw.standard_normal(length)
    return LocalLevel(dt=1.0), _level_noise, LevelSample(jnp.asarray(z)), 2, "forwards"


def _level_noise(at: Array) -> LocalLevelNoise:
    q, R = jnp.exp(at)
    return LocalLevelNoise(0.01 * q, R)


def _oscillating(n: int, m: int, length: int) -> Made:
    F, H, _ = oscillators(n, m)
    z = np.random.default_rng(n).standard_normal((length, m))

    def build(at: Array) -> LinearModel:
        every = jnp.exp(at)
        step = Transition(jnp.asarray(F), jnp.eye(n), jnp.diag(every[:n]))
        return LinearModel(step, jnp.asarray(H), every[n:], jnp.eye(n), jnp.zeros(n))

    return LinearKalman(), build, Sample(jnp.asarray(z)), n + m, "backwards"


def settled(length: int = LENGTHS[0], rounds: int = 9) -> float:
    """How many times as fast a local level's likelihood is with constant gains, at best."""
    filter, build, inputs, free, _ = _level(length)
    data = Data(inputs, jnp.zeros(length))
    calls = {
        name: partial(_value(each, build), jnp.zeros(free), data)
        for name, each in (("short", Settling(filter)), ("full", filter))
    }
    return interleave(calls, rounds).ratio("full", "short").best


def _value(filter: AnyFilter, build: Any) -> Any:
    likelihood = InnovationLikelihood()
    return jax.jit(lambda at, data: score(filter, likelihood, build(at), data))


def _rows(
    name: str, filter: AnyFilter, build: Any, inputs: Any, free: int, way: Way, length: int
) -> list[Row]:
    likelihood, at = InnovationLikelihood(), jnp.zeros(free)
    data = Data(inputs, jnp.zeros(length))

    def calls(filter: AnyFilter) -> tuple[Call, Call]:
        both = jax.jit(
            lambda at, data: score_and_gradient(filter, likelihood, build, at, data, way=way)
        )
        return partial(_value(filter, build), at, data), partial(both, at, data)

    found = []
    pairs = zip(calls(Settling(filter)), calls(filter), ("value", f"gradient, {way}"), strict=True)
    for short, full, what in pairs:
        _agree(short(), full())
        times = interleave({"short": short, "full": full}, ROUNDS, clock=time.process_time)
        found.append(_row(f"{name}, 10^{np.log10(length):.0f} samples, {what}", times, length))
    return found


def _agree(short: Any, full: Any) -> None:
    pairs = zip(jax.tree.leaves(short), jax.tree.leaves(full), AGREED, strict=False)
    for found, wanted, most in pairs:
        apart = np.abs(found - wanted).max() / np.abs(wanted).max()
        if not apart <= most:
            raise AssertionError(f"with constant gains a likelihood differs by {apart:.2g}")


def main() -> None:
    """Print the table."""
    from rich.console import Console

    from benchmarks.table import show

    show(rows(), Console())


if __name__ == "__main__":
    main()
