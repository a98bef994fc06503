"""The operations of a traced function, one after another, by NumPy."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

import jax
import numpy as np

from objectives.in_numpy.arrays import ARRAYS
from objectives.in_numpy.elementwise import ELEMENTWISE
from objectives.in_numpy.linalg import LINALG
from objectives.in_numpy.places import PLACES

Evaluate = Callable[..., Any]
"""From an operation's NumPy arrays, and its parameters by name, to one result or several."""


OFTEN = 100_000
"""Operations from which a small function would have been compiled in less time."""
AS_MANY = 250
"""So many operations take as long as it takes to compile one."""
LOOP = 10
"""Passes that are counted of a loop of unknown length."""
Orders: TypeAlias = dict[frozenset[str], list[str]]
"""The order of results' names, for each set of names."""


class _Taken(NamedTuple):
    """Operations of a call, those from which compiling pays, and those of all calls so far."""

    each: int
    most: int
    so_far: int = 0


Taken: TypeAlias = dict[Any, _Taken]
"""The operations that each trace has taken."""


class _UnknownError(Exception):
    """An operation that NumPy does not do here."""


@dataclass(frozen=True)
class Method:
    """A method of what compares by its contents; equal ones are traced once.

    >>> from filters import LocalLevel, LocalLevelNoise
    >>> noise = LocalLevelNoise(q=np.array(1.0), R=np.array(1.0))
    >>> float(in_numpy(Method(LocalLevel(1.0), "derive"), noise)["K"].round(6))
    0.618034
    """

    owner: Any
    name: str

    def __call__(self, *arguments: Any) -> Any:
        """The method's result."""
        return getattr(self.owner, self.name)(*arguments)


def in_numpy(function: Callable[..., Any], *arguments: Any) -> Any:
    """A JAX function's result, in NumPy's arrays, without compiling anything.

    Numbers differ from those of ``jax.jit`` by rounding alone. A function that cannot be traced is
    called as it is. One with an operation that is not known here is compiled, and so is one of
    which calls with the same shapes have taken longer than its compilation.

    Args:
        function: of arrays and tuples of such; equal ones are traced once.
        arguments: its arguments, which may hold NumPy's or JAX's arrays and numbers.

    >>> import jax.numpy as jnp
    >>> in_numpy(lambda a: {"root": jnp.sqrt(a)}, np.array([4.0, 9.0]))
    {'root': array([2., 3.])}
    """
    jitted, orders, taken = _jitted(function)
    try:
        traced = jitted.trace(*arguments)
    except (jax.errors.JAXTypeError, jax.errors.JAXIndexError):
        found = function(*arguments)
        return _in_order(jax.tree.map(np.asarray, found), _order(found))
    closed, shapes = traced.jaxpr, traced.out_info
    count = taken.get(closed) or _Taken(_operations(closed), _most(closed))
    taken[closed] = count = count._replace(so_far=count.so_far + count.each)
    if count.so_far > count.most:
        return _in_order(jax.tree.map(np.asarray, jitted(*arguments)), orders)
    leaves = [np.asarray(leaf) for leaf in jax.tree.leaves(arguments)]
    try:
        with np.errstate(all="ignore"):
            found = _evaluated(closed.jaxpr, closed.consts, leaves)
    except _UnknownError:
        return _in_order(jax.tree.map(np.asarray, jitted(*arguments)), orders)
    return _in_order(jax.tree.unflatten(jax.tree.structure(shapes), found), orders)


@lru_cache(maxsize=64)  # those of some fifteen fits
def _jitted(function: Callable[..., Any]) -> tuple[Any, Orders, Taken]:
    """The function to be traced, the order of its results' names, and the operations it took."""
    orders: Orders = {}

    def called(*arguments: Any) -> Any:
        found = function(*arguments)
        orders.update(_order(found))
        return found

    return jax.jit(called), orders, {}


def _operations(program: Any, *, once: bool = False) -> int:
    """About how many operations a traced program takes; once: how many it is written with."""
    count = 0
    for equation in getattr(program, "jaxpr", program).eqns:
        params = equation.params
        passes = params.get("length", LOOP if equation.primitive.name == "while" else 1)
        held = [each for value in params.values() for each in _several(value)]
        inner = [each for each in held if hasattr(each, "eqns") or hasattr(each, "jaxpr")]
        inside = sum(_operations(each, once=once) for each in inner)
        count += 1 + (1 if once else passes) * inside
    return count


def _most(program: Any) -> int:
    """Operations from which compiling a traced program would have taken less time."""
    return max(OFTEN, AS_MANY * _operations(program, once=True))


def _several(value: Any) -> tuple[Any, ...]:
    return tuple(value) if isinstance(value, tuple | list) else (value,)


def _order(found: Any) -> Orders:
    return {frozenset(found): [*found]} if type(found) is dict else {}


def _in_order(found: Any, orders: Orders) -> Any:
    """Results in the order of their function; JAX sorts their names."""
    if type(found) is not dict:
        return found
    return {name: found[name] for name in orders.get(frozenset(found), found)}


class _Line(NamedTuple):
    """An operation: the places of what it takes, and of what comes out of it with its types."""

    operation: Evaluate
    takes: tuple[int, ...]
    params: dict[str, Any]
    several: bool
    gives: tuple[tuple[int, Any], ...]


class _Listed(NamedTuple):
    """A traced program with places for its values: what is known, is given, is done, comes out."""

    known: list[Any]
    given: tuple[Any, ...]
    lines: tuple[_Line, ...]
    results: tuple[int, ...]


@lru_cache(maxsize=4096)
def _listed(jaxpr: Any) -> _Listed:
    """The lines of a traced program, which loops pass many times."""
    places: dict[Any, int] = {}
    known: list[Any] = []

    def place(atom: Any) -> int:
        if hasattr(atom, "val"):
            known.append(np.asarray(atom.val, atom.aval.dtype))
            return len(known) - 1
        if atom not in places:
            known.append(None)
            places[atom] = len(known) - 1
        return places[atom]

    first = [*jaxpr.constvars, *jaxpr.invars]
    given = tuple((place(variable), variable.aval.dtype) for variable in first)
    lines = []
    for equation in jaxpr.eqns:
        primitive = equation.primitive
        if primitive.name not in KNOWN:
            raise _UnknownError(primitive.name)
        takes = tuple(map(place, equation.invars))
        gives = tuple((place(variable), variable.aval.dtype) for variable in equation.outvars)
        operation, several = KNOWN[primitive.name], primitive.multiple_results
        lines.append(_Line(operation, takes, equation.params, several, gives))
    results = tuple(map(place, jaxpr.outvars))
    return _Listed(known, given, tuple(lines), results)


def _evaluated(jaxpr: Any, consts: Sequence[Any], given: Sequence[np.ndarray]) -> list[np.ndarray]:
    """The results of a traced program."""
    listed = _listed(jaxpr)
    values = listed.known.copy()
    for (place, kind), value in zip(listed.given, (*consts, *given), strict=True):
        values[place] = np.asarray(value, kind)
    for operation, takes, params, several, gives in listed.lines:
        found = operation(*[values[place] for place in takes], **params)
        for (place, kind), value in zip(gives, found if several else (found,), strict=True):
            values[place] = np.asarray(value, kind)
    return [values[place] for place in listed.results]


def _closed(program: Any, *given: np.ndarray) -> list[np.ndarray]:
    return _evaluated(program.jaxpr, program.consts, given)


def _called(*given: np.ndarray, **params: Any) -> list[np.ndarray]:
    program = next(params[name] for name in ("jaxpr", "call_jaxpr", "fun_jaxpr") if name in params)
    return (
        _closed(program, *given) if hasattr(program, "consts") else _evaluated(program, (), given)
    )


def _while(
    *given: np.ndarray, cond_jaxpr: Any, body_jaxpr: Any, cond_nconsts: int, body_nconsts: int
) -> list[np.ndarray]:
    both = cond_nconsts + body_nconsts
    asks, does, state = given[:cond_nconsts], given[cond_nconsts:both], list(given[both:])
    while True:
        on = _closed(cond_jaxpr, *asks, *state)[0]
        if not on.any():
            return state
        moved = _closed(body_jaxpr, *does, *state)
        # Of loops side by side each ends by itself.
        state = [_where(on, new, old) for new, old in zip(moved, state, strict=True)]


def _where(on: np.ndarray, new: np.ndarray, old: np.ndarray) -> np.ndarray:
    return np.where(on.reshape(on.shape + (1,) * (new.ndim - on.ndim)), new, old)


def _cond(index: np.ndarray, *given: np.ndarray, branches: Sequence[Any], **_: Any) -> Any:
    return _closed(branches[min(max(int(index), 0), len(branches) - 1)], *given)


def _scan(
    *given: np.ndarray,
    jaxpr: Any,
    num_consts: int,
    num_carry: int,
    length: int,
    reverse: bool,
    **_: Any,
) -> list[np.ndarray]:
    begin = num_consts + num_carry
    consts, state, samples = given[:num_consts], list(given[num_consts:begin]), given[begin:]
    collected: list[list[np.ndarray]] = []
    for at in reversed(range(length)) if reverse else range(length):
        found = _closed(jaxpr, *consts, *state, *(each[at] for each in samples))
        state = found[:num_carry]
        collected.append(found[num_carry:])
    if reverse:
        collected.reverse()
    shapes = [v.aval for v in jaxpr.jaxpr.outvars[num_carry:]]
    stacked = [
        np.stack([each[k] for each in collected]) if collected else np.zeros((0, *shape.shape))
        for k, shape in enumerate(shapes)
    ]
    return [*state, *stacked]


def _as_given(*given: np.ndarray, **_: Any) -> list[np.ndarray]:
    """What tells a compiler what to keep apart."""
    return list(given)


def _linear_solve(*given: np.ndarray, const_lengths: Any, jaxprs: Any) -> list[np.ndarray]:
    """As JAX solves it, which is exact where the way is a factorisation."""
    begin = const_lengths.matvec + const_lengths.vecmat
    consts, right = given[begin : begin + const_lengths.solve], given[sum(const_lengths) :]
    return _closed(jaxprs.solve, *consts, *right)


def _platform(*, platforms: Any) -> int:
    """Which of several ways is that of this processor."""
    return next(k for k, names in enumerate(platforms) if names is None or "cpu" in names)


CONTROL: dict[str, Evaluate] = {
    "jit": _called,
    "pjit": _called,
    "closed_call": _called,
    "core_call": _called,
    "checkpoint": _called,
    "custom_jvp_call": _called,
    "custom_vjp_call": _called,
    "while": _while,
    "cond": _cond,
    "scan": _scan,
    "custom_linear_solve": _linear_solve,
    "platform_index": _platform,
    "optimization_barrier": _as_given,
}
KNOWN: dict[str, Evaluate] = {**ELEMENTWISE, **ARRAYS, **PLACES, **LINALG, **CONTROL}
