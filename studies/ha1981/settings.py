"""The settings."""

from typing import Literal

from pydantic import Field

from filters import GRAVITY_GRADIENT
from studies.ha1981.paper import TS
from tuner.run.settings import StudySettings


class Settings(StudySettings):
    """Settings for ``--set``; those left out take the paper's values."""

    unit: Literal["ft", "m"] = Field("ft", description="unit of length, also of the settings below")
    bound: float | None = Field(
        None,
        gt=0,
        description="bound of the bias's variance, (ft/s^2)^2; 4e-4 if unset",
    )
    q_a: float | None = Field(
        None, gt=0, description="spectral density of W_a, (ft/s^2)^2 s; 0.04 if unset"
    )
    q_b: float | None = Field(None, gt=0, description="variance of V, ft^2; 3.24 if unset")
    sigma2_ab: float | None = Field(
        None, gt=0, description="variance of the bias at t = 0, (ft/s^2)^2; 4 if unset"
    )
    sigma2_hr: float | None = Field(
        None, ge=0, description="variance of the given altitude, ft^2; 100 if unset"
    )
    k_gh: float = Field(GRAVITY_GRADIENT, ge=0, description="gradient of gravity, 1/s^2")
    Ts: float = Field(TS, gt=0, description="sampling period of the exported scheme, s")
    periods: tuple[float, ...] = Field(
        (0.0, 0.5, 1.0, 2.0, 5.0),
        min_length=1,
        description="sampling periods of Figs 5 to 8, s; 0 is the continuous filter",
    )
    seconds: float = Field(200.0, ge=120, description="length of the histories, s")
    segments: int = Field(
        4, ge=1, le=8, description="number of stored gains besides that of the first sample"
    )
    starts: int = Field(20, ge=1, description="number of starts of the conventional design")
