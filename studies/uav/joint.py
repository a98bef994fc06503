"""Joint tuning on several flights: one after another, each from its own start."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import GpsAidedKalman, GpsAidedNoise, GpsAidedSample
from filters.gps_aided import GpsAidedOutputs
from objectives import Data, InnovationLikelihood
from studies.uav.flights import Flight
from studies.uav.problems import Build, Tuned, data, filter_of, livelier, quaternion, space
from studies.uav.settings import Angle
from tuner.data.source import Source
from tuner.names import counted
from tuner.problem.problem import Problem

LEVEL = (0.0, 0.0, 0.0)
"""Roll, pitch and yaw before the first flight, rad."""


class InTurn(NamedTuple):
    """A tick of successive flights: the sample, and at a flight's start its attitude ``(4,)``.

    The attitude is NaN at all other ticks.
    """

    sample: GpsAidedSample
    begins: Array


@dataclass(frozen=True)
class OneAfterAnother:
    """A filter that restarts at the start of each flight."""

    filter: GpsAidedKalman

    def init(self, params: GpsAidedNoise) -> Any:
        """The filter's own start, which the first tick replaces."""
        return self.filter.init(params)

    def step(
        self, params: GpsAidedNoise, state: Any, inputs: InTurn
    ) -> tuple[Any, GpsAidedOutputs]:
        """A tick, from a new state where a flight begins."""
        new = ~jnp.isnan(inputs.begins).any()
        q0 = jnp.where(new, inputs.begins, params.q0)  # finite, for NaN would spoil the gradient
        fresh = self.filter.init(params._replace(q0=q0))
        begun = jax.tree.map(lambda a, b: jnp.where(new, a, b), fresh, state)
        return self.filter.step(params, begun, inputs.sample)


def joint(
    name: str, flights: Sequence[Flight], law: Tuned, measured: tuple[Angle, ...], ticks: int = 0
) -> Problem:
    """A law tuned on several flights by the likelihood of all their innovations.

    GPS measurements in a glitch do not count. Problems of as many ticks share one compilation.

    Args:
        name: of the problem.
        flights: at least one, all with the same ticks.
        law: of the process noise.
        measured: which angles are used.
        ticks: as many ticks at least; those after the flights measure nothing.

    Raises:
        ValueError: for no flights, and where a glitch leaves no measurement.
    """
    if not flights:
        raise ValueError(f"{name} has no flight to tune on; give at least one")
    parts = [_in_turn(flight, measured) for flight in flights]
    inputs = _filled(jax.tree.map(lambda *leaves: np.concatenate(leaves), *parts), ticks)
    first = flights[0]
    return Problem(
        name=name,
        space=space(law, measured),
        filter=OneAfterAnother(filter_of(law, first.dt, first.every)),
        build=Build(law, LEVEL),  # the first tick brings its own attitude
        objective=InnovationLikelihood(),
        data=Data(inputs, inputs.sample.angles),
        known_starts=(livelier(law, measured),),
        source=Source.joined(counted(len(flights), "flight"), [each.source for each in flights]),
    )


def _filled(inputs: InTurn, ticks: int) -> InTurn:
    """The ticks, and as many after them as are missing, without turn and measurement."""
    missing = max(ticks - len(inputs.begins), 0)
    still, nothing = jnp.zeros((missing, 3)), jnp.full((missing, 3), jnp.nan)
    after = InTurn(GpsAidedSample(still, nothing), jnp.full((missing, 4), jnp.nan))
    filled: InTurn = jax.tree.map(lambda *both: jnp.asarray(np.concatenate(both)), inputs, after)
    return filled


def _in_turn(flight: Flight, measured: tuple[Angle, ...]) -> InTurn:
    sample: GpsAidedSample = data(flight, measured).inputs
    believed = np.where(flight.glitch[:, None], np.nan, np.asarray(sample.angles))
    if np.isnan(believed).all():
        raise ValueError(f"no measurement of {flight.name} lies outside its glitch")
    begins = np.full((len(flight.t), 4), np.nan)
    begins[0] = quaternion(flight.first)
    return InTurn(sample._replace(angles=jnp.asarray(believed)), jnp.asarray(begins))
