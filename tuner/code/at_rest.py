"""Records in which nothing changes: a filter may take other decisions there than on the move."""

from collections.abc import Iterator, Sequence
from typing import Any

import jax
import numpy as np

from tuner.code.fields import Field
from tuner.code.reference_filter import SAMPLES, ReferenceFilter
from tuner.code.states import Around, Arrays

_TURNS, _KEPT = 6, (SAMPLES // 4, SAMPLES - 1)
"""How often so many samples follow one another, and the states that are kept each time."""
_MOST = 8
"""Most fields of a sample that are zero in a record of their own."""
_SMALL = 1 / 16
"""Share of a field in another one: what rests may be small, and not zero."""


def whereabouts(
    own: ReferenceFilter,
    state: Sequence[Field],
    inputs: Sequence[Field],
    met: Arrays,
    samples: Any,
) -> Around:
    """Where states and samples are drawn: near those of a record, and near those at rest.

    Args:
        own: the filter.
        state: the fields of its state.
        inputs: those of a sample.
        met: the state before each sample and after the last, a field each.
        samples: the record, time first.
    """
    states, rows = at_rest(own, samples)
    before, own_rows = [x[:-1] for x in met], [np.asarray(x) for x in jax.tree.leaves(samples)]
    if not rows:
        return Around(state, inputs, before, own_rows)
    return Around(
        state,
        inputs,
        [np.concatenate(both) for both in zip(before, states, strict=True)],
        [np.concatenate(both) for both in zip(own_rows, rows, strict=True)],
        len(rows[0]),
    )


def at_rest(own: ReferenceFilter, samples: Any) -> tuple[Arrays, Arrays]:
    """States, and the sample after each, in records of one sample again and again, a field each.

    Args:
        own: the filter.
        samples: a record, time first, whose middle sample is repeated; in further records one of
            its fields is zero, or much smaller.
    """
    leaves, tree = jax.tree.flatten(samples)
    states: list[Arrays] = []
    rows: list[Arrays] = []
    for sample in _standing([np.asarray(leaf) for leaf in leaves]):
        repeated = [np.broadcast_to(x, (SAMPLES, *x.shape)) for x in sample]
        begin: Arrays | None = None
        for _ in range(_TURNS):
            after, _ = own.run(jax.tree.unflatten(tree, repeated), begin=begin)
            begin = [x[-1] for x in after]
            if not all(np.isfinite(x).all() for x in begin):
                break
            states += [[x[k] for x in after] for k in _KEPT]
            rows += [sample for _ in _KEPT]
    kept = [all(np.isfinite(x).all() for x in one) for one in states]
    return _stacked(states, kept), _stacked(rows, kept)


def _standing(leaves: Arrays) -> Iterator[Arrays]:
    """A sample of median values, then the same with a field of zeros, or of much smaller values."""
    middle = [_even(_middle(x)) for x in leaves]
    yield middle
    real = [k for k, x in enumerate(middle) if x.dtype.kind == "f"]
    for share in (0.0, _SMALL):
        for one in real[:_MOST]:
            yield [share * np.nan_to_num(x) if k == one else x for k, x in enumerate(middle)]


def _middle(leaf: np.ndarray) -> np.ndarray:
    """The median of measured values; of whole numbers and truth values the one in the middle."""
    if leaf.dtype.kind != "f":
        return np.asarray(leaf[len(leaf) // 2])
    ranked = np.sort(leaf, axis=0)  # missing ones last
    count = np.maximum(np.isfinite(ranked).sum(axis=0), 1)
    return np.asarray(np.take_along_axis(ranked, (count // 2)[None], axis=0)[0])


def _even(sample: np.ndarray) -> np.ndarray:
    """The same with equal rows: the measurements of a block do not change either."""
    if sample.ndim < 2 or sample.dtype.kind != "f":
        return sample
    there = np.isfinite(sample)
    total, count = np.where(there, sample, 0.0).sum(axis=0), there.sum(axis=0)
    mean = np.divide(total, count, out=np.full(total.shape, np.nan), where=count > 0)
    return np.broadcast_to(mean, sample.shape)


def _stacked(rows: list[Arrays], kept: list[bool]) -> Arrays:
    chosen = [row for row, stays in zip(rows, kept, strict=True) if stays]
    return [np.stack(column) for column in zip(*chosen, strict=True)]
