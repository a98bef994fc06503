"""Many recordings end to end in a few lines, so that nothing is computed for what only fills up."""

import heapq
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, TypeVar, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Joined, JoinedSample, Lanes
from objectives import Data, Fold, Way, is_additive, is_fold
from objectives.likelihood import Likely
from objectives.squares import Squares
from tuner.problem.programs import Static, judged_of, sum_and_gradient_of, sum_of
from tuner.processors import side_by_side

SIDE_BY_SIDE = 8
"""Lines in one time loop: enough to fill the processor's vectors."""
LEAST = 20_000
"""Samples of all recordings, padded, from which lines pay for their longer step."""
LENGTH = 4096
"""Samples of a line: what a part keeps for a gradient's way back lies in the processor's cache."""
T = TypeVar("T")


class OneRecord(NamedTuple):
    """A record that may be parted: static part, data ``(M, ...)``, first samples of later parts."""

    static: Static
    data: Data
    at: tuple[int, ...] = ()


@dataclass(frozen=True, eq=False)
class Lines:
    """The recordings of a problem in lines, in as many parts as there are processors.

    Attributes:
        static: of the compilation; its filter takes one sample of each line of a part.
        parts: the data of each part, of one shape: ``(T, lines, ...)``. Lines are filled up to T
            with samples that do not count.
    """

    static: Static
    parts: tuple[Data, ...]

    def value(self, z: np.ndarray, values: dict[str, Array], given: Array) -> float:
        """The objective at z ``(n,)``, or of values by name where these are given."""
        totals = self._each(partial(sum_of, self.static, z, values, given))
        return float(judged_of(self.static.objective, _added(totals))[0])

    def value_and_gradient(self, way: Way, z: np.ndarray) -> tuple[float, np.ndarray]:
        """The objective and its gradient at z ``(n,)``."""
        totals, slopes = zip(
            *self._each(partial(sum_and_gradient_of, self.static, way, z)), strict=True
        )
        value, slope = judged_of(self.static.objective, _added(totals))
        return float(value), float(slope) * np.sum(np.asarray(slopes), axis=0)

    def end_to_end(self) -> OneRecord:
        """The same as one record."""
        static = self.static._replace(filter=cast("Lanes", self.static.filter).filter)

        def one(*parts: Array) -> np.ndarray:
            by_line = np.concatenate([np.swapaxes(np.asarray(part), 0, 1) for part in parts])
            return by_line.reshape(-1, *by_line.shape[2:])

        data = jax.tree.map(one, *self.parts)
        each = len(data.inputs.begins) // len(self.parts)
        return OneRecord(static, data, tuple(each * i for i in range(1, len(self.parts))))

    def _each(self, evaluate: Callable[[Data], T]) -> list[T]:
        """The result of each part, each in a thread where there are processors for it."""
        return side_by_side(lambda part: jax.block_until_ready(evaluate(part)), self.parts)


def lines_of(static: Static, data: Data) -> Lines | None:
    """The recordings of a problem in lines; None where they are too few, or do not add up.

    A sample counts where its truth is not NaN. What comes after the last one of a recording is left
    out, and so is a recording without any.

    Args:
        static: of the problem.
        data: of recordings side by side, ``(N, k, ...)``.
    """
    filter, objective = static.filter, static.objective
    adds_up = is_fold(objective) and is_additive(objective)
    if not isinstance(filter, Lanes) or not adds_up:
        return None
    if type(jax.eval_shape(cast("Fold", objective).init)) not in (Likely, Squares):
        return None
    samples, leaves = data.samples, jax.tree.leaves(data.truth)
    if samples * filter.count < LEAST or not all(_has_lanes(leaf, filter) for leaf in leaves):
        return None
    lengths = _lengths(leaves)
    if np.sum(lengths > 0) < 2:
        return None
    parts = _plan(lengths)
    longest = max(lengths[line].sum() for part in parts for line in part)
    joined = static._replace(filter=Lanes(Joined(filter.filter), len(parts[0])))
    return Lines(joined, tuple(_part(data, part, lengths, longest) for part in parts))


def _has_lanes(leaf: Any, filter: Lanes) -> bool:
    return np.ndim(leaf) > 1 and np.shape(leaf)[1] == filter.count


def _lengths(truth: Sequence[Any]) -> np.ndarray:
    """Samples of each recording up to the last one that counts, ``(k,)``."""
    each = (np.asarray(leaf) for leaf in truth)
    counts = [(~np.isnan(leaf)).reshape(*leaf.shape[:2], -1).any(axis=-1) for leaf in each]
    there = np.logical_or.reduce(counts)
    return np.where(there.any(axis=0), len(there) - np.argmax(there[::-1], axis=0), 0)


def _plan(lengths: np.ndarray) -> list[list[list[int]]]:
    """The recordings of each line of each part, about equally long: the longest are placed first.

    >>> parts = _plan(np.full(1000, 1000))
    >>> len(parts), len(parts[0])
    (31, 8)
    """
    used = np.argsort(-lengths, kind="stable")[: np.count_nonzero(lengths)]
    total, longest = int(lengths.sum()), int(lengths.max())
    most = max(1, min(len(used), total // longest))
    lanes = min(SIDE_BY_SIDE, -(-most // (os.cpu_count() or 1)))
    parts = max(1, min(most // lanes, round(total / lanes / max(longest, LENGTH))))
    lines: list[list[int]] = [[] for _ in range(parts * lanes)]
    taken = [(0, line) for line in range(len(lines))]
    for i in map(int, used):
        samples, line = heapq.heappop(taken)
        lines[line].append(i)
        heapq.heappush(taken, (samples + int(lengths[i]), line))
    return [lines[part::parts] for part in range(parts)]


def _part(data: Data, lines: list[list[int]], lengths: np.ndarray, longest: int) -> Data:
    """Recordings in lines of one length; the last sample is repeated, and does not count."""
    shape = longest, len(lines)
    rows, lanes = np.empty(shape, int), np.empty(shape, int)
    begins, filled = np.zeros(shape, bool), np.zeros(shape, bool)
    for column, line in enumerate(lines):
        row = np.concatenate([np.arange(lengths[i]) for i in line])
        rows[:, column] = np.append(row, np.full(longest - len(row), row[-1]))
        lanes[: len(row), column] = np.repeat(line, lengths[line])
        lanes[len(row) :, column] = line[-1]
        begins[: len(row), column], filled[len(row) :, column] = row == 0, True

    def chosen(leaf: Any) -> np.ndarray:
        return np.asarray(leaf)[rows, lanes]

    truth = jax.tree.map(chosen, data.truth)
    for leaf in jax.tree.leaves(truth):
        leaf[filled] = np.nan
    inputs = JoinedSample(jnp.asarray(begins), jax.tree.map(chosen, data.inputs))
    return cast("Data", jax.device_put(Data(inputs, truth)))


def _added(totals: Sequence[Any]) -> Any:
    """The sum of the parts' sums."""
    return jax.tree.map(lambda *each: np.sum([np.asarray(one) for one in each]), *totals)
