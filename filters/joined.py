"""Several records in one time loop, one after another."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters.protocol import AnyFilter


class JoinedSample(NamedTuple):
    """Whether a record begins with this sample, ``()``, and the filter's own inputs."""

    begins: Array
    inputs: Any


@dataclass(frozen=True)
class Joined:
    """A filter that starts anew where a record begins.

    Many records of unequal lengths pass through it end to end, and nothing is padded. With
    :class:`filters.Lanes` around it several such lines lie side by side: see :func:`packed`.

    Attributes:
        filter: the filter.

    >>> from filters import AngleSample, Complementary, ComplementaryGain, run
    >>> records = [AngleSample(jnp.zeros(2), jnp.ones(2)), AngleSample(jnp.zeros(1), jnp.ones(1))]
    >>> gain = ComplementaryGain(jnp.array(0.1), jnp.array(0.0))
    >>> run(Joined(Complementary(dt=0.1)), gain, joined(records))[1].tolist()
    [0.5, 0.75, 0.5]
    """

    filter: AnyFilter
    same_params = True

    def init(self, params: Any) -> Any:
        """The filter's own start."""
        return self.filter.init(params)

    def step(self, params: Any, state: Any, inputs: JoinedSample) -> tuple[Any, Any]:
        """Take one sample, from the start if it is a record's first."""
        start = self.filter.init(params)
        state = jax.tree.map(lambda new, old: jnp.where(inputs.begins, new, old), start, state)
        stepped: tuple[Any, Any] = self.filter.step(params, state, inputs.inputs)
        return stepped


def joined(records: Sequence[Any]) -> JoinedSample:
    """Records end to end, as :class:`Joined` takes them.

    Args:
        records: a filter's inputs, time first, one for each record.

    Raises:
        ValueError: where there is no record, or one without samples.
    """
    begins = np.concatenate([np.arange(length) == 0 for length in _lengths(records)])
    inputs = jax.tree.map(_one_after_another, *records)
    return _given(JoinedSample(jnp.asarray(begins), inputs))


def packed(records: Sequence[Any], lanes: int) -> JoinedSample:
    """Records in lines of about equal length, as ``Lanes(Joined(filter), lanes)`` takes them.

    What is left over at the end of a line is filled with NaN, or 0 where a leaf has none. Lines of
    a sample each fill the processor's vectors: 8 are usually enough.

    Args:
        records: a filter's inputs, time first, one for each record.
        lanes: how many lines; no more than there are records.

    Returns:
        Arrays with time first and the lines second.

    Raises:
        ValueError: where there is no record, or one without samples, or too many lines.

    >>> line = packed([jnp.array([1.0]), jnp.array([2.0, 3.0]), jnp.array([4.0])], 2)
    >>> line.inputs.tolist(), line.begins.astype(int).tolist()
    ([[2.0, 1.0], [3.0, 4.0]], [[1, 1], [0, 1]])
    """
    lengths = _lengths(records)
    if not 1 <= lanes <= len(records):
        raise ValueError(f"{lanes} lines of {len(records)} records: give from 1 to {len(records)}")
    lines: list[list[Any]] = [[] for _ in range(lanes)]
    taken = [0] * lanes
    for i in sorted(range(len(records)), key=lambda i: -lengths[i]):
        shortest = taken.index(min(taken))
        lines[shortest].append(records[i])
        taken[shortest] += lengths[i]
    each = [joined(line) for line in lines]
    return _given(jax.tree.map(lambda *ends: _side_by_side(ends), *each))


def _lengths(records: Sequence[Any]) -> list[int]:
    lengths = [len(jax.tree.leaves(record)[0]) for record in records]
    if not lengths or min(lengths) < 1:
        raise ValueError("there is a record without samples, or none at all: leave it out")
    return lengths


def _one_after_another(*parts: Any) -> np.ndarray:
    # NumPy's, for XLA would compile one for every choice of lengths.
    return np.concatenate([np.asarray(part) for part in parts])


def _side_by_side(ends: Sequence[Any]) -> np.ndarray:
    longest = max(len(end) for end in ends)
    fill = np.nan if np.issubdtype(ends[0].dtype, np.floating) else 0

    def whole(end: Any) -> np.ndarray:
        missing = [(0, longest - len(end)), *[(0, 0)] * (end.ndim - 1)]
        return np.pad(np.asarray(end), missing, constant_values=fill)

    return np.stack([whole(end) for end in ends], axis=1)


def _given(sample: Any) -> JoinedSample:
    return cast("JoinedSample", jax.tree.map(jnp.asarray, sample))
