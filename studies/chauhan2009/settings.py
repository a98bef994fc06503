"""Values that the paper leaves open, and the effort of the search."""

from typing import Annotated, Literal

from pydantic import Field, field_validator

from tuner.run.settings import StudySettings


class Settings(StudySettings):
    """Values that the paper leaves open, and the effort of the search."""

    seconds: float = Field(300.0, ge=180, le=3600, description="length of a record, s")
    measured: Literal["angles", "gps"] = Field(
        "angles", description="angles with noise, or those constructed from GPS and accelerometers"
    )
    noise: float = Field(1.0, gt=0, le=20, description="of the measured angles, deg")
    speed: float = Field(20.0, gt=0, le=300, description="gps: along the forward axis, m/s")
    gps_noise: float = Field(0.1, ge=0, le=100, description="gps: of a position, m")
    acc_noise: float = Field(0.1, ge=0, le=100, description="gps: of a tick's force, m/s^2")
    gyro_noise: float = Field(0.1, ge=0, le=20, description="of the gyroscopes in a tick, deg/s")
    bias: tuple[float, float, float] = Field(
        (0.5, -0.3, 0.2), description="of the gyroscopes, deg/s"
    )
    records: int = Field(6, ge=2, le=50, description="seeds of every step that is looked at")
    train: int = Field(2, ge=1, le=20, description="seeds of every step that is tuned on")
    held_out: int = Field(6, ge=1, le=50, description="seeds of every step that only judges")
    tuned_on: tuple[Annotated[float, Field(gt=0, le=80)], ...] = Field(
        (14.1, 35.1), min_length=1, description="pitch angles that are tuned on, deg"
    )
    windows: tuple[Annotated[int, Field(ge=2, le=20)], ...] = Field(
        (2, 4, 6, 8), min_length=1, description="lengths of the fuzzy window that are tried, even"
    )
    factors: tuple[Annotated[float, Field(gt=0)], ...] = Field(
        (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0),
        min_length=2,
        description="lambda of the random noise's sweep",
    )
    starts: int = Field(1, ge=1, description="starts of each search, the same for every filter")

    @field_validator("windows")
    @classmethod
    def _even(cls, windows: tuple[int, ...]) -> tuple[int, ...]:
        odd = [window for window in windows if window % 2]
        if odd:
            raise ValueError(
                f"a line through {odd[0]} residuals need not be unique; take an even number"
            )
        return windows
