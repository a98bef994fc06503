"""The settings."""

from typing import Literal, get_args

from pydantic import Field

from studies.uav.recordings import GRAVITY
from tuner.run.settings import StudySettings

Angle = Literal["phi", "theta", "psi"]
ANGLES: tuple[Angle, ...] = get_args(Angle)


class Settings(StudySettings):
    """The folder of the flights, the one that is tuned on, and the construction of attitudes."""

    folder: str = Field("", description="folder of the flights: zips, or folders of text files")
    tuned: str = Field("quad106", description="name of the flight that is tuned on")
    judged: tuple[str, ...] = Field(
        ("quad122a", "InputFilesPX4_search", "f450_glitch_log"),
        description="names of the flights that are judged on",
    )
    left_out: Literal["if possible", "always", "never"] = Field(
        "if possible",
        description="whether each flight is also judged by numbers that are tuned on all others "
        "without a glitch; always: refused where there are none",
    )
    angles: tuple[Angle, ...] = Field(
        ANGLES, min_length=1, description="constructed angles that are taken as measurements"
    )
    slowest: float = Field(
        3.0, gt=0, description="ground speed up to which no attitude is constructed, m/s"
    )
    ticks_per_second: int = Field(20, ge=5, le=400, description="ticks of the filter in a second")
    gravity: float = Field(GRAVITY, gt=9.7, lt=9.9, description="where it flies, m/s^2")
    velocity_delay: float = Field(
        0.23, ge=0, le=5, description="of the GPS's speed, s, for flights without a timing.txt"
    )
    position_delay: float = Field(0.21, ge=0, le=5, description="of its position, s, likewise")
    acc_unit: str = Field("m/s^2", description="unit of the accelerometers")
    gyr_unit: str = Field("rad/s", description="unit of the gyroscopes")
    seconds: float | None = Field(
        None, ge=30, description="only so much of each flight from its first attitude, s"
    )
