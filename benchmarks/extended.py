"""The extended Kalman filter: five states, five measurements, six parameters' gradient."""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from benchmarks.baseline import Baseline
from benchmarks.startup import compiling
from benchmarks.table import Row, duration
from benchmarks.timing import Call, Times, interleave
from filters import TiltKalman, TiltNoise, TiltSample, run
from filters.tilt_euler import TO_PAPER
from tuner.data.simulation import GRAVITY, Bursts, Sensor, Swing, simulate
from tuner.data.simulation import measure as sensed

PART = "An extended Kalman filter, 5 states"
DT, DELTA, P0 = 0.01, 0.02, 1e-2
NOISE = (0.1, 1e-3, 1e-3, 2.5e-5, 0.4, 0.5)
"""q1, r_nom (twice), r3, alpha1, alpha2."""
SECONDS, ROUNDS = 200.0, 15
AGREED = 1e-9  # rad; the C code leaves out the term that corrects rounding
BUSY = "both compilers' vector code, which other work on the machine stretches unequally"


def rows(limit: Baseline | None) -> list[Row]:
    """Forward against C, the gradient against forward, and their compilation."""
    calls = evaluations()
    if limit is not None:
        acceleration, rate = (np.asarray(x) for x in record())
        rate = rate * TO_PAPER
        out = np.empty((len(rate), 2))
        noise = np.array(NOISE)
        calls["C"] = lambda: limit.tilt((DT, DELTA, P0), acceleration, rate, noise, out)
    times = interleave(calls, ROUNDS)
    return [
        *_forward(times, limit, calls),
        _gradient(times),
        *compiling(PART, "compiling_extended", 0, 3.0),
    ]


def record() -> TiltSample:
    """A swinging board with bursts of acceleration: g and rad/s."""
    motion = simulate(
        seconds=SECONDS,
        dt=DT,
        seed=0,
        swing=Swing((0.25, 0.2, 1.0), 0.1, 0.6),
        bursts=Bursts(count=20, size=3.0),
    )
    sample = sensed(motion, gyroscope=Sensor(5e-3), accelerometer=Sensor(0.1), seed=0)
    return TiltSample(sample.acc / GRAVITY, sample.gyr)


def evaluations() -> dict[str, Call]:
    """A pass, and a sum over its output with six derivatives."""
    inputs, noise = record(), jnp.array(NOISE)
    return {name: partial(call, noise, inputs) for name, call in compiled().items()}


def compiled() -> dict[str, Callable[[Array, TiltSample], Any]]:
    """The same as functions of the six numbers and the record."""
    passed = lambda noise, inputs: run(TiltKalman(DT), _params(noise), inputs)[1].angles  # noqa: E731
    power = lambda noise, inputs: (passed(noise, inputs) ** 2).sum()  # noqa: E731
    every = jnp.eye(len(NOISE))

    @jax.jit
    def gradient(noise: Array, inputs: TiltSample) -> tuple[Array, Array]:
        by = lambda way: jax.jvp(partial(power, inputs=inputs), (noise,), (way,))  # noqa: E731
        found: tuple[Array, Array] = jax.vmap(by, out_axes=(None, 0))(every)
        return found

    return {"extended filter": jax.jit(passed), "gradient of 6 parameters": gradient}


def _params(noise: Array) -> TiltNoise:
    return TiltNoise(
        q1=noise[0],
        r_nom=noise[1:3],
        r3=noise[3],
        alpha1=noise[4],
        alpha2=noise[5],
        delta=jnp.asarray(DELTA),
        r_big=jnp.asarray(1.0),
        gravity=jnp.ones(()),  # accelerations are in g
        x0=jnp.zeros(5),
        P0=jnp.asarray(P0),
    )


def _forward(times: Times, limit: Baseline | None, calls: dict[str, Call]) -> list[Row]:
    name = "extended filter"
    if limit is None:
        return [Row(PART, name, duration(times.median(name)), note="no C compiler was found")]
    apart = float(np.abs(np.asarray(calls[name]()) - np.asarray(calls["C"]())).max())
    if not apart <= AGREED:
        raise AssertionError(f"the extended filter differs from C by {apart:.1g} rad")
    ratio = times.ratio(name, "C")
    return [
        Row(
            part=PART,
            what=name,
            ours=duration(times.median(name)),
            against=f"C: {duration(times.median('C'))}",
            figure=ratio.median,
            best=ratio.best,
            target=2.5,
            note=f"differs from C by {apart:.1g} rad at most",
            why=BUSY,
        )
    ]


def _gradient(times: Times) -> Row:
    name = "gradient of 6 parameters"
    ratio = times.ratio(name, "extended filter")
    return Row(
        part=PART,
        what=name,
        ours=duration(times.median(name)),
        against=f"forward: {duration(times.median('extended filter'))}",
        figure=ratio.median,
        best=ratio.best,
        target=8.0,
        why=BUSY,
    )
