"""Values that the paper leaves open, and the effort of the search."""

from typing import Annotated, Literal

from pydantic import Field, field_validator

from tuner.run.settings import StudySettings


class Settings(StudySettings):
    """Values that the paper leaves open, and the effort of the search."""

    seconds: float = Field(300.0, ge=180, le=3600, description="length of a record, s")
    measured: Literal["angles", "gps"] = Field(
        "angles",
        description="true angles with noise, or angles constructed from GPS and accelerometers",
    )
    noise: float = Field(
        1.0, gt=0, le=20, description="standard deviation of the measured angles, deg"
    )
    speed: float = Field(
        20.0, gt=0, le=300, description="with measured=gps: speed along the forward axis, m/s"
    )
    gps_noise: float = Field(
        0.1, ge=0, le=100, description="with measured=gps: standard deviation of a position, m"
    )
    acc_noise: float = Field(
        0.1,
        ge=0,
        le=100,
        description="with measured=gps: standard deviation of a tick's specific force, m/s^2",
    )
    gyro_noise: float = Field(
        0.1, ge=0, le=20, description="standard deviation of the gyroscopes per tick, deg/s"
    )
    bias: tuple[float, float, float] = Field(
        (0.5, -0.3, 0.2), description="biases of the gyroscopes, deg/s"
    )
    records: int = Field(6, ge=2, le=50, description="number of seeds of every step for the claims")
    train: int = Field(2, ge=1, le=20, description="number of seeds of every step for tuning")
    held_out: int = Field(6, ge=1, le=50, description="number of seeds of every held-out step")
    tuned_on: tuple[Annotated[float, Field(gt=0, le=80)], ...] = Field(
        (14.1, 35.1), min_length=1, description="pitch angles of the steps for tuning, deg"
    )
    windows: tuple[Annotated[int, Field(ge=2, le=20)], ...] = Field(
        (2, 4, 6, 8),
        min_length=1,
        description="candidate lengths of the fuzzy window, even numbers of samples",
    )
    factors: tuple[Annotated[float, Field(gt=0)], ...] = Field(
        (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0),
        min_length=2,
        description="values of lambda in the sweep of the random noise",
    )
    starts: int = Field(
        1, ge=1, description="number of starts of each search, the same for every filter"
    )

    @field_validator("windows")
    @classmethod
    def _even(cls, windows: tuple[int, ...]) -> tuple[int, ...]:
        odd = [window for window in windows if window % 2]
        if odd:
            raise ValueError(
                f"a line through {odd[0]} residuals need not be unique; take an even number"
            )
        return windows
