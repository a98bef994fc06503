"""The settings that all studies share."""

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ConfigDict, ValidationInfo, field_validator


class StudySettings(BaseModel):
    """Settings that do not change, with known names and finite numbers only.

    >>> class Settings(StudySettings):
    ...     runs: int = 100
    >>> Settings(runs=3).runs
    3
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _no_truth_value(cls, value: object, info: ValidationInfo) -> object:
        """Pydantic would take true for 1."""
        field = cls.model_fields[info.field_name or ""]
        if _truth(value) and field.annotation is not bool:
            raise ValueError("a truth value does not fit")
        return value


def _truth(value: object) -> bool:
    """Whether it is a truth value, or holds one."""
    if isinstance(value, list | tuple):
        return any(_truth(part) for part in value)
    return isinstance(value, bool)


def reason_of(error: Mapping[str, Any]) -> str:
    """The fault of a value, as the other messages say it."""
    reason = str(error["msg"]).removeprefix("Value error, ")
    for words, ours in _WORDS.items():
        reason = reason.replace(words, ours)
    return reason


_WORDS = {
    "Input should be": "must be",
    "greater than or equal to": "at least",
    "less than or equal to": "at most",
    "a valid tuple": "a list",
    "greater than": "above",
    "less than": "below",
}
