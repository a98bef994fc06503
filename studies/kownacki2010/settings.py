"""The settings."""

from typing import Literal

from pydantic import Field, field_validator

from objectives import covariance
from tuner.names import unknown
from tuner.run.settings import StudySettings
from tuner.solvers import SOLVERS


class Settings(StudySettings):
    """Settings for ``--set``; the defaults are the paper's wherever it names a value."""

    step: float = Field(0.2, gt=0, description="height of the step, rad/s or m/s^2")
    reading: Literal["R1", "R2", "R6"] = Field(
        "R6", description="reading of the second term of (10)"
    )
    crossing: Literal["hinge", "first"] = Field(
        "hinge", description="end of the first term of (10)"
    )
    weight: float = Field(1.0, gt=0, description="factor on the second term of (10)")
    cutoff_hz: float = Field(
        1.0, gt=0, description="frequency at which Table 1's procedure splits a record, Hz"
    )
    split: Literal["ideal", "butterworth"] = Field("ideal", description="filters of that procedure")
    R: float | None = Field(
        None,
        gt=0,
        description="variance of the measurement noise, unit^2; from the record if unset",
    )
    Q: float | None = Field(None, gt=0, description="initial value of Q; from the record if unset")
    P0: tuple[tuple[float, float], tuple[float, float]] = Field(
        ((1.0, 1.0), (1.0, 1.0)), description="covariance of the initial state"
    )
    solvers: tuple[str, ...] = Field(
        ("nelder-mead", "l-bfgs-b"),
        min_length=1,
        description="names of solvers, see tuner list solvers",
    )
    starts: int = Field(4, ge=1, description="number of starts of each descent")
    rate_hz: float = Field(10_000.0, gt=0, description="sample rate of the built-in record, Hz")
    seconds: float = Field(10.0, gt=0, description="length of the built-in record, s")
    grid: int = Field(25, ge=2, le=257, description="number of points along each axis of Fig 8")

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
