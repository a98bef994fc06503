"""The settings."""

from pydantic import Field

from studies.broad.contestants import Contestant
from studies.broad.trials import AccUnit, GyrUnit
from tuner.run.settings import StudySettings


class Settings(StudySettings):
    """The folder of the recordings, and the filters tuned on them."""

    folder: str = Field("", description="folder of the benchmark's .mat files")
    acc_unit: AccUnit = Field("m/s^2", description="unit of the accelerometers, imu_acc")
    gyr_unit: GyrUnit = Field("rad/s", description="unit of the gyroscopes, imu_gyr")
    contestants: tuple[Contestant, ...] | None = Field(
        None,
        description="filters tuned besides the room filter; if unset all that the trials allow",
    )
    folds: int | None = Field(
        None, ge=0, description="number of trials left out in turn, from the first; all if unset"
    )
    seconds: float | None = Field(
        None, gt=0, description="length used of each trial, s; the whole trial if unset"
    )
