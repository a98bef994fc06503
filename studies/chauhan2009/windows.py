"""The tuned filters over whole periods of ticks, with a window that comes with the data.

Windows share one compilation so, and what only a measurement asks for is computed once a period.
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
        most: how many residuals the law may take, ``()``.
    """

    gyr: Array
    angles: Array
    most: Array


@dataclass(frozen=True)
class ByPeriod:
    """A filter that takes a period at a time; its output is the angles at the ticks alone.

    It finds what the filter finds tick by tick. With the newest of a longer window it finds what a
    filter with the shorter one finds.

    Attributes:
        filter: the filter, with the longest window.
    """

    filter: GpsAidedKalman
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
        state, outputs = self.filter.corrected(params, state._replace(residuals=short), ahead, last)
        whole = jnp.concatenate([angles[:-1], outputs.angles[None]])
        nothing: Any = dict.fromkeys(GpsAidedOutputs._fields)
        return state, GpsAidedOutputs(**nothing | {"angles": whole})


def by_period(made: Records, samples: int) -> Data:
    """Records for :class:`ByPeriod`, filled up to whole periods by NaN."""
    gyr, angles, truth = map(_periods, (made.inputs.gyr, made.inputs.angles, made.truth))
    most = jnp.asarray(np.full(truth.shape[:2], float(samples)))  # of one type with slices of it
    return Data(Period(gyr, angles[:, :, -1], most), truth)


def _periods(part: Array) -> Array:
    """Ticks ``(N, k, ...)`` by periods, ``(M, k, EVERY, ...)``."""
    ticks = np.asarray(part)
    more = [(0, -len(ticks) % EVERY), *[(0, 0)] * (ticks.ndim - 1)]
    full = np.pad(ticks, more, constant_values=np.nan)
    return jnp.asarray(np.moveaxis(full.reshape(-1, EVERY, *ticks.shape[1:]), 1, 2))


def exported(filter: GpsAidedKalman, made: Records) -> Exported:
    """The export of a filter that is tuned as :class:`ByPeriod`: itself."""
    return replace(exported_of(filter), runs=partial(_itself, filter, made))


def _itself(filter: GpsAidedKalman, made: Records, params: GpsAidedNoise) -> dict[str, Trial]:
    return {"full": Trial(Lanes(filter, made.truth.shape[1]), params, made.inputs)}
