"""Settings of a study from --set, in one sentence where they are wrong."""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from tuner.names import listed, unknown
from tuner.run.settings import reason_of
from tuner.toml import parsed

Some = TypeVar("Some", bound=BaseModel)


def parse_settings(model: type[Some], pairs: Sequence[str], base: dict[str, Any]) -> Some:
    """The settings that KEY=VALUE pairs make of a base.

    Values are read as TOML (numbers, true, [lists]), or as text where they are none.

    Raises:
        ValueError: for an unknown key, with the near ones, or a value that does not fit.
    """
    values = {**base, **settings_of(pairs)}
    if faults := listed(settings_faults(model, values)):
        raise ValueError(faults)
    return model.model_validate(values)


def settings_of(pairs: Sequence[str]) -> dict[str, Any]:
    """The settings that KEY=VALUE pairs say.

    Raises:
        ValueError: for a pair without "=".
    """
    values = {}
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals:
            raise ValueError(f"--set {pair} has no '='; write --set KEY=VALUE")
        values[key.strip()] = value_of(text.strip())
    return values


def settings_faults(model: type[BaseModel], values: Mapping[str, Any]) -> Iterator[str]:
    """The mistakes in settings: unknown ones with the near ones, values that do not fit."""
    names = model.model_fields
    yield from (str(unknown("setting", key, names)) for key in values if key not in names)
    try:
        model.model_validate({key: value for key, value in values.items() if key in names})
    except ValidationError as error:
        yield from map(_fault, error.errors())


def _fault(error: Mapping[str, Any]) -> str:
    where = ".".join(str(part) for part in error["loc"])
    if error["type"] == "missing":
        return f"setting {where} is missing; give it with --set {where}=... or in a study.toml"
    reason = reason_of(error)
    if not where:  # two settings that do not go together
        return reason
    return f"setting {where}: {reason}, got {error['input']!r}"


def value_of(text: str) -> Any:
    """A value as TOML has it, or the text where it is none.

    Raises:
        ValueError: for lists in lists without end, and numbers of thousands of digits.
    """
    try:
        return parsed(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
    except ValueError as error:
        raise ValueError(f"{text[:40]}... is no value: {error}") from None
