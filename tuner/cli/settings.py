"""Settings of a study from --set, in one sentence where they are wrong."""

import tomllib
from collections.abc import Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from tuner.names import unknown

Some = TypeVar("Some", bound=BaseModel)


def parse_settings(model: type[Some], pairs: Sequence[str], base: dict[str, Any]) -> Some:
    """The settings that KEY=VALUE pairs make of a base.

    Values are read as TOML (numbers, true, [lists]), or as text where they are none.

    Raises:
        ValueError: for an unknown key, with the near ones, or a value that does not fit.
    """
    values = dict(base)
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals:
            raise ValueError(f"--set {pair} has no '='; write --set KEY=VALUE")
        values[key.strip()] = value_of(text.strip())
    for key in values:
        if key not in model.model_fields:
            raise unknown("setting", key, model.model_fields)
    try:
        return model.model_validate(values)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        if first["type"] == "missing":
            raise ValueError(
                f"setting {where} is missing; give it with --set {where}=... or in a study.toml"
            ) from None
        reason = first["msg"].removeprefix("Value error, ")
        if not where:  # two settings that do not go together
            raise ValueError(reason) from None
        raise ValueError(f"setting {where}: {reason}, got {first['input']!r}") from None


def value_of(text: str) -> Any:
    """A value as TOML has it, or the text where it is none."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
