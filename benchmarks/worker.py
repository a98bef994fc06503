"""Measurements in a separate process: ``python -m benchmarks.worker TASK SAMPLES``."""

import json
import sys
import time
from functools import partial

import jax
import jax.numpy as jnp

from benchmarks import extended
from benchmarks.baseline import NoCompilerError, baseline
from benchmarks.loops import scalar_loop
from benchmarks.single import compiled, passes
from benchmarks.timing import Call, interleave
from benchmarks.work import DT, Q, R, Work, linear_model
from filters import LinearKalman, Sample, run
from objectives import Reading

ROUNDS = 7


def gradient(samples: int) -> dict[str, float]:
    """Best times of the passes, the costs and gradients, a Python loop and C."""
    work = Work(samples)
    problem = work.problem(Reading.R1)
    point = jnp.asarray(problem.space.start())
    calls = passes(work)
    calls |= {name: partial(call, point, problem.data) for name, call in compiled(problem).items()}
    calls["generic gradient"] = _generic_gradient(work)
    signal = work.signal.tolist()
    calls["Python loop"] = lambda: scalar_loop(signal, R, Q, DT)
    try:
        limit = baseline()
        calls["C"] = lambda: limit.forward(work.signal, R, Q)
    except NoCompilerError:
        pass
    times = interleave(calls, ROUNDS)
    return {name: times.best(name) for name in calls}


def compiling(samples: int) -> dict[str, float]:
    """First call minus second call, in a process that has compiled nothing yet."""
    found = {}
    for reading in (Reading.R1, Reading.R6):
        problem = Work(samples).problem(reading)
        point = jnp.asarray(problem.space.start())
        data = jax.tree.map(jnp.asarray, problem.data)
        for name, call in compiled(problem).items():
            times = [_seconds(partial(call, point, data)) for _ in range(2)]
            found[f"{name}, {reading.name}"] = times[0] - times[1]
    return found


def compiling_extended(_: int) -> dict[str, float]:
    """The same of the extended filter."""
    noise, inputs = jnp.array(extended.NOISE), extended.record()
    found = {}
    for name, call in extended.compiled().items():
        times = [_seconds(partial(call, noise, inputs)) for _ in range(2)]
        found[name] = times[0] - times[1]
    return found


TASKS = {"gradient": gradient, "compiling": compiling, "compiling_extended": compiling_extended}


def _generic_gradient(work: Work) -> Call:
    """Forward tangents through the generic filter: a loop whose state XLA's default leaves out."""
    z = jnp.asarray(work.signal)[:, None]

    def power(point: jax.Array) -> jax.Array:
        model = linear_model(1.0, 1.0)
        move = model.transition._replace(Q=point[1] * jnp.eye(2))
        model = model._replace(transition=move, R=point[:1])
        return jnp.sum(run(LinearKalman(), model, Sample(z))[1].x[:, 0] ** 2)

    return partial(jax.jit(jax.jacfwd(power)), jnp.array([R, Q]))


def _seconds(call: Call) -> float:
    start = time.perf_counter()
    jax.block_until_ready(call())
    return time.perf_counter() - start


if __name__ == "__main__":
    print(json.dumps(TASKS[sys.argv[1]](int(sys.argv[2]))))
