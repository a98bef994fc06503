"""The settings."""

from typing import Literal, get_args

from pydantic import Field

from studies.uav.recordings import GRAVITY
from tuner.run.settings import StudySettings

Angle = Literal["phi", "theta", "psi"]
ANGLES: tuple[Angle, ...] = get_args(Angle)


class Settings(StudySettings):
    """The folder of the flights, the one that is tuned on, and the construction of attitudes."""

    folder: str = Field(
        "", description="folder of the flights: zip files, or folders of text files"
    )
    tuned: str = Field("quad106", description="name of the flight for tuning")
    judged: tuple[str, ...] = Field(
        ("quad122a", "InputFilesPX4_search", "f450_glitch_log"),
        description="names of the flights for judging",
    )
    left_out: Literal["if possible", "always", "never"] = Field(
        "if possible",
        description="judging of each flight with numbers tuned on all others without a glitch",
    )
    angles: tuple[Angle, ...] = Field(
        ANGLES, min_length=1, description="constructed angles used as measurements"
    )
    slowest: float = Field(
        3.0, gt=0, description="ground speed below which no attitude is constructed, m/s"
    )
    ticks_per_second: int = Field(
        20, ge=5, le=400, description="sample rate of the filter, ticks per second"
    )
    gravity: float = Field(
        GRAVITY, gt=9.7, lt=9.9, description="gravity at the place of the flights, m/s^2"
    )
    velocity_delay: float = Field(
        0.23,
        ge=0,
        le=5,
        description="delay of the GPS's speed, s, for flights without a timing.txt",
    )
    position_delay: float = Field(
        0.21,
        ge=0,
        le=5,
        description="delay of the GPS's position, s, for flights without a timing.txt",
    )
    acc_unit: str = Field("m/s^2", description="unit of the accelerometers")
    gyr_unit: str = Field("rad/s", description="unit of the gyroscopes")
    seconds: float | None = Field(
        None,
        ge=30,
        description="length used of each flight from its first attitude, s; all if unset",
    )
