"""Kownacki's cost (10): the lag of a filter behind a step, plus the noise it lets through.

The paper leaves open what its second term integrates. Three readings are offered by name; see
docs/kownacki2010.md for what each of them implies.
"""

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from objectives.welch import Welch


class Reading(Enum):
    """The integrand of the second integral of (10)."""

    R1 = "power spectral density of the whole output, step included: (10) to the letter"
    R2 = "power spectral density of the output's noise alone"
    R6 = "amplitude spectral density (root of the PSD) of the output's noise alone"


class Crossing(Enum):
    """The end of the first integral of (10)."""

    HINGE = "nowhere, but only the part below the step counts: differentiable"
    FIRST = "at the first sample that reaches the step, as printed; has jumps"


class StepCost(NamedTuple):
    """The two integrals of (10).

    Attributes:
        inertia: integral of the squared lag behind the step, unit^2 s.
        noise: integral of the output's spectrum, unit^2 (R1, R2) or unit Hz^1/2 (R6).
    """

    inertia: Array
    noise: Array


class StepTruth(NamedTuple):
    """The reference of each sample, ``(N,)`` each.

    Attributes:
        step: the step signal S.
        lag_weight: trapezoidal weight of the squared lag, s; 0 before the step.
        last_weight: the same for the sample at which the integral ends, s.
        power_weight: Parseval weight of the squared output (:meth:`Welch.power_weights`); NaN for
            R6, which takes none.
    """

    step: Array
    lag_weight: Array
    last_weight: Array
    power_weight: Array


class StepSum(NamedTuple):
    """Both partial integrals, and whether the output has reached the step."""

    inertia: Array
    power: Array
    reached: Array


@dataclass(frozen=True)
class StepResponse:
    """Cost (10) of a filter's output, summed up inside the time loop.

    The filter takes two signals through the same gains, the step and the record, and being
    linear it answers each as if alone: outputs ``(2,)`` a sample, step first. Under R1 only their
    sum counts, so one signal, their sum, will do. Only R6 keeps anything for after the loop, the
    noise: under R1 and R2 the integral of the spectrum is a weighted sum of squares (Parseval).

    Attributes:
        dt: sample time, s.
        welch: how the spectrum is estimated.
        reading: the integrand of the second integral.
        crossing: where the first integral ends.
        weight: factor on the second integral; the paper's is 1.
    """

    dt: float
    welch: Welch
    reading: Reading = Reading.R6
    crossing: Crossing = Crossing.HINGE
    weight: float = 1.0

    def truth(self, step: np.ndarray) -> StepTruth:
        """The weights of both integrals for a step signal ``(N,)``, 0 before the step enters.

        Raises:
            ValueError: where the signal is not 0 first and above 0 from then on, or the record is
                shorter than a Welch segment (under R6 :meth:`parts` says so).
        """
        step = np.asarray(step)
        samples = len(step)
        enters = int(np.argmax(step != 0))
        if enters == 0 or not (step[enters:] > 0).all():
            raise ValueError(
                "the step signal must be 0 at first, rise within the record and stay above 0"
            )
        lag_weight, last_weight = np.zeros((2, samples))
        last_weight[enters + 1 :] = self.dt / 2
        lag_weight[enters:-1] = self.dt / 2
        lag_weight += last_weight
        power_weight = np.full(samples, np.nan)  # R6 takes none, and any detrend or average
        if self.reading is not Reading.R6:
            power_weight = self.welch.power_weights(samples)
        columns = step, lag_weight, last_weight, power_weight
        return StepTruth(*(jnp.asarray(column) for column in columns))

    def init(self) -> StepSum:
        """Empty integrals, and the step not reached."""
        return StepSum(jnp.zeros(()), jnp.zeros(()), jnp.zeros((), bool))

    def update(
        self, total: StepSum, output: Array, truth: StepTruth
    ) -> tuple[StepSum, Array | None]:
        """Add one sample's lag and power; under R6 its noise is kept instead of its power."""
        whole = output.sum()
        inertia, reached = self._inertia(total, truth.step - whole, truth)
        if self.reading is Reading.R6:
            return StepSum(inertia, total.power, reached), output[1]
        signal = whole if self.reading is Reading.R1 else output[1]
        return StepSum(inertia, total.power + truth.power_weight * signal**2, reached), None

    def value(self, total: StepSum, kept: Array | None) -> Array:
        """The cost, ``()``."""
        inertia, noise = self.parts(total, kept)
        return inertia + self.weight * noise

    def parts(self, total: StepSum, kept: Array | None) -> StepCost:
        """Both integrals, the second without its weight."""
        if kept is None:
            return StepCost(total.inertia, total.power)
        resolution = 1 / (self.welch.nfft * self.dt)
        density = self.welch.psd(kept, self.dt)
        some = density > 0  # the root has no slope at 0
        amplitude = jnp.where(some, jnp.sqrt(jnp.where(some, density, 1.0)), 0.0)
        return StepCost(total.inertia, amplitude.sum() * resolution)

    def _inertia(self, total: StepSum, lag: Array, truth: StepTruth) -> tuple[Array, Array]:
        if self.crossing is Crossing.HINGE:
            # Not jnp.maximum: where it is 0, so is the derivative, whatever a tie is worth.
            late = jnp.where(lag <= 0, 0.0, lag)
            return total.inertia + truth.lag_weight * late**2, total.reached
        arrived = (lag <= 0) & (truth.step != 0)
        weight = jnp.where(arrived, truth.last_weight, truth.lag_weight)
        weight = jnp.where(total.reached, 0.0, weight)
        return total.inertia + weight * lag**2, total.reached | arrived
