"""The settings."""

from typing import Literal

from pydantic import Field

from filters import GRAVITY_GRADIENT
from studies.ha1981.paper import TS
from tuner.run.settings import StudySettings


class Settings(StudySettings):
    """Settings for ``--set``; those left out take the paper's values."""

    unit: Literal["ft", "m"] = Field("ft", description="of length; settings are in it")
    bound: float | None = Field(
        None, gt=0, description="of the bias's variance, (ft/s^2)^2; the paper gives none: 4e-4"
    )
    q_a: float | None = Field(None, gt=0, description="density of W_a, (ft/s^2)^2 s; 0.04")
    q_b: float | None = Field(None, gt=0, description="variance of V, ft^2; 3.24")
    sigma2_ab: float | None = Field(None, gt=0, description="of the bias at t = 0; 4 (ft/s^2)^2")
    sigma2_hr: float | None = Field(None, ge=0, description="of the given altitude; 100 ft^2")
    k_gh: float = Field(GRAVITY_GRADIENT, ge=0, description="gravity's gradient, 1/s^2")
    Ts: float = Field(TS, gt=0, description="sampling period of the exported scheme, s")
    periods: tuple[float, ...] = Field(
        (0.0, 0.5, 1.0, 2.0, 5.0), min_length=1, description="of Figs 5 to 8, s; 0: continuous"
    )
    seconds: float = Field(200.0, ge=120, description="length of the histories")
    segments: int = Field(4, ge=1, le=8, description="stored gains, besides the first sample's")
    starts: int = Field(20, ge=1, description="starts of the conventional design")
