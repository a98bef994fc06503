"""Numbers as C writes them."""

import json

import numpy as np
from numpy.typing import NDArray

_FLOAT = np.finfo(np.float32)


def double(value: NDArray[np.float64]) -> str:
    r"""The text of a number, or a brace initialiser, with the fewest digits that are exact.

    >>> double(np.array([0.1, -2.0]))
    '{ 0.1, -2.0 }'
    """
    return _initialiser(value, "")


def single(value: NDArray[np.float64]) -> str | None:
    """The same for the float nearest to each number; None if one is not a normal float.

    >>> single(np.array(1 / 3))
    '0.33333334f'
    >>> single(np.array(1e-40)) is None
    True
    """
    with np.errstate(over="ignore", under="ignore"):
        narrow = value.astype(np.float32)
    size = np.abs(narrow)
    normal = (size >= _FLOAT.tiny) & (size <= _FLOAT.max)
    return _initialiser(narrow, "f") if np.all(normal | (value == 0)) else None


def value_of(text: str) -> NDArray[np.float64]:
    """The array of what :func:`double` wrote: with its brackets changed, it is JSON.

    >>> value_of("{ 0.1, -2.0 }")
    array([ 0.1, -2. ])
    >>> value_of("(-2.0)")
    array(-2.)
    """
    return np.array(json.loads(text.translate(str.maketrans("{}", "[]", "()"))))


def _initialiser(value: NDArray[np.floating], suffix: str) -> str:
    # str: format() would make a float32 a float64 first, with more digits than it has.
    if value.ndim == 0:
        number = f"{value[()]!s}{suffix}"
        # Coding rules for C require brackets around a macro that is an expression.
        return f"({number})" if np.signbit(value) else number
    if value.ndim == 1:
        return "{ " + ", ".join(f"{number!s}{suffix}" for number in value) + " }"
    rows = ", \\\n".join(f"    {_initialiser(row, suffix)}" for row in value)
    return f"{{ \\\n{rows} \\\n}}"
