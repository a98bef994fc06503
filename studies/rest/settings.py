"""The settings."""

from typing import get_args

from pydantic import Field, model_validator

from studies.rest.requirement import Kind
from tuner.run.settings import StudySettings

REQUIREMENTS: tuple[Kind, ...] = get_args(Kind)


class Settings(StudySettings):
    """The rate for R and Q, and the requirement on a filter, if any."""

    rate_hz: float | None = Field(
        None, gt=0, description="sample rate of the target machine, Hz; the record's own if unset"
    )
    settles_s: float | None = Field(None, gt=0, description="settling time to 2 % after a step, s")
    bandwidth_hz: float | None = Field(None, gt=0, description="bandwidth at -3 dB, Hz")
    latency_s: float | None = Field(None, gt=0, description="lag behind a steady change, s")
    starts: int = Field(2, ge=1, description="number of starts of the search for N and K")

    @model_validator(mode="after")
    def _one_requirement(self) -> "Settings":
        given = self.requirement
        if len(given) > 1:
            raise ValueError(
                f"{' and '.join(given)} are given, and one of them decides the filter; give one"
            )
        return self

    @property
    def requirement(self) -> dict[Kind, float]:
        """The requirement on the filter, by name; empty, or one entry."""
        given = {name: getattr(self, name) for name in REQUIREMENTS}
        return {name: value for name, value in given.items() if value is not None}
