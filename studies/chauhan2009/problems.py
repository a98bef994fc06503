"""The competing filters, with constant, fuzzy and random process noise, and their tuning."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter, Batched, Lanes, assembled, parameter_facts, run, shared
from filters.gps_aided import GpsAidedKalman, GpsAidedNoise, GpsAidedOutputs, GpsAidedSample
from objectives import Data
from objectives import Records as OverRecords
from objectives.in_numpy import in_numpy
from studies.chauhan2009.data import BEFORE, MOTIONS, Records, Step, records
from studies.chauhan2009.paper import DT, EVERY
from studies.chauhan2009.settings import Settings
from studies.chauhan2009.windows import ByPeriod, by_period, exported
from tuner.problem.parameters import Bounded, Fixed, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.shared_gradients import SharedGradients
from tuner.problem.space import Space
from tuner.stored_programs import QUICKLY

FUZZY = GpsAidedKalman(DT, EVERY, "fuzzy")
RANDOM = GpsAidedKalman(DT, EVERY, "random")
CONSTANT = GpsAidedKalman(DT, EVERY, "constant")
BY_HAND = {"quaternion": 1e-4, "bias": 1e-6, "floor": 1e-12, "h": 0.0}
"""Initial Q of the fuzzy law, and its floor: the paper gives neither."""
HELD_OUT = 1000
"""Offset of the held-out records' seeds from those that are tuned on."""


def parameters(values: Mapping[str, Array | float]) -> GpsAidedNoise:
    """The filter's parameters from values by name, with hand-made ones for the others.

    Args:
        values: ``angle``, the deviation of the measured angles, deg; the others are optional.
    """
    given = {name: jnp.asarray(value, float) for name, value in (BY_HAND | {**values}).items()}
    numbers: dict[str, Any] = {k: fact.typical for k, fact in parameter_facts(FUZZY).items()}
    for angle in ("phi", "theta", "psi"):
        numbers[f"R_{angle}"] = jnp.radians(given["angle"]) ** 2
    for state in ("quaternion", "bias"):
        numbers |= {f"Q_{state}": given[state], f"floor_{state}": given["floor"]}
        numbers[f"P0_{state}"] = 0.01
    found: GpsAidedNoise = assembled(FUZZY, numbers | {"h": given["h"]})
    return found


def noise_of(values: Mapping[str, Array | float]) -> GpsAidedNoise:
    """The same, worked out by NumPy."""
    given = {name: np.asarray(value, float) for name, value in values.items()}
    found: GpsAidedNoise = in_numpy(parameters, given)
    return found


def by_hand(settings: Settings) -> dict[str, float]:
    """The values without tuning: the known deviation of the measured angles."""
    return {"angle": settings.noise}


def estimated(
    filter: GpsAidedKalman, inputs: GpsAidedSample, values: Mapping[str, Array | float]
) -> GpsAidedOutputs:
    """A filter's outputs over a batch of records."""
    found: GpsAidedOutputs = _run(Lanes(filter, inputs.gyr.shape[1]), noise_of(values), inputs)
    return found


def parted(made: Records, count: int) -> Iterator[Records]:
    """As many records at a time; fewer at the end."""
    for first in range(0, made.truth.shape[1], count):
        which = slice(first, first + count)
        part: Records = jax.tree.map(lambda leaf, at=which: np.asarray(leaf)[:, at], made)
        yield part


def random_scale(Q: np.ndarray, factor: float) -> np.ndarray:
    """Scale of the random law on the same data: lambda sqrt(3) times the fuzzy law's rms rate.

    Both then have one mean of Q at lambda = 1, for a draw u is uniform and E 3 u^2 = 1.

    Args:
        Q: diagonals of a fuzzy run after the step, ``(N, k, 7)``.
        factor: lambda.
    """
    return np.asarray(factor * np.sqrt(3 * (Q / (DT * EVERY)).mean(axis=0)))


def randomly(
    settings: Settings, made: Records, Q: np.ndarray, factors: Sequence[float], seed: int
) -> np.ndarray:
    """The random law's estimates on the same records, each with a scale of its own.

    Args:
        settings: for the values without tuning.
        made: k records.
        Q: diagonals of a fuzzy run on them, ``(N, k, 7)``.
        factors: F values of lambda, which run side by side.
        seed: of the draws, the same for every lambda.

    Returns:
        Angles after the ticks, rad, ``(F, N, k, 3)``.
    """
    late = Q[round(BEFORE / DT) :]
    count = made.truth.shape[1]
    params = in_numpy(partial(shared, count=count), noise_of(by_hand(settings)))
    params = params._replace(scale=np.stack([random_scale(late, factor) for factor in factors]))
    draw = np.random.default_rng([seed, 7]).uniform(size=(*made.truth.shape, 7))
    return np.asarray(_angles(params, made.inputs._replace(draw=jnp.asarray(draw))))


@dataclass(frozen=True)
class PitchRmse:
    """Root mean square error of the estimated pitch from the step on, deg.

    Attributes:
        skipped: ticks before.
        ticks: of a record; what fills up its last period is left out.
    """

    skipped: int
    ticks: int

    def __call__(self, outputs: GpsAidedOutputs, truth: Array) -> Array:
        """The error of one record, by periods, ``()``."""
        error = (outputs.angles[..., 1] - truth).ravel()[self.skipped : self.ticks]
        return jnp.degrees(jnp.sqrt((error**2).mean()))


def space(law: str, noise: float) -> Space:
    """The tuned parameters; R of the constant law is held, for it would only scale everything.

    Args:
        law: "constant", "fuzzy", or "edge", the fuzzy one with h.
        noise: of the measured angles, deg.
    """
    if law == "constant":
        return Space.of(
            quaternion=_density(1e-5, 1e-12, 1e-1, "1/s", "of the quaternion's noise"),
            bias=_density(1e-8, 1e-14, 1e-2, "rad^2/s^3", "of the gyroscopes' bias"),
            angle=Fixed(noise, "deg", meaning="noise of the angles, held"),
        )
    free: dict[str, Parameter] = {
        "angle": Positive(1.0, 1e-2, 1e2, "deg", meaning="deviation of the measured angles"),
        "floor": Positive(
            *(1e-8, 1e-14, 1e-2),
            "1/s and rad^2/s^3",
            meaning="least spectral density of each state's noise",
        ),
    }
    if law == "edge":
        free["h"] = Bounded(0.3, 0.0, 0.99, meaning="level of membership of the regression")
    return Space.of(**free)


def _density(init: float, low: float, high: float, unit: str, what: str) -> Positive:
    return Positive(init, low, high, unit, meaning=f"spectral density {what}")


def tuning_records(settings: Settings, count: int, seed: int) -> Records:
    """Steps of both motions to the angles that are tuned on."""
    steps = [Step(angle, motion) for angle in settings.tuned_on for motion in MOTIONS]
    return records(settings, steps, [seed + i for i in range(count)])


def filters(settings: Settings) -> dict[str, tuple[str, GpsAidedKalman]]:
    """The tuned filters by problem: the law's name in :func:`space`, and the filter."""
    found = {"constant": ("constant", CONSTANT)}
    for samples in settings.windows:
        found[f"fuzzy_{samples}"] = ("fuzzy", GpsAidedKalman(DT, EVERY, "fuzzy", samples))
    edge = GpsAidedKalman(DT, EVERY, "fuzzy", settings.windows[-1], slope="edge")
    return found | {"edge": ("edge", edge)}


def posed(settings: Settings, made: Records) -> dict[str, Problem]:
    """A problem for each filter, on the same records; all share one program for gradients."""
    return {name: _posed(settings, name, made) for name in filters(settings)}


def _posed(settings: Settings, name: str, made: Records) -> Problem:
    law, own = filters(settings)[name]
    longest, count = replace(own, samples=max(settings.windows)), made.truth.shape[1]
    fuzzy = ByPeriod(replace(longest, law="fuzzy", slope="center"), any_law=True)
    return Problem(
        name=name,
        space=space(law, settings.noise),
        filter=Lanes(ByPeriod(longest if law == "fuzzy" else own), count),
        build=parameters,
        objective=OverRecords(PitchRmse(round(BEFORE / DT), len(made.truth))),
        data=data_of(settings, name, made),
        source=made.source,
        exported=exported(own, made),
        gradients=SharedGradients(Lanes(fuzzy, count), space("edge", settings.noise).size),
    )


def data_of(settings: Settings, name: str, made: Records) -> Data:
    """Records as the problem of a filter takes them."""
    return by_period(made, filters(settings)[name][1])


def judged_by_hand(settings: Settings, made: Records) -> float:
    """The mean error of the fuzzy law as published, deg, a step's number of records at a time."""
    skipped, squares = round(BEFORE / DT), []
    for part in parted(made, settings.records):
        found = estimated(FUZZY, part.inputs, by_hand(settings))
        error = np.asarray(found.angles)[skipped:, :, 1] - np.asarray(part.truth)[skipped:]
        squares.append((error**2).mean(axis=0))
    return float(np.degrees(np.sqrt(np.concatenate(squares))).mean())


def passed(filter: AnyFilter, params: Any, inputs: Any) -> Any:
    """A filter's outputs over a record."""
    return run(filter, params, inputs)[1]


def _random(params: GpsAidedNoise, inputs: GpsAidedSample) -> Array:
    """Angles by the random law for every lambda, each with scales of its own."""

    def angles(one: GpsAidedNoise) -> Array:
        found: Array = run(Batched(RANDOM), one, inputs)[1].angles
        return found

    axes: list[Any] = [0 if name == "scale" else None for name in params._fields]
    return jax.vmap(angles, in_axes=(GpsAidedNoise(*axes),))(params)


_run: Callable[..., Any] = jax.jit(passed, static_argnums=0, compiler_options=QUICKLY)
_angles: Callable[..., Array] = jax.jit(_random, compiler_options=QUICKLY)
