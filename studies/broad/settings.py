"""The settings."""

from pydantic import Field

from studies.broad.contestants import Contestant
from studies.broad.trials import AccUnit, GyrUnit
from tuner.run.settings import StudySettings


class Settings(StudySettings):
    """The folder of the recordings, and the filters tuned on them."""

    folder: str = Field("", description="folder of the benchmark's .mat files")
    acc_unit: AccUnit = Field("m/s^2", description="unit of imu_acc")
    gyr_unit: GyrUnit = Field("rad/s", description="unit of imu_gyr")
    contestants: tuple[Contestant, ...] | None = Field(
        None,
        description="filters that are tuned on all trials; the room filter always is; unset: all "
        "that the trials allow",
    )
    folds: int | None = Field(
        None, ge=0, description="trials to leave out in turn, the first so many; all if unset"
    )
    seconds: float | None = Field(None, gt=0, description="only so much of each trial, s")
