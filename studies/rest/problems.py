"""The problems of an axis: its noise, and the filter that is asked for."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import FixedGainFilter, FixedGains, LevelSample, LocalLevel
from objectives import Data, InnovationLikelihood
from studies.rest import requirement as first_order
from studies.rest.averages import Averages, most_likely
from studies.rest.curve import Limited, Noise, read_noise
from studies.rest.data import Axis
from studies.rest.requirement import Kind, Requirement
from tuner.data.allan import allan_curve
from tuner.export.tuned import Quantity
from tuner.problem.constraint import Constraint
from tuner.problem.exported import Exported, Trial, exported_of
from tuner.problem.parameters import Fixed, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

TRIED = 20_000
"""Samples of a filter's test in single precision."""


@dataclass(frozen=True, eq=False)
class Rest:
    """An axis and its noise.

    Attributes:
        axis: the axis, in SI, as are all numbers here.
        noise: from its Allan curve.
        averages: means, on which the likelihood is based.
        white: N of greatest likelihood.
        walk: K of greatest likelihood.
        rate_hz: of the target.
        requirement: on the filter; None where there is none.
    """

    axis: Axis
    noise: Noise
    averages: Averages
    white: Limited
    walk: Limited
    rate_hz: float
    requirement: Requirement | None

    @property
    def dt(self) -> float:
        """Sample time of the target, s."""
        return 1 / self.rate_hz

    @property
    def R(self) -> float:
        """Variance of the white noise in a sample of the target."""
        return self.white.value**2 * self.rate_hz

    @property
    def Q(self) -> float:
        """Growth of the random walk's variance in a sample of the target."""
        return self.walk.value**2 / self.rate_hz

    @property
    def gain(self) -> float:
        """Gain of the filter: the least that meets the requirement, or the record's if larger."""
        own = first_order.kalman_gain(self.R, self.Q)
        return own if self.requirement is None else max(self.requirement.gain, own)


def rest_of(axis: Axis, rate_hz: float | None, demand: Mapping[Kind, float]) -> Rest:
    """The noise of an axis.

    Raises:
        ValueError: for a requirement that no filter meets, and a record that is too short for it.
    """
    rate = axis.rate_hz if rate_hz is None else rate_hz
    requirement = next((Requirement(name, x, 1 / rate) for name, x in demand.items()), None)
    if requirement is not None and 3 * requirement.span_s > axis.seconds:
        raise ValueError(
            f"{axis.source.name} lasts {axis.seconds:.4g} s, and a filter that "
            f"{requirement.words} needs {3 * requirement.span_s:.4g} s or more; record at rest "
            "for longer, or ask for a faster filter"
        )
    noise = read_noise(allan_curve(axis.values, axis.rate_hz))
    dt = 1 / axis.rate_hz
    averages = Averages.of(axis.values, dt, max(round(noise.from_s / dt), 1))
    white, walk = most_likely(averages)
    return Rest(axis, noise, averages, white, walk, rate, requirement)


def noise_problem(rest: Rest) -> Problem:
    """N and K by the likelihood of a local level; K is held at 0 where there is no sign of it."""
    averages, unit = rest.averages, rest.axis.unit
    R, Q = averages.level(rest.noise.white.value, max(rest.noise.walk.value, rest.walk.value))
    R = max(R, 0.1 * rest.noise.white.value**2 / averages.step)
    q = Q / averages.step
    walk: Parameter = Fixed(0.0, unit=f"({unit})^2/s", meaning="the record shows no random walk")
    if rest.walk.value > 0:
        walk = Positive(q, 1e-3 * q, 1e3 * q, f"({unit})^2/s", meaning="growth of the variance")
    filter = LocalLevel(averages.step)
    return Problem(
        name=rest.axis.name if rest.requirement is None else f"{rest.axis.name}_noise",
        space=Space.of(
            q=walk,
            R=Positive(R, 0.1 * R, 10 * R, f"({unit})^2", meaning="variance of a mean"),
        ),
        filter=filter,
        build=None,
        objective=InnovationLikelihood(),
        data=Data(LevelSample(jnp.asarray(averages.means)), np.zeros((len(averages.means), 1))),
        source=rest.axis.source,
        derive=partial(_derived, averages),
        exported=replace(exported_of(filter, unit), derived=partial(_noise_quantities, rest)),
    )


def _derived(averages: Averages, values: dict[str, Array]) -> dict[str, Array]:
    white, walk = averages.densities(values["R"], values["q"] * averages.step)
    return {"N": jnp.asarray(white), "K": jnp.asarray(walk)}


def filter_problem(rest: Rest) -> Problem:
    """The gain of least noise that meets the requirement.

    Raises:
        ValueError: where there is no requirement.
    """
    wanted = rest.requirement
    if wanted is None:
        raise ValueError(f"nothing is asked of the filter of {rest.axis.name}")
    K, unit = rest.gain, rest.axis.unit
    return Problem(
        name=rest.axis.name,
        space=Space.of(
            K1=Positive(K, 1e-3 * K, min(1e3 * K, 1.0), meaning="gain: x = x + K1 (z - x)")
        ),
        filter=None,
        build=_the_gain,
        objective=ErrorVariance(rest.R, rest.Q),
        constraints=(Constraint(wanted.kind, wanted.measure, wanted.most),),
        source=rest.axis.source,
        derive=partial(_of_the_gain, rest.dt),
        exported=Exported(
            "FixedGainFilter",
            ("level", "slope"),
            rest.dt,
            partial(_filter_told, rest),
            unit,
            runs=partial(_runs, rest),
        ),
    )


@dataclass(frozen=True)
class ErrorVariance:
    """Error variance of the filter's output, from R and Q per sample; an objective of the gain."""

    R: float
    Q: float

    def __call__(self, gain: Array, _: None) -> Array:
        """The variance, ``()``."""
        return first_order.error_variance(gain, self.R, self.Q)


def _the_gain(values: dict[str, Array]) -> Array:
    return values["K1"]


def _of_the_gain(dt: float, values: dict[str, Array]) -> dict[str, Array]:
    K = float(values["K1"])
    return {
        "settles_s": jnp.asarray(first_order.settling(K, dt)),
        "bandwidth_hz": jnp.asarray(first_order.bandwidth(K, dt)),
        "latency_s": jnp.asarray(first_order.latency(K, dt)),
    }


def _filter_told(rest: Rest, gain: Array) -> tuple[Quantity, ...]:
    K, unit = float(gain), rest.axis.unit
    deviation = np.sqrt(np.asarray(first_order.error_variance(K, rest.R, rest.Q)))
    return (
        Quantity("K2", np.array(0.0), "1/s", "gain on the slope: there is none"),
        Quantity("latency_s", first_order.latency(K, rest.dt), "s", "lag behind a steady change"),
        Quantity("settles_s", np.array(first_order.settling(K, rest.dt)), "s", "settling to 2 %"),
        Quantity("bandwidth_hz", np.array(first_order.bandwidth(K, rest.dt)), "Hz", "to -3 dB"),
        Quantity("output_sd", deviation, unit, "deviation of the output at rest"),
        *_noise_quantities(rest, None),
    )


def _noise_quantities(rest: Rest, _: object) -> tuple[Quantity, ...]:
    """Noise parameters of a Kalman filter: densities, and variances per sample on the target."""
    unit, at = rest.axis.unit, f"a sample at {rest.rate_hz:g} Hz"
    return (
        Quantity("noise_density", np.array(rest.white.value), f"{unit}/sqrt(Hz)", "N"),
        Quantity("random_walk", np.array(rest.walk.value), f"{unit}/s/sqrt(Hz)", "K"),
        Quantity("R_sample", np.array(rest.R), f"({unit})^2", f"variance of {at}"),
        Quantity("Q_sample", np.array(rest.Q), f"({unit})^2", f"growth of the bias in {at}"),
    )


def _runs(rest: Rest, gain: Array) -> dict[str, Trial]:
    K = jnp.asarray(gain)
    samples = jnp.asarray(rest.axis.values[:TRIED])
    gains = FixedGains(K, jnp.zeros_like(K))
    return {"fixed gain": Trial(FixedGainFilter(rest.dt), gains, samples)}
