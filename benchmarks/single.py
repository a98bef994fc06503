"""One pass, the cost and its gradient, for one pair (R, Q)."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, cast

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.baseline import Baseline
from benchmarks.loops import matrix_loop
from benchmarks.table import Row, duration
from benchmarks.timing import Call, Times, interleave
from benchmarks.work import DT, Q, R, Work, linear_model
from filters import GyroscopeFilter, KownackiNoise, LinearKalman, Sample, run
from objectives import Reading, score_and_gradient
from tuner import Problem

PASS = "One pass over the record"
COST = "Cost and gradient at one point"
BUSY = (
    "the C pass waits for its own divisions and loses little where the processor is shared, "
    "while XLA's loop keeps its state in memory and is bound by the number of instructions"
)


def rows(work: Work, limit: Baseline | None) -> list[Row]:
    """Our passes, costs and gradients against C's pass."""
    calls: dict[str, Call] = passes(work) | evaluations(work)
    if limit is None:
        return _without_c(work, calls)
    times = interleave(calls | limits(work, limit), work.repetitions)
    return _passes(times, largest_difference(work, limit)) + _costs(times)


def passes(work: Work) -> dict[str, Call]:
    """The filter itself, and the generic Kalman filter with the same model."""
    noise = KownackiNoise.of(jnp.asarray(R), jnp.asarray(Q))
    z, model = jnp.asarray(work.signal), linear_model(R, Q)

    @jax.jit
    def filtered(noise: KownackiNoise, z: jax.Array) -> jax.Array:
        return cast("jax.Array", run(GyroscopeFilter(DT), noise, z, unroll=4)[1])

    generic = jax.jit(lambda m, z: run(LinearKalman(), m, Sample(z), unroll=4)[1].x[:, 0])
    return {
        "gyroscope filter": partial(filtered, noise, z),
        "generic LinearKalman": partial(generic, model, z[:, None]),
    }


def evaluations(work: Work) -> dict[str, Call]:
    """The cost, and the cost with its gradient, under both readings."""
    found: dict[str, Call] = {}
    for reading in (Reading.R1, Reading.R6):
        problem = work.problem(reading)
        for name, function in compiled(problem).items():
            z = jnp.asarray(problem.space.start())
            found[f"{name}, {reading.name}"] = partial(function, z, problem.data)
    return found


def compiled(problem: Problem) -> dict[str, Callable[..., Any]]:
    """The evaluation of :class:`Problem`, without the conversion of its result to NumPy."""
    static = problem.static
    gradient = partial(score_and_gradient, static.filter, static.objective, static.built)
    return {"cost": jax.jit(static.score), "cost + gradient": jax.jit(gradient)}


def limits(work: Work, limit: Baseline) -> dict[str, Call]:
    """C's passes, and NumPy's transform of the same segments."""
    segments, nfft = _segments(work), work.welch.nfft
    one, two = np.empty_like(work.signal), np.empty_like(work.pair)
    return {
        "C": lambda: limit.forward(work.signal, R, Q, one),
        "C, two signals": lambda: limit.forward(work.pair, R, Q, two),
        "rfft": lambda: np.fft.rfft(segments, nfft),
    }


def largest_difference(work: Work, limit: Baseline) -> dict[str, float]:
    """Differences of our outputs from C's, by name."""
    expected = limit.forward(work.signal, R, Q)
    return {
        name: float(np.abs(np.asarray(call()) - expected).max())
        for name, call in passes(work).items()
    }


def _passes(times: Times, differ: dict[str, float]) -> list[Row]:
    targets = {"gyroscope filter": 1.5, "generic LinearKalman": 3.0}
    return [
        _row(PASS, name, times, ("C",), target, f"differs from C by {differ[name]:.1g} at most")
        for name, target in targets.items()
    ]


def _costs(times: Times) -> list[Row]:
    both = ("C, two signals", "rfft")
    return [
        _row(COST, "cost, R1", times, ("C",), 2.0),
        _row(COST, "cost + gradient, R1", times, ("C",), 3.0),
        _row(COST, "cost, R6", times, both, 1.5),
        _row(COST, "cost + gradient, R6", times, both, 3.0),
    ]


def _row(
    part: str, name: str, times: Times, against: tuple[str, ...], target: float, note: str = ""
) -> Row:
    ratio = times.ratio(name, *against)
    return Row(
        part=part,
        what=name,
        ours=duration(times.median(name)),
        against=f"{' + '.join(against)}: {duration(sum(map(times.median, against)))}",
        figure=ratio.median,
        best=ratio.best,
        target=target,
        note=note,
        why=BUSY,
    )


def _without_c(work: Work, calls: dict[str, Call]) -> list[Row]:
    """The same against a loop in NumPy, for which there are no targets."""
    loop = "NumPy loop"
    times = interleave({**calls, loop: lambda: matrix_loop(work.signal, R, Q, DT)}, 5)
    found = []
    for name in calls:
        row = _row(COST if "cost" in name else PASS, name, times, (loop,), 0.0)
        found.append(replace(row, target=None))
    return found


def _segments(work: Work) -> np.ndarray:
    hop = work.welch.segment - work.welch.overlap
    starts = range(0, work.samples - work.welch.segment + 1, hop)
    return np.stack([work.noise[start : start + work.welch.segment] for start in starts])
