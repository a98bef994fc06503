"""The filter that flights are estimated by, what is free in it, and the problems it is tuned in."""

from dataclasses import dataclass
from typing import Any, Literal, get_args

import jax.numpy as jnp
import numpy as np
from jax import Array
from scipy.spatial.transform import Rotation

from filters import GpsAidedKalman, GpsAidedNoise, GpsAidedSample
from objectives import Data, InnovationLikelihood
from studies.uav.flights import Flight
from tuner.problem.parameters import Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

Angle = Literal["phi", "theta", "psi"]
Tuned = Literal["constant", "fuzzy"]
ANGLES: tuple[Angle, ...] = get_args(Angle)
LAWS: tuple[Tuned, ...] = get_args(Tuned)
STATES = (*(f"q{i}" for i in range(4)), *(f"bias_{axis}" for axis in "xyz"))
VARIANCE0 = {"quaternion": 0.05, "bias": 1e-3}
"""Variances at the start: half a radian of attitude, 0.03 rad/s of bias."""
PROCESS = {"constant": "Q", "fuzzy": "floor"}
"""What a law's free numbers are called: the noise itself, or the least that it may be."""
UNITS = {"quaternion": "1/s", "bias": "rad^2/s^3"}


@dataclass(frozen=True)
class Build:
    """From free numbers to what the filter takes.

    Attributes:
        law: of the process noise.
        measured: the angles that are taken; R of the others does not matter.
        start: (phi, theta, psi) at which the flight begins, rad.
    """

    law: Tuned
    measured: tuple[Angle, ...]
    start: tuple[float, ...]

    def __call__(self, values: dict[str, Array]) -> GpsAidedNoise:
        """R by angle; process noise equal for the quaternion's parts and for the biases."""
        kind = PROCESS[self.law]
        numbers = {f"R_{a}": jnp.asarray(values.get(f"R_{a}", 1.0), float) for a in ANGLES}
        for part in UNITS:
            # Of a fuzzy law Q holds until there are two residuals.
            each = jnp.asarray(values[f"{kind}_{part}"])
            numbers |= {f"Q_{part}": each, f"floor_{part}": each}
            numbers |= {f"P0_{part}": jnp.asarray(VARIANCE0[part])}
        q0 = jnp.asarray(quaternion(np.array(self.start)))
        return GpsAidedNoise(**numbers, h=jnp.zeros(()), scale=jnp.zeros(7), q0=q0, b0=jnp.zeros(3))


def quaternion(angles: np.ndarray) -> np.ndarray:
    """From body to north, east, down, scalar first, of (phi, theta, psi) in rad, ``(4,)``."""
    turn = Rotation.from_euler("ZYX", angles[::-1])
    return np.asarray(turn.as_quat(scalar_first=True))


def filter_of(law: Tuned, dt: float, every: int) -> GpsAidedKalman:
    """The filter with a law."""
    return GpsAidedKalman(dt, every=every, law=law)


def space(law: Tuned, measured: tuple[Angle, ...]) -> Space:
    """R of each measured angle and two numbers of the process noise, as many for either law."""
    kind = PROCESS[law]
    free = {
        f"R_{angle}": Positive(init=0.05, low=1e-5, high=10.0, unit="rad^2") for angle in measured
    }
    free |= {
        f"{kind}_quaternion": Positive(init=1e-6, low=1e-10, high=1.0, unit=UNITS["quaternion"]),
        f"{kind}_bias": Positive(init=1e-5, low=1e-12, high=1e-1, unit=UNITS["bias"]),
    }
    return Space.of(**free)


def data(flight: Flight, measured: tuple[Angle, ...]) -> Data:
    """A flight as filter and likelihood take it; NaN for angles that are left out."""
    z = jnp.asarray(np.where([angle in measured for angle in ANGLES], flight.z, np.nan))
    return Data(GpsAidedSample(jnp.asarray(flight.rate), z), z)


def problem(flight: Flight, law: Tuned, measured: tuple[Angle, ...]) -> Problem:
    """The law tuned on a flight by the likelihood of its innovations."""
    tuned = space(law, measured)
    kind = PROCESS[law]
    livelier = tuned.unconstrain({f"{kind}_quaternion": 1e-4, f"{kind}_bias": 1e-6})
    return Problem(
        name=law,
        space=tuned,
        filter=filter_of(law, flight.dt, flight.every),
        build=Build(law, measured, tuple(flight.first.tolist())),
        objective=InnovationLikelihood(),
        data=data(flight, measured),
        known_starts=(livelier,),
    )


def parameters(flight: Flight, law: Tuned, values: dict[str, Any]) -> GpsAidedNoise:
    """What the filter takes on a flight, of tuned numbers."""
    measured = tuple(angle for angle in ANGLES if f"R_{angle}" in values)
    return Build(law, measured, tuple(flight.first.tolist()))(values)
