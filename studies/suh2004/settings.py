"""The settings."""

from typing import Literal

from pydantic import Field

from studies.suh2004.paper import GyroUnit
from tuner.run.settings import StudySettings


class Settings(StudySettings):
    """The mixed motion, and the effort of the search."""

    gyro_unit: GyroUnit = Field("deg/s", description="unit of the paper's gyroscope variances")
    tune_on: Literal["mixed", "experiment2"] = Field(
        "mixed", description="motion for tuning; experiment2 alone determines no parameter"
    )
    seconds: float = Field(120.0, ge=20, le=3600, description="length of each record, s")
    train: int = Field(3, ge=1, le=20, description="number of records for tuning")
    held_out: int = Field(3, ge=1, le=20, description="number of held-out records")
    burst: float = Field(4.0, ge=0, le=30, description="largest external acceleration, m/s^2")
    bias: float = Field(0.5, ge=0, le=20, description="largest gyroscope bias, deg/s")
    starts: int = Field(
        4, ge=1, description="number of starts of each search, the same for every filter"
    )
