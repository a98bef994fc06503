"""The filter of the flights, its free parameters, and its tuning problems."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

import jax.numpy as jnp
import numpy as np
from jax import Array
from scipy.spatial.transform import Rotation

from filters import GpsAidedKalman, GpsAidedNoise, GpsAidedSample, assembled, parameter_facts
from objectives import Data, InnovationLikelihood
from studies.uav.flights import Flight
from studies.uav.settings import ANGLES, Angle
from tuner.problem.parameters import Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

Tuned = Literal["constant", "fuzzy"]
LAWS: tuple[Tuned, ...] = get_args(Tuned)
PROCESS = {"constant": "Q", "fuzzy": "floor"}
"""Names of a law's free parameters: the noise itself, or its lower limit."""


@dataclass(frozen=True)
class Build:
    """The map from free parameters to the filter's; the others are typical.

    Attributes:
        law: of the process noise.
        start: (phi, theta, psi) at which the flight begins, rad.
    """

    law: Tuned
    start: tuple[float, ...]

    def __call__(self, values: Mapping[str, Array | float]) -> GpsAidedNoise:
        """R by angle; process noise equal for the quaternion's parts and for the biases."""
        kind = PROCESS[self.law]
        facts = parameter_facts(GpsAidedKalman)
        numbers: dict[str, Any] = {name: fact.typical for name, fact in facts.items()} | {**values}
        for part in ("quaternion", "bias"):
            # Of a fuzzy law Q holds until there are two residuals.
            each = values[f"{kind}_{part}"]
            numbers |= {f"Q_{part}": each, f"floor_{part}": each}
        start = quaternion(np.array(self.start))
        found: GpsAidedNoise = assembled(GpsAidedKalman, numbers | {"q0": start})
        return found


def quaternion(angles: np.ndarray) -> np.ndarray:
    """From body to north, east, down, scalar first, of (phi, theta, psi) in rad, ``(4,)``."""
    turn = Rotation.from_euler("ZYX", angles[::-1])
    return np.asarray(turn.as_quat(scalar_first=True))


def filter_of(law: Tuned, dt: float, every: int) -> GpsAidedKalman:
    """The filter with a law."""
    return GpsAidedKalman(dt, every=every, law=law)


def space(law: Tuned, measured: tuple[Angle, ...]) -> Space:
    """R of each measured angle and two parameters of the process noise, for either law."""
    kind = PROCESS[law]
    ranges = {f"R_{angle}": (0.05, 1e-5, 10.0) for angle in measured}
    ranges |= {f"{kind}_quaternion": (1e-6, 1e-10, 1.0), f"{kind}_bias": (1e-5, 1e-12, 1e-1)}
    facts = parameter_facts(GpsAidedKalman)
    free = {
        name: Positive(*numbers, facts[name].unit, meaning=facts[name].meaning)
        for name, numbers in ranges.items()
    }
    return Space.of(**free)


def livelier(law: Tuned, measured: tuple[Angle, ...]) -> np.ndarray:
    """A second start, with more noise of the quaternion and less of the biases."""
    kind = PROCESS[law]
    return space(law, measured).unconstrain({f"{kind}_quaternion": 1e-4, f"{kind}_bias": 1e-6})


def data(flight: Flight, measured: tuple[Angle, ...]) -> Data:
    """A flight as data of filter and likelihood; NaN for angles that are left out."""
    z = jnp.asarray(np.where([angle in measured for angle in ANGLES], flight.z, np.nan))
    return Data(GpsAidedSample(jnp.asarray(flight.rate), z), z)


def problem(flight: Flight, law: Tuned, measured: tuple[Angle, ...]) -> Problem:
    """The law tuned on a flight by the likelihood of its innovations."""
    return Problem(
        name=law,
        space=space(law, measured),
        filter=filter_of(law, flight.dt, flight.every),
        build=Build(law, tuple(flight.first.tolist())),
        objective=InnovationLikelihood(),
        data=data(flight, measured),
        known_starts=(livelier(law, measured),),
        source=flight.source,
    )


def fold_name(flight: str) -> str:
    """The name of the problem that leaves a flight out."""
    return f"without_{flight}"


def alone_name(flight: str) -> str:
    """The name of the problem that is tuned on one flight, and judged on the same."""
    return f"alone_{flight}"


def start_values(law: Tuned, measured: tuple[Angle, ...]) -> dict[str, Array]:
    """The start of a search: untuned, round numbers."""
    known = space(law, measured)
    return known.constrain(jnp.asarray(known.start()))


def parameters(flight: Flight, law: Tuned, values: Mapping[str, Array | float]) -> GpsAidedNoise:
    """The filter's parameters on a flight, from tuned values."""
    return Build(law, tuple(flight.first.tolist()))(values)
