"""User models in text files: from TOML to a filter class, with nothing executed.

A document names its parameters, inputs, states and measurements, and says by matrices or
expressions how the states move and what is measured; ``docs/models.md`` shows how.
"""

from collections.abc import Mapping
from typing import Any

from tuner.model.document import read_model
from tuner.model.template import template


def model_filter(document: Mapping[str, Any]) -> type[Any]:
    """The filter class of a model document, which declares its facts as every filter does.

    Equal documents have the same class, so they share one compilation.

    Args:
        document: as :func:`read_model` or ``tomllib`` reads it.

    Raises:
        ValueError: with all mistakes in it.

    >>> document = {
    ...     "parameters": {"q": {}, "R": {}},
    ...     "states": ["level"],
    ...     "measurements": ["z"],
    ...     "model": {"A": 0, "Q": "q", "C": 1, "R": "R"},
    ... }
    >>> model_filter(document) is model_filter(dict(document))
    True
    >>> from filters import run
    >>> import jax.numpy as jnp
    >>> level = model_filter(document)
    >>> noise = level.params(q=jnp.array(0.5), R=jnp.array(1.0))
    >>> run(level(dt=1.0), noise, level.inputs(jnp.array([8.0, jnp.nan, 9.0])))[1].level
    Array([8.        , 8.        , 8.66666667], dtype=float64)
    """
    from tuner.model.classes import class_of
    from tuner.model.lines import Lines
    from tuner.model.reading import described

    return class_of(described(document, Lines(), "the model"))


__all__ = ["model_filter", "read_model", "template"]
