"""Checks of a filter's fields, before anything is compiled."""

from dataclasses import fields
from math import inf
from typing import Any, Literal, get_args, get_origin, get_type_hints

import jax


def check_setup(filter: Any) -> None:
    """Refuse, in ``__post_init__``, an unknown word and a ``dt`` that is no positive number.

    Args:
        filter: a dataclass.

    Raises:
        ValueError: in one sentence where that is not so.

    >>> from filters import PiComplementary
    >>> PiComplementary(0.01, "airsped")
    Traceback (most recent call last):
        ...
    ValueError: PiComplementary: aid is 'airsped'; give none, airspeed or velocity
    """
    try:
        hints = get_type_hints(type(filter))
    except NameError:  # of a subclass, known to type checkers only
        hints = {}
    for field in fields(filter):
        value, hint = getattr(filter, field.name), hints.get(field.name)
        words = get_args(hint)
        if get_origin(hint) is Literal and value not in words:
            ways = f"{', '.join(words[:-1])} or {words[-1]}"
            raise ValueError(f"{type(filter).__name__}: {field.name} is {value!r}; give {ways}")
        known = not isinstance(value, jax.core.Tracer)
        if field.name == "dt" and known and not 0 < value < inf:
            raise ValueError(
                f"{type(filter).__name__}: dt is {value!r}; give a positive sample time in seconds"
            )
