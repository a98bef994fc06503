"""Checks of the fields of a tuned filter; each refusal is one sentence."""

import re
import reprlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

_NAME = re.compile(r"[A-Za-z](_?[A-Za-z0-9])*")


def require(holds: bool, sentence: str) -> None:
    """Refuse with the sentence where the condition is false."""
    if not holds:
        raise ValueError(sentence)


def require_name(what: str, name: object, longest: int) -> None:
    """Require letters, digits and single underscores: the name becomes part of a name in C."""
    require(
        isinstance(name, str) and _NAME.fullmatch(name) is not None and len(name) <= longest,
        f"{what} is named {reprlib.repr(name)}; give at most {longest} letters, digits and "
        "single underscores, a letter first",
    )


def require_text(what: str, text: object) -> None:
    """Require whole characters: half a surrogate pair cannot be written to a file."""
    require(isinstance(text, str), f"{what} is {reprlib.repr(text)}; give text")
    try:
        str(text).encode()
    except UnicodeEncodeError as error:
        raise ValueError(f"{what} holds half a character; give whole Unicode text") from error


def require_once(what: str, names: Sequence[str]) -> None:
    """Require that no name comes twice."""
    for i, name in enumerate(names):
        require(name not in names[:i], f"the {what} {reprlib.repr(name)} comes twice; rename one")


def frozen_array(name: str, value: object) -> NDArray[np.float64]:
    """A read-only copy in row-major order."""
    try:
        array = np.array(value, order="C")
    except ValueError as error:
        raise ValueError(f"{name!r} has rows of different lengths; give a full array") from error
    require(array.dtype == np.float64, f"{name!r} is {array.dtype}; give a float64 array")
    require(array.ndim <= 2, f"{name!r} has {array.ndim} axes; give a number, vector or matrix")
    require(array.size > 0, f"{name!r} is empty; give at least one number")
    require(bool(np.isfinite(array).all()), f"{name!r} holds NaN or infinity; give finite numbers")
    array.flags.writeable = False
    return array
