"""The paper's two sensors, a record of each, and the problems posed on them."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

import jax.numpy as jnp
import numpy as np
from jax import Array
from pydantic import Field, field_validator

from filters import (
    AccelerometerFilter,
    GyroscopeFilter,
    KownackiNoise,
    SteadyState,
    accelerometer_steady,
    gyroscope_steady,
)
from objectives import Crossing, Data, Reading, StepResponse, Welch
from tuner.data.logs import Log
from tuner.data.noise_split import NoiseSplit, split_noise
from tuner.names import unknown
from tuner.problem.parameters import Fixed, Positive, covariance
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.run.settings import StudySettings
from tuner.solvers import SOLVERS


@dataclass(frozen=True)
class Sensor:
    """One of the paper's two sensors: its filter and its published values.

    Attributes:
        name: what its rows and files are called.
        channel: what ``--map`` calls its record.
        unit: of its record; the paper prints none.
        filter: its filter, (8) or (9).
        steady: its steady gains in closed form.
        states: what the filter estimates; the accelerometer's velocity is not observable.
        table1: R and Q from a motionless record.
        table2: R and Q from the optimisation.
    """

    name: str
    channel: str
    unit: str
    filter: type[AccelerometerFilter] | type[GyroscopeFilter]
    steady: Callable[[Array | float, float], SteadyState]
    states: tuple[str, ...]
    table1: NoiseSplit
    table2: NoiseSplit


GYRO = Sensor(
    "gyro",
    "omega",
    "rad/s",
    GyroscopeFilter,
    gyroscope_steady,
    ("omega", "epsilon"),
    NoiseSplit(1.3872e-6, 2.4907e-9),
    NoiseSplit(1.9148e-10, 1.9674e-7),
)
ACC = Sensor(
    "acc",
    "a",
    "m/s^2",
    AccelerometerFilter,
    accelerometer_steady,
    ("a",),
    NoiseSplit(1.8472e-4, 1.1859e-8),
    NoiseSplit(5.8631e-13, 1.3458e-11),
)


class Settings(StudySettings):
    """What can be set with ``--set``; the defaults are the paper's wherever it names a value."""

    step: float = Field(0.2, gt=0, description="height of the step, in the record's unit")
    reading: Literal["R1", "R2", "R6"] = Field("R6", description="what (10)'s second term means")
    crossing: Literal["hinge", "first"] = Field("hinge", description="where (10)'s first term ends")
    weight: float = Field(1.0, gt=0, description="factor on (10)'s second term")
    cutoff_hz: float = Field(1.0, gt=0, description="where Table 1's procedure splits a record")
    split: Literal["ideal", "butterworth"] = Field("ideal", description="the filters it uses")
    R: float | None = Field(
        None, gt=0, description="measurement variance; from the record if unset"
    )
    Q: float | None = Field(None, gt=0, description="where Q starts; from the record if unset")
    P0: tuple[tuple[float, float], tuple[float, float]] = Field(
        ((1.0, 1.0), (1.0, 1.0)), description="covariance of the start"
    )
    solvers: tuple[str, ...] = Field(
        ("nelder-mead", "l-bfgs-b"), min_length=1, description="of tuner list solvers"
    )
    starts: int = Field(4, ge=1, description="starts of each descent")
    rate_hz: float = Field(10_000.0, gt=0, description="of the built-in record")
    seconds: float = Field(10.0, gt=0, description="length of the built-in record")
    grid: int = Field(25, ge=2, le=257, description="points along each axis of Fig 8")

    @field_validator("P0")
    @classmethod
    def _covariance(cls, value: tuple[tuple[float, ...], ...]) -> tuple[tuple[float, ...], ...]:
        if min(row[i] for i, row in enumerate(covariance(value))) <= 0:
            raise ValueError("must have a positive diagonal: a start known exactly never learns")
        return value

    @field_validator("solvers", mode="before")
    @classmethod
    def _separate(cls, value: object) -> object:
        return value.split(",") if isinstance(value, str) else value

    @field_validator("solvers")
    @classmethod
    def _known(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        for name in value:
            if name not in SOLVERS:
                raise unknown("solver", name, SOLVERS)
        return value


@dataclass(frozen=True, eq=False)
class Bench:
    """A sensor with a record, ready for the step test.

    Attributes:
        sensor: the sensor.
        unit: of the record.
        record: at rest, mean removed, ``(N,)``.
        dt: sample time, s.
        noise: R and Q by Table 1's procedure.
        settings: the study's.
    """

    sensor: Sensor
    unit: str
    record: np.ndarray
    dt: float
    noise: NoiseSplit
    settings: Settings

    @property
    def step(self) -> np.ndarray:
        """The step signal S, which enters in the middle of the record, ``(N,)``."""
        rises = np.arange(len(self.record)) >= len(self.record) // 2
        return np.where(rises, self.settings.step, 0.0)

    @property
    def signals(self) -> np.ndarray:
        """Step and record side by side, ``(N, 2)``: one pass answers both."""
        return np.stack([self.step, self.record], axis=1)

    @property
    def filter(self) -> AccelerometerFilter | GyroscopeFilter:
        """The sensor's filter for two signals."""
        return self.sensor.filter(self.dt, (2,))

    @property
    def R(self) -> float:
        """The measurement variance that is held fixed."""
        return self.noise.R if self.settings.R is None else self.settings.R

    @property
    def Q(self) -> float:
        """Where the search for Q starts."""
        return self.noise.Q if self.settings.Q is None else self.settings.Q

    def objective(self, reading: str, crossing: str = "hinge", weight: float = 1.0) -> StepResponse:
        """Cost (10) under a reading."""
        welch = Welch.matlab(len(self.record))
        return StepResponse(self.dt, welch, Reading[reading], Crossing[crossing.upper()], weight)

    def problem(self) -> Problem:
        """Minimise (10) over Q, with R as measured: well posed, for only Q/R counts."""
        s = self.settings
        return self._problem("", self.objective(s.reading, s.crossing, s.weight), free_R=False)

    def paper(self) -> Problem:
        """Minimise (10) over R and Q together, as the paper does: ill posed."""
        s = self.settings
        return self._problem(".paper", self.objective(s.reading, s.crossing, s.weight), free_R=True)

    def literal(self) -> Problem:
        """Minimise (10) over Q to the letter: reading R1, up to the first crossing."""
        return self._problem(".literal", self.objective("R1", "first"), free_R=False)

    def _problem(self, suffix: str, objective: StepResponse, *, free_R: bool) -> Problem:
        # Wide enough for any unit of the record.
        free = Positive(
            self.R,
            low=min(1e-13, 1e-4 * self.R),
            high=max(1.0, 1e3 * self.R),
            unit=f"({self.unit})^2",
        )
        low, high = 1e-8 * self.R, 1e10 * self.R
        if free_R:
            low, high = min(1e-13, 1e-7 * self.R), max(1e2, 1e4 * self.R)
        return Problem(
            name=self.sensor.name + suffix,
            space=Space.of(
                R=free if free_R else Fixed(self.R, unit=free.unit),
                Q=Positive(np.clip(self.Q, low, high), low, high, unit=f"({self.unit})^2/s^2"),
                P0=Fixed(self.settings.P0, unit=free.unit),
            ),
            filter=self.filter,
            build=noise,
            objective=objective,
            data=Data(self.signals, objective.truth(self.step)),
            derive=partial(derived, self.sensor.steady, self.dt),
        )

    def steady(self, q_over_r: float) -> tuple[float, ...]:
        """K1, K2 and bandwidth in Hz once P0 is forgotten."""
        gains, bandwidth = self.sensor.steady(q_over_r, self.dt)
        return tuple(float(np.asarray(part)) for part in (*gains, bandwidth))


def noise(values: dict[str, Array]) -> KownackiNoise:
    """The filters' parameters from the space's."""
    return KownackiNoise(values["R"], values["Q"], values["P0"])


def derived(
    steady: Callable[[Array, float], SteadyState], dt: float, values: dict[str, Array]
) -> dict[str, Array]:
    """What Q and R come to: only their ratio counts once P0 is forgotten."""
    ratio = values["Q"] / values["R"]
    (K1, K2), bandwidth = steady(ratio, dt)
    return {
        "q_over_r": ratio,
        "k1": jnp.asarray(K1),
        "k2": jnp.asarray(K2),
        "bandwidth_hz": bandwidth,
    }


def synthetic(sensor: Sensor, settings: Settings, seed: int) -> np.ndarray:
    """A motionless record: white noise with Table 1's R as its variance, ``(N,)``."""
    samples = round(settings.seconds * settings.rate_hz) + 1
    draw = np.random.default_rng([seed, [GYRO, ACC].index(sensor)])
    return np.asarray(np.sqrt(sensor.table1.R) * draw.standard_normal(samples))


def benches(settings: Settings, log: Log | None, seed: int) -> list[Bench]:
    """The sensors to be tuned: both on made-up records, or those that a log maps."""
    made = []
    for sensor in (GYRO, ACC):
        if log is None:
            record, rate, unit = synthetic(sensor, settings, seed), settings.rate_hz, sensor.unit
        elif sensor.channel in log.channels:
            record, rate = log.channels[sensor.channel], log.rate_hz
            unit = log.units[sensor.channel] or sensor.unit
        else:
            continue
        Welch.matlab(len(record))  # a record too short for it cannot be split either
        split = split_noise(record, rate, settings.cutoff_hz, settings.split)
        made.append(Bench(sensor, unit, record - record.mean(), 1 / rate, split, settings))
    if not made:
        raise ValueError("the log has neither channel: map one with --map omega=COLUMN or a=COLUMN")
    return made
