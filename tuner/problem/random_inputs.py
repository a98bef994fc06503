"""Samples that no sensor made, to try a filter on."""

from typing import Any

import numpy as np

from filters.declared import channel_facts, inputs_of, optional

COUNT = 100


def random_inputs(filter: Any, channels: frozenset[str] | None = None) -> Any:
    """Inputs of a filter, time first: random numbers of size one.

    Args:
        filter: the filter, which declares its inputs.
        channels: those to make; None for the required ones.
    """
    draw = np.random.default_rng(0)
    facts = channel_facts(filter, "inputs")
    wanted = facts.keys() - optional(filter) if channels is None else channels
    found = {
        name: draw.standard_normal((COUNT, *((len(fact.axes),) if fact.axes else ())))
        for name, fact in facts.items()
        if name in wanted
    }
    return inputs_of(filter, found)
