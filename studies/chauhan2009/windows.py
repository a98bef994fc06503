"""The fuzzy law with a window that comes with the data, so that windows share one compilation."""

from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import GpsAidedKalman, GpsAidedNoise, GpsAidedSample, Lanes
from filters.gps_aided import GpsAidedOutputs, GpsAidedState
from objectives import Data
from studies.chauhan2009.data import Records
from tuner.problem.exported import Exported, Trial, exported_of


class WindowedSample(NamedTuple):
    """A tick's inputs, and how many residuals the law may take, ``()``."""

    sample: GpsAidedSample
    most: Array


@dataclass(frozen=True)
class Windowed:
    """A fuzzy filter that never counts more residuals than its data say.

    With the newest of a longer window it finds what a filter with the shorter one finds.

    Attributes:
        filter: with the longest window.
    """

    filter: GpsAidedKalman
    same_params = True

    def init(self, params: GpsAidedNoise) -> GpsAidedState:
        """The filter's own start."""
        return self.filter.init(params)

    def step(
        self, params: GpsAidedNoise, state: GpsAidedState, inputs: WindowedSample
    ) -> tuple[GpsAidedState, GpsAidedOutputs]:
        """Take one sample, which adds one residual at most."""
        known = state.residuals
        short = known._replace(taken=jnp.minimum(known.taken, inputs.most - 1))
        return self.filter.step(params, state._replace(residuals=short), inputs.sample)


def windowed(made: Records, samples: int) -> Data:
    """Records with a window for :class:`Windowed`."""
    most = np.full(np.shape(made.truth), float(samples))
    return Data(WindowedSample(made.inputs, jnp.asarray(most)), made.truth)


def exported(filter: GpsAidedKalman, made: Records) -> Exported:
    """The export of a filter that is tuned as :class:`Windowed`: itself."""
    return replace(exported_of(filter), runs=partial(_itself, filter, made))


def _itself(filter: GpsAidedKalman, made: Records, params: GpsAidedNoise) -> dict[str, Trial]:
    return {"full": Trial(Lanes(filter, made.truth.shape[1]), params, made.inputs)}
