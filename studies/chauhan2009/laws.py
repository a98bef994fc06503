"""The filters that compete: constant, fuzzy and random process noise; and how they are tuned."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Batched, run, shared
from filters.gps_aided import GpsAidedKalman, GpsAidedNoise, GpsAidedOutputs, GpsAidedSample
from objectives import Data
from objectives import Records as OverRecords
from studies.chauhan2009.steps import BEFORE, DT, EVERY, MOTIONS, Records, Settings, Step, records
from tuner.problem.parameters import Bounded, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

STATES = ("q0", "q1", "q2", "q3", "bias_x", "bias_y", "bias_z")
FUZZY = GpsAidedKalman(DT, EVERY, "fuzzy")
RANDOM = GpsAidedKalman(DT, EVERY, "random")
CONSTANT = GpsAidedKalman(DT, EVERY, "constant")
PAPER = {"quaternion": 1e-4, "bias": 1e-6, "floor": 1e-12, "h": 0.0}
"""Q until the fuzzy law has one, and its floor: none is in the paper."""
HELD_OUT = 1000
"""Seeds of held-out records lie this far above those that are tuned on."""


@dataclass(frozen=True)
class Build:
    """The filter's parameters from values by name; the others are the notes'.

    Attributes:
        noise: of the measured angles, deg, where ``angle`` is not among the values.
        count: of records side by side.
    """

    noise: float
    count: int

    def __call__(self, values: dict[str, Array]) -> GpsAidedNoise:
        """The same for every record, without a random law's scale."""
        given = {"angle": jnp.asarray(self.noise)} | {k: jnp.asarray(v) for k, v in PAPER.items()}
        given |= values
        numbers = {
            f"R_{angle}": jnp.radians(given["angle"]) ** 2 for angle in ("phi", "theta", "psi")
        }
        for state in ("quaternion", "bias"):
            numbers |= {f"Q_{state}": given[state], f"floor_{state}": given["floor"]}
            numbers |= {f"P0_{state}": jnp.asarray(0.01)}
        q0 = jnp.zeros(4).at[0].set(1.0)
        known = GpsAidedNoise(**numbers, h=given["h"], scale=jnp.zeros(7), q0=q0, b0=jnp.zeros(3))
        found: GpsAidedNoise = shared(known, self.count)
        return found


def estimated(
    filter: GpsAidedKalman, settings: Settings, inputs: GpsAidedSample, values: dict[str, Array]
) -> GpsAidedOutputs:
    """A filter's outputs over records side by side."""
    return outputs(filter, Build(settings.noise, inputs.gyr.shape[1])(values), inputs)


def outputs(
    filter: GpsAidedKalman, params: GpsAidedNoise, inputs: GpsAidedSample
) -> GpsAidedOutputs:
    """The same for parameters of each record."""
    found: GpsAidedOutputs = _run(filter, params, inputs)
    return found


def random_scale(Q: np.ndarray, factor: float) -> np.ndarray:
    """Of the random law on the same data: lambda sqrt(3) times the rms rate of the fuzzy law.

    Both then have one mean of Q at lambda = 1, for a draw u is uniform and E 3 u^2 = 1.

    Args:
        Q: diagonals of a fuzzy run after the step, ``(N, k, 7)``.
        factor: lambda.
    """
    return np.asarray(factor * np.sqrt(3 * (Q / (DT * EVERY)).mean(axis=0)))


def randomly(
    settings: Settings, made: Records, fuzzy: GpsAidedOutputs, factor: float, seed: int
) -> GpsAidedOutputs:
    """The random law's outputs on the same records."""
    count = made.truth.shape[1]
    late = np.asarray(fuzzy.Q)[round(BEFORE / DT) :]
    params = Build(settings.noise, count)({})
    scale = jnp.asarray(random_scale(late, factor))
    params = params._replace(scale=scale)
    draw = np.random.default_rng([seed, 7]).uniform(size=(*made.truth.shape, 7))
    return outputs(RANDOM, params, made.inputs._replace(draw=jnp.asarray(draw)))


@dataclass(frozen=True)
class PitchRmse:
    """Root mean square error of the estimated pitch from the step on, deg.

    Attributes:
        skipped: ticks before.
    """

    skipped: int

    def __call__(self, outputs: GpsAidedOutputs, truth: Array) -> Array:
        """Of one record, ``()``."""
        error = (outputs.angles[:, 1] - truth)[self.skipped :]
        return jnp.degrees(jnp.sqrt((error**2).mean()))


OBJECTIVE = OverRecords(PitchRmse(round(BEFORE / DT)))
ANGLE = Positive(1.0, 1e-2, 1e2, "deg")
FLOOR = Positive(1e-8, 1e-14, 1e-2, "1/s and rad^2/s^3")
FREE: dict[str, dict[str, Parameter]] = {
    "fuzzy": {"angle": ANGLE, "floor": FLOOR},
    "edge": {"angle": ANGLE, "floor": FLOOR, "h": Bounded(0.3, 0.0, 0.99)},
    "constant": {
        "quaternion": Positive(1e-5, 1e-12, 1e-1, "1/s"),
        "bias": Positive(1e-8, 1e-14, 1e-2, "rad^2/s^3"),
    },
}
"""What is tuned; of the constant law not R as well, which would only scale everything."""


def tuning_records(settings: Settings, count: int, seed: int) -> Records:
    """Steps of both motions to the angles that are tuned on."""
    steps = [Step(angle, motion) for angle in settings.tuned_on for motion in MOTIONS]
    return records(settings, steps, [seed + i for i in range(count)])


def filters(settings: Settings) -> dict[str, tuple[str, GpsAidedKalman]]:
    """What is tuned, by problem: the law's name in :data:`FREE`, and the filter."""
    found = {"constant": ("constant", CONSTANT)}
    for samples in settings.windows:
        found[f"fuzzy_{samples}"] = ("fuzzy", GpsAidedKalman(DT, EVERY, "fuzzy", samples))
    edge = GpsAidedKalman(DT, EVERY, "fuzzy", settings.windows[-1], slope="edge")
    return found | {"edge": ("edge", edge)}


def problems(settings: Settings, seed: int) -> dict[str, Problem]:
    """One for each filter, on the same records."""
    made = tuning_records(settings, settings.train, seed)
    return {
        name: Problem(
            name=name,
            space=Space.of(**FREE[law]),
            filter=Batched(filter),
            build=Build(settings.noise, made.truth.shape[1]),
            objective=OBJECTIVE,
            data=Data(made.inputs, made.truth),
        )
        for name, (law, filter) in filters(settings).items()
    }


def judged(
    filter: GpsAidedKalman, settings: Settings, made: Records, values: dict[str, Array]
) -> float:
    """The mean error over records, deg."""
    found = estimated(filter, settings, made.inputs, values)
    return float(OBJECTIVE(found, made.truth))


def _passed(filter: GpsAidedKalman, params: Any, inputs: Any) -> Any:
    return run(Batched(filter), params, inputs)[1]


_run: Callable[..., Any] = jax.jit(_passed, static_argnums=0)
