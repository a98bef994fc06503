"""The evaluation of a traced function, operation by operation, on arrays of any objects.

The entries are nodes of a graph or another program's symbols, in NumPy arrays of objects. What
depends on none of them is worked out by JAX. A table says what each operation is; loops within a
step are unrolled, both branches of a condition taken. What has no entry is refused by its name.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, TypeAlias

import numpy as np
from jax.extend import core

from tuner.code.numbers import worked_out
from tuner.code.refused import check_type, no_counterpart

Arrays: TypeAlias = list[np.ndarray]
Rule: TypeAlias = "Callable[[Algebra, Any, Arrays], Arrays]"
"""The map from an algebra, a traced operation and its operands to its results."""


class Algebra(Protocol):
    """Operations on the entries of arrays."""

    def constant(self, value: Any) -> Any:
        """The entry of a constant."""
        ...

    def apply(self, op: str, *entries: Any) -> Any:
        """One operation of :mod:`tuner.code.operations`."""
        ...

    def choose(self, condition: Any, no: Any, yes: Any) -> Any:
        """One of two."""
        ...

    def convert(self, entry: Any, dtype: np.dtype) -> Any:
        """A conversion to another kind of number."""
        ...


@dataclass(frozen=True)
class Interpreter:
    """A way through traced functions.

    Attributes:
        algebra: of the entries.
        rules: for each operation.
        moves: those of them that move numbers as well as entries.
        numbers: NumPy's functions for operations on real numbers.
        unrolls: whether loops are unrolled, or refused.
        observer: called with every operation of the function and its loops, and its results.
    """

    algebra: Algebra
    rules: Mapping[str, Rule]
    moves: Mapping[str, Rule]
    numbers: Mapping[str, Callable[..., Any]]
    unrolls: bool = True
    observer: Callable[[Any, Arrays], None] | None = None

    def closed(self, jaxpr: core.ClosedJaxpr, arguments: Sequence[np.ndarray]) -> Arrays:
        """The results of a traced function.

        Raises:
            NoCounterpartError: names the operation that has no counterpart.
        """
        known: dict[Any, np.ndarray] = {}
        known.update(zip(jaxpr.jaxpr.constvars, map(np.asarray, jaxpr.consts), strict=True))
        known.update(zip(jaxpr.jaxpr.invars, arguments, strict=True))

        def read(atom: Any) -> np.ndarray:
            if isinstance(atom, core.Literal):
                return np.asarray(atom.val, aval_of(atom).dtype)
            return known[atom]

        for equation in jaxpr.jaxpr.eqns:
            found = self.equation(equation, [read(atom) for atom in equation.invars])
            known.update(zip(equation.outvars, found, strict=True))
            if self.observer is not None:
                self.observer(equation, found)
        return [read(atom) for atom in jaxpr.jaxpr.outvars]

    def equation(self, equation: Any, given: Arrays) -> Arrays:
        """The results of one operation."""
        name, inner = equation.primitive.name, inner_of(equation)
        if inner is not None:  # JAX caches these, with the lines of their first caller
            return replace(self, observer=None).closed(inner, given)
        if all(array.dtype != object for array in given):
            return self.known(equation, given)
        if name == "scan" and self.unrolls:
            return self._scan(equation.params, given)
        if name == "cond":
            return self._cond(equation.params["branches"], given[0], given[1:])
        if name not in self.rules:
            raise no_counterpart(name)
        for out in equation.outvars:
            check_type(name, out.aval.dtype)
        return self.rules[name](self.algebra, equation, given)

    def known(self, equation: Any, given: Arrays) -> Arrays:
        """A result of known operands: by NumPy where it equals JAX, else compiled by JAX."""
        name = equation.primitive.name
        if name in self.moves:
            return self.moves[name](self.algebra, equation, given)
        if name in self.numbers and all(array.dtype.kind == "f" for array in given):
            with np.errstate(all="ignore"):
                found = self.numbers[name](*given)
            return [np.asarray(found, equation.outvars[0].aval.dtype)]
        return worked_out(equation, given)

    def _scan(self, params: Mapping[str, Any], given: Arrays) -> Arrays:
        shared, carried = params["num_consts"], params["num_carry"]
        consts, carry = given[:shared], given[shared : shared + carried]
        stacked = given[shared + carried :]
        turns = range(params["length"])
        rows: dict[int, Arrays] = {}
        for k in reversed(turns) if params["reverse"] else turns:
            now = [array[k : k + 1].reshape(array.shape[1:]) for array in stacked]
            found = self.closed(params["jaxpr"], [*consts, *carry, *now])
            carry, rows[k] = found[:carried], found[carried:]
        columns = zip(*(rows[k] for k in turns), strict=True)
        return [*carry, *(np.stack(mixed(self.algebra, column)) for column in columns)]

    def _cond(self, branches: Sequence[Any], index: np.ndarray, given: Arrays) -> Arrays:
        if index.dtype != object:
            return self.closed(branches[int(np.clip(index, 0, len(branches) - 1))], given)
        found = [self.closed(branch, given) for branch in branches]
        chosen = found[-1]
        for k in range(len(branches) - 2, -1, -1):
            here = self.algebra.apply("le", index[()], self.algebra.constant(np.int32(k)))
            chosen = [
                each(lambda no, yes, at=here: self.algebra.choose(at, no, yes), *pair)
                for pair in zip(
                    *(objects(self.algebra, part) for part in (chosen, found[k])), strict=True
                )
            ]
        return chosen


def inner_of(equation: Any) -> core.ClosedJaxpr | None:
    """The function of an operation that only calls one; else None."""
    name, params = equation.primitive.name, equation.params
    if name in ("jit", "pjit", "closed_call", "core_call", "custom_jvp_call", "custom_vjp_call"):
        for key in ("jaxpr", "call_jaxpr"):
            if isinstance(params.get(key), core.ClosedJaxpr):
                closed: core.ClosedJaxpr = params[key]
                return closed
    if name in ("remat", "remat2", "checkpoint"):
        return core.ClosedJaxpr(params["jaxpr"], ())
    return None


def aval_of(variable: Any) -> Any:
    """Shape and type of a variable or a number of a traced function."""
    return variable.aval


def rows_of(array: np.ndarray, axis: int = 0) -> Arrays:
    """The parts of an array along an axis, as arrays."""
    rows = np.moveaxis(array, axis, 0)
    return [rows[k : k + 1].reshape(rows.shape[1:]) for k in range(len(rows))]


def each(function: Callable[..., Any], *arrays: np.ndarray) -> np.ndarray:
    """A function of entries, elementwise; shapes of JAX agree already, or are scalar."""
    shape = np.broadcast_shapes(*(array.shape for array in arrays))
    out = np.empty(shape, object)
    whole = [np.broadcast_to(array, shape) for array in arrays]
    for index in np.ndindex(shape):
        out[index] = function(*(array[index] for array in whole))
    return out


def objects(algebra: Algebra, arrays: Sequence[np.ndarray]) -> Arrays:
    """The arrays as entries: numbers become constants."""
    return [array if array.dtype == object else each(algebra.constant, array) for array in arrays]


def mixed(algebra: Algebra, arrays: Sequence[np.ndarray]) -> Arrays:
    """The arrays; all as entries, where one of them has entries."""
    if all(array.dtype != object for array in arrays):
        return list(arrays)
    return objects(algebra, arrays)
