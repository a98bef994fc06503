"""A step on many states by compiled C, fast and without the interpreter's lock."""

import ctypes
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from tuner.code.array_functions import is_rounded, smooth_operands
from tuner.code.calculator import code_of
from tuner.code.evaluation import Given, Sums, Values
from tuner.code.mutants import WHOLE, Mutant
from tuner.code.nodes import Node
from tuner.code.rounding_errors import Noise

_CACHED, _LEAST = 40_000, 16
"""Numbers that a processor has at hand, and the fewest states that are worked out together."""


class _Rows(Values):
    """Values of nodes on many states, ``(B,)`` each.

    Args:
        array: of all nodes, ``(n, B)``.
        places: the row of each.
        kinds: of the nodes.
    """

    def __init__(self, array: np.ndarray, places: Mapping[int, int], kinds: Sequence[str]) -> None:
        self.array, self._places, self._kinds = array, places, kinds
        self._converted = dict[int, np.ndarray]()

    def __getitem__(self, k: int) -> np.ndarray:
        kind, row = self._kinds[self._places[k]], np.asarray(self.array[self._places[k]])
        if kind == "real":
            return row
        if k not in self._converted:
            self._converted[k] = row.astype(bool if kind == "truth" else int)
        return self._converted[k]

    def __iter__(self) -> Iterator[int]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)

    def of(self, which: np.ndarray) -> "_Rows":
        """Those of some states."""
        return _Rows(np.ascontiguousarray(self.array[:, which]), self._places, self._kinds)


class Compiled:
    """Some nodes of a step, each of which follows from those before it.

    Args:
        code: the compiled functions.
        nodes: of the graph.
        order: which, in order.
        ends: those whose values are asked for.

    Attributes:
        inputs: those that are.
    """

    def __init__(
        self,
        code: ctypes.CDLL,
        nodes: Sequence[Node],
        order: Sequence[int],
        ends: Collection[int],
    ) -> None:
        self._ends = None if len(ends) == len(order) else list(dict.fromkeys(ends))
        self._code, self._nodes = code, [nodes[k] for k in order]
        self._places = {k: place for place, k in enumerate(order)}
        self._kinds = [node.kind for node in self._nodes]
        self._ops = np.array([code_of(node, nodes) for node in self._nodes], np.uint8)
        self._args = np.zeros((len(order), 3), np.int32)
        for row, node in zip(self._args, self._nodes, strict=True):
            row[: len(node.args)] = [self._places[k] for k in node.args]
        placed = enumerate(self._nodes)
        self._constants = [place for place, node in placed if node.op == "constant"]
        self._numbers = np.array([float(self._nodes[k].value) for k in self._constants])
        self.inputs = [k for k in order if nodes[k].op == "input"]

    def values(self, given: Given) -> Values:
        """The ends, from the inputs."""
        if self._ends is None:
            rows = self._filled(given)
            self._run("values", rows)
            return _Rows(rows, self._places, self._kinds)
        width = max((len(given[k]) for k in self.inputs), default=1)
        numbers = np.empty((len(self.inputs), width))
        for row, k in zip(numbers, self.inputs, strict=True):
            row[:] = given[k]
        places, ends = self._where(self.inputs), self._where(self._ends)
        out = np.empty((len(ends), width))
        rows = self._begun(min(width, max(_LEAST, _CACHED // len(self._nodes))))
        self._run("some_values", rows, width, len(places), places, numbers, len(ends), ends, out)
        kinds = [self._kinds[place] for place in ends]
        return _Rows(out, {k: n for n, k in enumerate(self._ends)}, kinds)

    def noisy(self, given: Given, noise: Noise, ends: Sequence[int]) -> dict[int, np.ndarray]:
        """Some with random rounding errors of every operation, ``(repeats, B)`` each."""
        rows = self._filled(given)
        errors, begin = noise.row(rows.shape[1], int(self._rounded.sum()))
        out = np.empty((len(ends), noise.repeats, rows.shape[1]))
        given_ends = len(ends), self._where(ends), out
        self._run("noisy", rows, noise.repeats, self._rounded, errors, begin, *given_ends)
        return dict(zip(ends, out, strict=True))

    def changed(
        self, known: Values, ends: Sequence[int], mutants: Sequence[Mutant], by: float
    ) -> list[np.ndarray]:
        """Some, ``(M, B)`` where a change of a constant by a factor moves them, or ``(B,)``."""
        rows, count = self._array(known), len(mutants)
        differs = np.empty(len(rows), np.uint8)
        out = np.empty((count, len(ends), rows.shape[1]))
        moved = np.zeros(len(ends), np.uint8)
        self._run(
            "changed",
            rows,
            count,
            self._where([one.node for one in mutants]),
            np.array([one.at for one in mutants], np.int8),
            np.array([one.limit for one in mutants], np.uint8),
            by,
            len(ends),
            self._where(ends),
            self._scratch(rows, 1),
            differs,
            out,
            moved,
        )
        return [out[:, k] if moved[k] else known[end] for k, end in enumerate(ends)]

    def slopes(self, known: Values, sums: Sums) -> np.ndarray:
        """Sums of squared moves of weighted sums of results, ``(M, B)``, to first order."""
        rows = self._array(known)
        places = np.full((len(rows), 4), -1, np.int32)
        for k, one in enumerate(sums.wanted):
            if not one.limit:
                places[self._places[one.node], 3 if one.at == WHOLE else one.at] = k
        squares = np.zeros((len(sums.wanted), rows.shape[1]))
        constant, moving, met = np.zeros((3, len(rows)), np.uint8)
        constant[self._constants] = 1
        weights, ends = np.ascontiguousarray(sums.weights), self._where(sums.ends)
        found = places, len(weights), len(ends), ends, weights, sums.change, sums.shift
        memory = self._scratch(rows, 4), moving, met, squares
        self._run("slopes", rows, self._smooth, constant, *found, *memory)
        return squares

    @cached_property
    def _rounded(self) -> np.ndarray:
        return np.array([is_rounded(node) for node in self._nodes], np.uint8)

    @cached_property
    def _smooth(self) -> np.ndarray:
        """The operands that each depends on smoothly: the first, and the one after the last."""
        found = [smooth_operands(node) for node in self._nodes]
        return np.array([(some.start, some.stop) for some in found], np.int8)

    def _begun(self, width: int) -> np.ndarray:
        """Rows of which the constants are there."""
        rows = np.zeros((len(self._nodes), width))
        rows[self._constants] = self._numbers[:, None]
        return rows

    def _filled(self, given: Given) -> np.ndarray:
        rows = self._begun(max((len(given[k]) for k in self.inputs), default=1))
        for k in self.inputs:
            rows[self._places[k]] = given[k]
        return rows

    def _array(self, known: Values) -> np.ndarray:
        if isinstance(known, _Rows):
            return known.array
        width = max(len(known[k]) for k in self._places)
        return np.array([np.broadcast_to(known[k], width) for k in self._places], float)

    def _where(self, ends: Collection[int]) -> np.ndarray:
        return np.array([self._places[k] for k in ends], np.int32)

    def _scratch(self, rows: np.ndarray, more: int) -> np.ndarray:
        return np.empty((len(rows) + more, rows.shape[1]))

    def _run(self, name: str, rows: np.ndarray, *more: np.ndarray | int | float) -> None:
        function = getattr(self._code, name)
        function(*map(_passed, (*rows.shape, self._ops, self._args, rows, *more)))


def _passed(one: np.ndarray | int | float) -> ctypes.c_void_p | ctypes.c_size_t | ctypes.c_double:
    if isinstance(one, np.ndarray):
        assert one.flags.c_contiguous
        return ctypes.c_void_p(one.ctypes.data)
    return ctypes.c_double(one) if isinstance(one, float) else ctypes.c_size_t(one)
