"""Motionless records, made up or measured, ready for the step test."""

from dataclasses import dataclass

import numpy as np

from filters import AccelerometerFilter, GyroscopeFilter
from objectives import Welch
from studies.kownacki2010.paper import ACC, GYRO, Sensor
from studies.kownacki2010.settings import Settings
from tuner.data.logs import Log
from tuner.data.noise_split import NoiseSplit, split_noise
from tuner.data.source import Source


@dataclass(frozen=True, eq=False)
class Bench:
    """A sensor with a record, ready for the step test.

    Attributes:
        sensor: the sensor.
        unit: of the record.
        record: at rest, mean removed, ``(N,)``.
        dt: sample time, s.
        noise: R and Q by Table 1's procedure.
        source: where the record comes from.
        settings: the study's.
    """

    sensor: Sensor
    unit: str
    record: np.ndarray
    dt: float
    noise: NoiseSplit
    source: Source
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

    def steady(self, q_over_r: float) -> tuple[float, ...]:
        """K1, K2 and bandwidth in Hz once P0 is forgotten."""
        gains, bandwidth = self.sensor.steady(q_over_r, self.dt)
        return tuple(float(np.asarray(part)) for part in (*gains, bandwidth))


def synthetic(sensor: Sensor, settings: Settings, seed: int) -> np.ndarray:
    """A motionless record: white noise with Table 1's R as its variance, ``(N,)``."""
    samples = round(settings.seconds * settings.rate_hz) + 1
    draw = np.random.default_rng([seed, [GYRO, ACC].index(sensor)])
    return np.asarray(np.sqrt(sensor.table1.R) * draw.standard_normal(samples))


def benches(settings: Settings, log: Log | None, seed: int) -> list[Bench]:
    """The sensors to be tuned: both on made-up records, or those that a log maps."""
    if log is None:
        return [_made_up(sensor, settings, seed) for sensor in (GYRO, ACC)]
    mapped = [sensor for sensor in (GYRO, ACC) if sensor.channel in log.channels]
    if not mapped:
        raise ValueError("the log has neither channel: map one with --map omega=COLUMN or a=COLUMN")
    source = Source(log.name, log.sha256, log.findings.samples, log.rate_hz)
    return [
        _bench(
            sensor,
            log.units[sensor.channel] or sensor.unit,
            log.channels[sensor.channel],
            source,
            settings,
        )
        for sensor in mapped
    ]


def _made_up(sensor: Sensor, settings: Settings, seed: int) -> Bench:
    record = synthetic(sensor, settings, seed)
    name = f"white noise with Table 1's R, seed {seed}"
    source = Source.simulated(name, [record], settings.rate_hz)
    return _bench(sensor, sensor.unit, record, source, settings)


def _bench(
    sensor: Sensor, unit: str, record: np.ndarray, source: Source, settings: Settings
) -> Bench:
    Welch.matlab(len(record))  # a record too short for it cannot be split either
    rate = source.rate_hz
    split = split_noise(record, rate, settings.cutoff_hz, settings.split)
    return Bench(sensor, unit, record - record.mean(), 1 / rate, split, source, settings)
