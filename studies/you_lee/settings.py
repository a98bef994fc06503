"""The settings: the flight, the sensors of table 1, the filter, and the effort."""

from typing import Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from studies.you_lee.flight import Course, Trajectory
from studies.you_lee.paper import GRAVITY, PUBLISHED
from tuner.run.settings import StudySettings

HELD_OUT = 1000
"""Offset of the Monte Carlo runs' seeds from those that are tuned on."""

Start = Literal["zero", "true"]


class Settings(StudySettings):
    """The flight, the sensors (table 1), the published filter, and the effort of the tuning."""

    trajectory: Trajectory = Field("T1", description="flight for tuning")
    start: Start = Field(
        "zero", description="initial v and w of the velocity filter: zero or the true ones"
    )
    K1: float = Field(PUBLISHED["K1"], ge=1e-9, description="proportional gain of the claims, 1/s")
    K2: float = Field(PUBLISHED["K2"], ge=1e-9, description="integral gain of the claims, 1/s")
    Q_k: float = Field(
        PUBLISHED["Q_k"], ge=0, description="process variance of the velocity filter, (ft/s)^2"
    )
    R_k: float = Field(
        PUBLISHED["R_k"], gt=0, description="airspeed variance of the velocity filter, (ft/s)^2"
    )
    P0: float = Field(0.0, ge=0, description="initial variance of the velocity filter, (ft/s)^2")
    threshold: float = Field(
        PUBLISHED["threshold"], gt=0, description="rate above which the velocity filter runs, rad/s"
    )
    speed: float = Field(500.0, gt=0, description="airspeed, ft/s")
    bank: float = Field(
        28.5659947,
        gt=0,
        lt=90,
        description="largest bank angle, deg; the published one turns by 90 deg",
    )
    tilt: float = Field(3.0, ge=0, lt=90, description="angle of attack (T1) or sideslip (T2), deg")
    level: float = Field(250.0, ge=1, le=3600, description="duration of the level flight, s")
    turn: float = Field(50.0, ge=1, le=3600, description="duration of the bank turn, s")
    ramp: float = Field(5.0, gt=0, description="duration of rolling in and of rolling out, s")
    rate_hz: float = Field(100.0, ge=0.01, le=1000, description="sample rate of all sensors, Hz")
    gyro_bias: float = Field(
        50.0, ge=0, description="standard deviation of the initial gyroscope bias, deg/h"
    )
    gyro_walk: float = Field(
        10.0, ge=0, description="random walk of the gyroscope bias in one hour, deg/h"
    )
    acc_bias: float = Field(
        140.0, ge=0, description="standard deviation of the initial accelerometer bias, ug"
    )
    acc_walk: float = Field(
        35.0, ge=0, description="random walk of the accelerometer bias in one hour, ug"
    )
    airspeed_noise: float = Field(1.0, ge=0, description="standard deviation of the airspeed, ft/s")
    runs: int = Field(100, ge=1, le=1000, description="number of Monte Carlo runs for judging")
    train: int = Field(20, ge=1, le=HELD_OUT, description="number of other runs for tuning")
    starts: int = Field(
        4, ge=1, description="number of starts of each search, the same for every problem"
    )
    grid: int = Field(
        13,
        ge=2,
        le=101,
        description="number of points of the sweeps and along each axis of the surface",
    )
    zeta_low: float | None = Field(None, gt=0, description="lower limit of the damping; (15) has 1")
    zeta_high: float | None = Field(None, gt=0, description="upper limit of the damping")

    @field_validator("start", mode="before")
    @classmethod
    def _word(cls, value: object) -> object:
        """A bare `true` on the command line is read as TOML's."""
        return "true" if value is True else value

    @model_validator(mode="after")
    def _fits(self) -> "Settings":
        if (
            4 - 2 * self.K1 * self.dt + self.K1 * self.K2 * self.dt**2 <= 0
            or self.K2 * self.dt >= 1
        ):
            raise ValueError(
                f"sums of {self.dt:g} s grow without end with K1 = {self.K1:g} and K2 = "
                f"{self.K2:g} 1/s; give smaller gains or a higher rate_hz"
            )
        if 2 * self.ramp > self.turn:
            raise ValueError(
                f"banking and coming back take {2 * self.ramp:g} s of a turn of {self.turn:g} s; "
                "give a shorter ramp"
            )
        if min(self.level, self.ramp) * self.rate_hz < 1:
            raise ValueError(
                f"at rate_hz = {self.rate_hz:g} there is no sample in a phase of the flight; give "
                "a higher rate"
            )
        low, high = self.zeta_low, self.zeta_high
        if low is not None and high is not None and low >= high:
            raise ValueError("zeta_low must be below zeta_high; the problem 'damped' has zeta = 1")
        return self

    @property
    def dt(self) -> float:
        """Sample time, s."""
        return 1 / self.rate_hz

    @property
    def course(self) -> Course:
        """The trajectory to be flown, angles in rad."""
        bank, tilt = float(np.radians(self.bank)), float(np.radians(self.tilt))
        return Course(self.speed, bank, tilt, self.level, self.turn, self.ramp, GRAVITY)

    @property
    def samples(self) -> int:
        """Number of samples in a run."""
        return round((self.level + self.turn) * self.rate_hz)
