"""The tuned filters over whole periods of ticks, with a window or a law that comes with the data.

Filters share compilations so, and what only a measurement asks for is computed once a period.
"""

from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import GpsAidedKalman, GpsAidedNoise, GpsAidedSample, Lanes
from filters.gps_aided import GpsAidedOutputs, GpsAidedState
from filters.kalman import Estimate
from filters.protocol import over_time
from objectives import Data
from studies.chauhan2009.data import Records
from studies.chauhan2009.paper import EVERY
from tuner.problem.exported import Exported, Trial, exported_of


class Period(NamedTuple):
    """The ticks from one measurement to the next.

    Attributes:
        gyr: rates of the ticks, rad/s, ``(EVERY, 3)``.
        angles: what is measured at the last one, rad, ``(3,)``.
        most: how many residuals the fuzzy law may take, ``()``; with 1 of them Q stays constant.
        edge: share of the band's spread in the law's slope, ``()``.
    """

    gyr: Array
    angles: Array
    most: Array
    edge: Array


@dataclass(frozen=True)
class ByPeriod:
    """A filter that takes a period at a time; its output is the angles at the ticks alone.

    It finds what the filter finds tick by tick. With the newest of a longer window it finds what a
    filter with the shorter one finds.

    Attributes:
        filter: the filter, with the longest window.
        any_law: whether the data say by ``edge`` which slope the fuzzy law takes. With that it
            finds what any fuzzy filter finds, and with one residual what a constant Q gives.
    """

    filter: GpsAidedKalman
    any_law: bool = False
    same_params = True

    def init(self, params: GpsAidedNoise) -> GpsAidedState:
        """The filter's own start."""
        return self.filter.init(params)

    def step(
        self, params: GpsAidedNoise, state: GpsAidedState, inputs: Period
    ) -> tuple[GpsAidedState, GpsAidedOutputs]:
        """Take one period, which adds one residual at most; the angles are ``(EVERY, 3)``."""

        def tick(estimate: Estimate, rate: Array) -> tuple[Estimate, Array]:
            ahead = self.filter.ahead(state._replace(estimate=estimate), rate)
            return ahead, self.filter.angles(ahead.x)

        ahead, angles = over_time(tick, state.estimate, inputs.gyr)
        known = state.residuals
        short = known._replace(taken=jnp.minimum(known.taken, inputs.most - 1))
        last = GpsAidedSample(inputs.gyr[-1], inputs.angles)
        before, edge = state._replace(residuals=short), inputs.edge if self.any_law else None
        state, outputs = self.filter.corrected(params, before, ahead, last, edge)
        whole = jnp.concatenate([angles[:-1], outputs.angles[None]])
        nothing: Any = dict.fromkeys(GpsAidedOutputs._fields)
        return state, GpsAidedOutputs(**nothing | {"angles": whole})


def by_period(made: Records, filter: GpsAidedKalman) -> Data:
    """Records for :class:`ByPeriod` that finds what a filter does, filled up to whole periods."""
    gyr, angles, truth = map(_periods, (made.inputs.gyr, made.inputs.angles, made.truth))
    most = filter.samples if filter.law == "fuzzy" else 1
    law = (np.full(truth.shape[:2], float(x)) for x in (most, filter.slope == "edge"))
    return Data(Period(*map(jnp.asarray, (gyr, angles[:, :, -1], *law))), jnp.asarray(truth))


def _periods(part: Array) -> np.ndarray:
    """Ticks ``(N, k, ...)`` by periods, ``(M, k, EVERY, ...)``."""
    ticks = np.asarray(part)
    more = [(0, -len(ticks) % EVERY), *[(0, 0)] * (ticks.ndim - 1)]
    full = np.pad(ticks, more, constant_values=np.nan)
    return np.moveaxis(full.reshape(-1, EVERY, *ticks.shape[1:]), 1, 2)


def exported(filter: GpsAidedKalman, made: Records) -> Exported:
    """The export of a filter that is tuned as :class:`ByPeriod`: itself."""
    return replace(exported_of(filter), runs=partial(_itself, filter, made))


def _itself(filter: GpsAidedKalman, made: Records, params: GpsAidedNoise) -> dict[str, Trial]:
    return {"full": Trial(Lanes(filter, made.truth.shape[1]), params, made.inputs)}
