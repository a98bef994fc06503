"""Which numbers of a filter's inputs are measurements: found by taking each of them away."""

from collections import namedtuple
from dataclasses import dataclass, field
from functools import cache, partial
from typing import Any, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters.declared import bare
from filters.protocol import AnyFilter, run

MeasuredEntries: TypeAlias = tuple[tuple[tuple[int, int], ...], ...]
"""For every innovation, the numbers of a sample without which there is none: which leaf of the
inputs, and which of its entries."""


def measured_entries(filter: AnyFilter, params: Any, inputs: Any) -> MeasuredEntries:
    """The numbers that a filter's innovations are made of.

    Every number of a sample is made missing (NaN), one at a time; it belongs to the innovations
    whose variance is 0 then. Known inputs, which drive the prediction, belong to none.

    Args:
        filter: outputs ``innovation`` and ``variance``, ``(m,)``.
        params: its parameters; any at which it runs.
        inputs: a record of one sensor set, time first.

    Returns:
        One entry for each of the m innovations; empty where no missing number takes it away, or
        where it never counts in this record.

    Raises:
        ValueError: for a filter without innovations or their variances.

    >>> from filters import Vertical, VerticalNoise, VerticalSample
    >>> record = VerticalSample(acc=jnp.zeros(9), baro=jnp.ones(9))
    >>> noise = VerticalNoise(*map(jnp.array, (0.01, 1e-4, 0.1)))
    >>> measured_entries(Vertical(dt=0.1), noise, record)  # of leaf 1, the height, its only entry
    (((1, 0),),)
    """
    counts = np.asarray(_variances(filter, params, inputs)) > 0
    found: list[list[tuple[int, int]]] = [[] for _ in range(counts.shape[1])]
    left = counts.any(axis=0)
    while left.any():
        # The last of those in which most innovations count: the filter has begun by then.
        worth = counts[:, left].sum(axis=1)
        at = int(np.flatnonzero(worth == worth.max())[-1])
        for number, gone in _taken_away(filter, params, inputs, at):
            for i in np.flatnonzero(gone & counts[at] & left):
                found[i].append(number)
        left &= ~counts[at]
    return tuple(map(tuple, found))


NAMED: Any = namedtuple  # of fields that are known when it runs

# They run once: optimising their compilation would take longer than the run.
_quickly = partial(
    jax.jit, static_argnums=0, compiler_options={"xla_backend_optimization_level": 0}
)


@dataclass(frozen=True)
class MeasurementMask:
    """Masks that make the measurements of some innovations missing.

    Attributes:
        parts: of :func:`measured_entries`.
    """

    parts: MeasuredEntries
    _owners: dict[int, tuple[tuple[int, int], ...]] = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        owners: dict[int, list[tuple[int, int]]] = {}
        for i, part in enumerate(self.parts):
            for leaf, entry in part:
                owners.setdefault(leaf, []).append((entry, i))
        object.__setattr__(self, "_owners", {leaf: tuple(o) for leaf, o in owners.items()})

    def masked(self, inputs: Any, rejected: Array) -> Any:
        """The sample without the numbers of the innovations that are rejected, ``(m,)`` of bool.

        Raises:
            ValueError: for a sample of another form than that of the record.
        """
        leaves, tree = jax.tree.flatten(inputs)
        for leaf, owners in self._owners.items():
            if leaf >= len(leaves) or jnp.size(leaves[leaf]) <= max(entry for entry, _ in owners):
                raise ValueError(
                    "the samples have other parts than the record in which the measurements were "
                    "found; find them again by filters.measured_entries"
                )
            mask = np.zeros((jnp.size(leaves[leaf]), len(self.parts)), bool)
            mask[tuple(np.array(owners).T)] = True
            gone = (jnp.asarray(mask) & rejected).any(axis=1).reshape(jnp.shape(leaves[leaf]))
            leaves[leaf] = jnp.where(gone, jnp.nan, leaves[leaf])
        return jax.tree.unflatten(tree, leaves)

    def seen(self, inputs: Any) -> Array:
        """Which innovations have all of their numbers in a sample, ``(m,)`` of bool."""
        leaves = [jnp.ravel(leaf) for leaf in jax.tree.leaves(inputs)]
        each = [[~jnp.isnan(leaves[leaf][entry]) for leaf, entry in part] for part in self.parts]
        return jnp.stack([jnp.stack(e).all() if e else jnp.array(False) for e in each])

    def together(self, rejected: Array) -> Array:
        """Those rejected, and those that go with them because they are made of the same number."""
        one = [set(part) for part in self.parts]
        share = np.array([[bool(a & b) or a is b for a in one] for b in one])
        return (jnp.asarray(share) & rejected).any(axis=1)


def check_innovations(filter: Any, outputs: Any) -> None:
    """Refuse a filter that outputs too little about its innovations.

    Raises:
        ValueError: where outputs have no innovation, no variance, or one variance for several.
    """
    lacking = [part for part in ("innovation", "variance") if not hasattr(outputs, part)]
    if lacking:
        raise ValueError(
            f"{type(bare(filter)).__name__} outputs no {' and no '.join(lacking)}, so there is "
            "nothing by which a measurement could be rejected; take a Kalman filter"
        )
    if jnp.ndim(outputs.innovation) != jnp.ndim(outputs.variance):
        raise ValueError(
            f"several signals pass through one {type(bare(filter)).__name__}, whose innovations "
            "cannot be rejected one by one; run it for each signal, as in filters.Lanes"
        )


def with_fields(outputs: Any, more: tuple[str, ...]) -> Any:
    """A NamedTuple's class with more fields after its own; the same one every time.

    >>> from typing import NamedTuple
    >>> class Pair(NamedTuple):
    ...     left: int
    ...     right: int
    >>> with_fields(Pair, ("middle",))(1, 2, 3).middle
    3
    """
    known: Any = outputs
    return _widened(known, more)


@cache
def _widened(outputs: Any, more: tuple[str, ...]) -> Any:
    own = tuple(name for name in outputs._fields if name not in more)
    return NAMED(outputs.__name__, own + more)


@_quickly
def _variances(filter: AnyFilter, params: Any, inputs: Any) -> Array:
    outputs = run(filter, params, inputs)[1]
    check_innovations(filter, outputs)
    variance: Array = outputs.variance
    return variance


def _taken_away(
    filter: AnyFilter, params: Any, inputs: Any, at: int
) -> list[tuple[tuple[int, int], np.ndarray]]:
    """Every number of a sample, and which variances are 0 without it, ``(m,)`` of bool."""
    leaves = [jnp.asarray(leaf) for leaf in jax.tree.leaves(inputs)]
    floats = [i for i, leaf in enumerate(leaves) if jnp.issubdtype(leaf.dtype, jnp.floating)]
    numbers = [(i, entry) for i in floats for entry in range(leaves[i][0].size)]
    holes = [np.zeros((len(numbers), leaf[0].size), bool) for leaf in leaves]
    for row, (i, entry) in enumerate(numbers):
        holes[i][row, entry] = True
    before = _state(filter, params, jax.tree.map(lambda leaf: leaf[:at], inputs))
    sample = jax.tree.map(lambda leaf: leaf[at], inputs)
    left = np.asarray(_without(filter, params, before, sample, tuple(map(jnp.asarray, holes))))
    return [(number, left[row] == 0) for row, number in enumerate(numbers)]


@_quickly
def _state(filter: AnyFilter, params: Any, inputs: Any) -> Any:
    return run(filter, params, inputs)[0]


@_quickly
def _without(
    filter: AnyFilter, params: Any, before: Any, sample: Any, holes: tuple[Array, ...]
) -> Array:
    """Variances at a sample with each of the holes, ``(B, m)``."""
    leaves, tree = jax.tree.flatten(sample)

    def variances(holes: tuple[Array, ...]) -> Array:
        made = [
            jnp.where(hole.reshape(leaf.shape), jnp.nan, leaf)
            if jnp.issubdtype(leaf.dtype, jnp.floating)
            else leaf
            for leaf, hole in zip(leaves, holes, strict=True)
        ]
        out: Array = filter.step(params, before, jax.tree.unflatten(tree, made))[1].variance
        return out

    return jax.vmap(variances)(holes)
