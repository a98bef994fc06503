"""Many pairs (R, Q) at once."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any

import jax.numpy as jnp
import numpy as np

from benchmarks.baseline import Baseline, Weights
from benchmarks.table import Row, duration
from benchmarks.timing import Call, Times, interleave
from benchmarks.work import Work, pairs
from objectives import Reading
from tuner import Problem, values, values_and_gradients
from tuner.problem import surface

PART = "256 pairs (R, Q) at once"
PAIRS = 256
TARGETS = {"cost": 2.0, "cost + gradient": 10.0}  # ns per sample and pair
SLOW = (
    "the target is in nanoseconds of the machine it was set on, where C takes 0.4 for a cost and "
    "1.1 for a gradient; compare with C's time here"
)
_EVALUATE: dict[str, tuple[Callable[..., object], Any]] = {
    "cost": (values, surface._values),
    "cost + gradient": (values_and_gradients, surface._values_and_gradients),
}


def rows(work: Work, limit: Baseline | None) -> list[Row]:
    """Time per sample and pair under R1 against C, and the memory of the two readings."""
    points = pairs(PAIRS)
    one = work.problem(Reading.R1)
    calls = _ours(one, points) | (_limits(work, one, points, limit) if limit else {})
    times = interleave(calls, max(5, work.repetitions // 2))
    found = [_row(name, times, work.samples * PAIRS) for name in TARGETS]
    found += [_memory(one, name, points, 10.0) for name in TARGETS]
    six = work.problem(Reading.R6)
    return found + [_memory(six, name, points, 200.0) for name in TARGETS]


def _ours(problem: Problem, points: np.ndarray) -> dict[str, Call]:
    Z = np.log(points)
    return {name: partial(evaluate, problem, Z) for name, (evaluate, _) in _EVALUATE.items()}


def _limits(work: Work, problem: Problem, points: np.ndarray, limit: Baseline) -> dict[str, Call]:
    """C on the same points, in as many threads."""
    truth = problem.data.truth
    weights = Weights(*map(np.asarray, (truth.step, truth.lag_weight, truth.power_weight)))
    shares = np.array_split(points, os.cpu_count() or 1)
    pool = ThreadPoolExecutor(len(shares))

    def threaded(function: Callable[..., np.ndarray]) -> list[np.ndarray]:
        return list(pool.map(lambda share: function(share, work.signal, weights), shares))

    return {
        "C cost": partial(threaded, limit.costs),
        "C cost + gradient": partial(threaded, limit.gradients),
    }


def _row(name: str, times: Times, size: int) -> Row:
    threads = os.cpu_count() or 1
    scale = 1e9 / size
    row = Row(
        part=PART,
        what=f"{name}, R1, {threads} threads",
        ours=duration(times.median(name)),
        figure=scale * times.median(name),
        best=scale * times.best(name),
        unit="ns",
        target=TARGETS[name],
        note="a sample and pair",
        why=SLOW,
    )
    if f"C {name}" not in times.seconds:
        return row
    ratio = times.ratio(name, f"C {name}")
    c_time = scale * times.median(f"C {name}")
    against = f"C, {threads} threads: {c_time:.2f} ns"
    note = f"a sample and pair; {ratio.median:.1f} x C ({ratio.best:.1f} x at best)"
    return replace(row, against=against, note=note)


def _memory(problem: Problem, name: str, points: np.ndarray, target: float) -> Row:
    """The memory that XLA reserves for one batch, times the batches that run at once."""
    threads = os.cpu_count() or 1
    lanes = surface._lanes(problem, threads, len(points))
    _, function = _EVALUATE[name]
    arguments = problem.static, jnp.zeros((lanes, problem.space.size)), problem.data
    reserved = function.traced.lower(*arguments).compile().memory_analysis().temp_size_in_bytes
    return Row(
        part=PART,
        what=f"temporary memory, {name}, {problem.name}",
        ours=f"{threads} threads of {lanes} pairs",
        figure=threads * reserved / 1e6,
        unit="MB",
        target=target,
    )
