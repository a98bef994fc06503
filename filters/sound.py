"""Whether a filter is set up soundly, before anything is compiled."""

from dataclasses import fields
from math import inf
from typing import Any, Literal, get_args, get_origin, get_type_hints


def check_setup(filter: Any) -> None:
    """For ``__post_init__``: words are among those known, and ``dt`` is a positive number.

    Args:
        filter: a dataclass.

    Raises:
        ValueError: in one sentence where that is not so.

    >>> from filters import MixingFilter
    >>> MixingFilter(0.01, "airsped")
    Traceback (most recent call last):
        ...
    ValueError: MixingFilter: aid is 'airsped'; give none, airspeed or velocity
    """
    hints = get_type_hints(type(filter))
    for field in fields(filter):
        value, words = getattr(filter, field.name), get_args(hints[field.name])
        if get_origin(hints[field.name]) is Literal and value not in words:
            known = f"{', '.join(words[:-1])} or {words[-1]}"
            raise ValueError(f"{type(filter).__name__}: {field.name} is {value!r}; give {known}")
        if field.name == "dt" and not 0 < value < inf:
            raise ValueError(
                f"{type(filter).__name__}: dt is {value!r}; give a positive sample time in seconds"
            )
