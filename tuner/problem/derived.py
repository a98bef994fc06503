"""Numbers of interest that follow from parameters."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from filters.declared import bare
from objectives.in_numpy import Method, in_numpy


def derived_numbers(
    derive: Callable[..., Any] | None,
    filter: Any,
    values: Mapping[str, np.ndarray],
    build: Callable[..., Any],
) -> dict[str, float]:
    """The numbers that a function derives of values by name, or else the filter, by name.

    Args:
        derive: of the values; None: the filter's own, where it has one.
        filter: the filter.
        values: of the parameters, by name.
        build: makes the filter's parameters of them.
    """
    if derive is not None:
        return {name: float(value) for name, value in in_numpy(derive, values).items()}
    own = bare(filter)
    if not hasattr(own, "derive"):
        return {}
    found = in_numpy(Method(own, "derive"), in_numpy(build, values))
    return {name: float(n) for name, n in found.items() if np.ndim(n) == 0}
