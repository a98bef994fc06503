"""The problems posed on a record."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import KownackiNoise, SteadyState
from objectives import Crossing, Data, Reading, StepResponse, Welch
from studies.kownacki2010.data import Bench
from tuner.problem.exported import exported_of
from tuner.problem.parameters import Fixed, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space


def objective(
    bench: Bench, reading: str, crossing: str = "hinge", weight: float = 1.0
) -> StepResponse:
    """Cost (10) under a reading."""
    welch = Welch.matlab(len(bench.record))
    return StepResponse(bench.dt, welch, Reading[reading], Crossing[crossing.upper()], weight)


def problem(bench: Bench) -> Problem:
    """Minimise (10) over Q, with R as measured: well posed, for only Q/R counts."""
    s = bench.settings
    return _problem(bench, "", objective(bench, s.reading, s.crossing, s.weight), free_R=False)


def paper(bench: Bench) -> Problem:
    """Minimise (10) over R and Q together, as the paper does: ill posed."""
    s = bench.settings
    return _problem(bench, ".paper", objective(bench, s.reading, s.crossing, s.weight), free_R=True)


def literal(bench: Bench) -> Problem:
    """Minimise (10) over Q to the letter: reading R1, up to the first crossing."""
    return _problem(bench, ".literal", objective(bench, "R1", "first"), free_R=False)


def _problem(bench: Bench, suffix: str, objective: StepResponse, *, free_R: bool) -> Problem:
    # Wide enough for any unit of the record.
    free = Positive(
        bench.R,
        low=min(1e-13, 1e-4 * bench.R),
        high=max(1.0, 1e3 * bench.R),
        unit=f"({bench.unit})^2",
        meaning="variance of the measurement",
    )
    low, high = 1e-8 * bench.R, 1e10 * bench.R
    if free_R:
        low, high = min(1e-13, 1e-7 * bench.R), max(1e2, 1e4 * bench.R)
    return Problem(
        name=bench.sensor.name + suffix,
        space=Space.of(
            R=free if free_R else Fixed(bench.R, unit=free.unit, meaning=free.meaning),
            Q=Positive(
                np.clip(bench.Q, low, high),
                low,
                high,
                unit=f"({bench.unit})^2/s^2",
                meaning="process noise",
            ),
            P0=Fixed(bench.settings.P0, unit=free.unit, meaning="covariance at the start"),
        ),
        filter=bench.filter,
        build=noise,
        objective=objective,
        data=Data(bench.signals, objective.truth(bench.step)),
        derive=partial(derived, bench.sensor.steady, bench.dt),
        source=bench.source,
        exported=replace(exported_of(bench.filter), states=bench.sensor.states),
    )


def noise(values: dict[str, Array]) -> KownackiNoise:
    """The filters' parameters from the space's."""
    return KownackiNoise(values["R"], values["Q"], values["P0"])


def derived(
    steady: Callable[[Array, float], SteadyState], dt: float, values: dict[str, Array]
) -> dict[str, Array]:
    """Quantities derived from Q and R: only their ratio counts once P0 is forgotten."""
    ratio = values["Q"] / values["R"]
    (K1, K2), bandwidth = steady(ratio, dt)
    return {
        "q_over_r": ratio,
        "k1": jnp.asarray(K1),
        "k2": jnp.asarray(K2),
        "bandwidth_hz": bandwidth,
    }
