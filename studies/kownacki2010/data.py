"""Motionless records, simulated or measured, for the step test."""

from dataclasses import dataclass, replace

import numpy as np

from filters import AccelerometerFilter, GyroscopeFilter
from objectives import Welch
from studies.kownacki2010.paper import ACC, GYRO, Sensor
from studies.kownacki2010.settings import Settings
from tuner.data.merge import Timeline, timeline
from tuner.data.noise_split import NoiseSplit, split_noise
from tuner.data.record import Record
from tuner.data.source import Source
from tuner.data.stillness import check_at_rest
from tuner.limits import check_amount
from tuner.names import counted


@dataclass(frozen=True, eq=False)
class Bench:
    """A sensor with a record for the step test.

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
        """Step and record as two columns, ``(N, 2)``: one pass filters both."""
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
        """The start of the search for Q."""
        return self.noise.Q if self.settings.Q is None else self.settings.Q

    def steady(self, q_over_r: float) -> tuple[float, ...]:
        """K1, K2 and bandwidth in Hz in the steady state."""
        gains, bandwidth = self.sensor.steady(q_over_r, self.dt)
        return tuple(float(np.asarray(part)) for part in (*gains, bandwidth))


def synthetic(sensor: Sensor, settings: Settings, seed: int) -> np.ndarray:
    """A motionless record: white noise with Table 1's R as its variance, ``(N,)``."""
    many = settings.seconds * settings.rate_hz
    check_amount(f"{many:.4g} samples", 64.0 * many, "take fewer seconds")
    samples = round(many) + 1
    draw = np.random.default_rng([seed, [GYRO, ACC].index(sensor)])
    return np.asarray(np.sqrt(sensor.table1.R) * draw.standard_normal(samples))


def benches(settings: Settings, records: tuple[Record, ...], seed: int) -> list[Bench]:
    """The sensors to be tuned: both on simulated records, or those of a recording.

    Raises:
        ValueError: for several recordings, and one without an even clock or with missing samples.
    """
    if not records:
        return [_made_up(sensor, settings, seed) for sensor in (GYRO, ACC)]
    if len(records) > 1:
        raise ValueError(f"this study takes one recording, and there are {len(records)}")
    line, source = timeline(records[0]), records[0].sources[0]
    if line.rate_hz is None:
        raise ValueError(
            f"{source.name} has gaps or an uneven clock, and the step response needs even samples; "
            "cut out a piece without gaps"
        )
    source = replace(source, samples=len(line.times), rate_hz=line.rate_hz)
    tested = []
    for sensor in (GYRO, ACC):
        if sensor.channel in line.channels:
            values, unit = _whole(source, sensor, line), line.units[sensor.channel]
            name = f"{source.name} ({sensor.channel})"
            check_at_rest(name, values, source.rate_hz, float(line.times[0]))
            tested.append(_bench(sensor, unit, values, source, settings))
    return tested


def _whole(source: Source, sensor: Sensor, line: Timeline) -> np.ndarray:
    """A channel without missing samples, which no spectrum takes, and that changes."""
    values = np.asarray(line.channels[sensor.channel])
    missing = int(np.isnan(values).sum())
    if missing:
        raise ValueError(
            f"{sensor.channel} of {source.name} misses {counted(missing, 'sample')}, and a "
            "spectrum needs all; cut them out or interpolate first"
        )
    if np.ptp(values) == 0:
        raise ValueError(
            f"{sensor.channel} of {source.name} is constant, {values[0]:g} in every sample; map a "
            "column that changes"
        )
    return values


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
