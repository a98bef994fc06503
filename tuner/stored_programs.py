"""Programs that are kept compiled between runs, so that another run need not trace them again.

A program is found again by the text of all that it follows from (:mod:`tuner.plain`): the filter,
the objective and other static arguments, the shapes of its arrays, this package's source, and the
versions and settings of JAX. What is no plain data, as a filter of the user's own, is traced in
every run.
"""

import json
import os
import sys
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeAlias

import jax
import numpy as np
from jax.tree_util import PyTreeDef

from tuner import code_version
from tuner.cached import digest, keep, keep_alone, kept, own, processor, program_folder
from tuner.not_by_jax import not_by_jax
from tuner.plain import NotPlainError, described
from tuner.programs_ahead import Program, Programs
from tuner.written_trees import read, written

BEGUN = time.time()
SETTLED = 5.0
"""Source files that changed later than so many seconds before this process began may be others
than those that it has loaded: nothing is stored or looked up then."""
_programs = Programs()

QUICKLY = {"xla_backend_optimization_level": 1}
"""Compiler options for programs that run a few times: a third less to compile a long one, and runs
a sixth longer."""
Call: TypeAlias = Callable[..., Any]
"""A compiled program, from leaves to its result."""


def in_use() -> bool:
    """Whether programs are stored: ``TUNER_PROGRAMS`` is ``stored``, and only this user writes."""
    return os.environ.get("TUNER_PROGRAMS") == "stored" and _trusted(program_folder())


@cache
def _trusted(folder: Path) -> bool:
    return own(folder) and not code_version.changed_since(BEGUN - SETTLED)


@cache
def _surroundings() -> str:
    """The versions and the settings under which programs are traced and compiled."""
    settings = [
        f"{name} {value!r}"
        for name, value in sorted(jax.config.values.items())
        if name != "jax_compilation_cache_dir"
    ]
    flags = os.environ.get("XLA_FLAGS", ""), sys.version, processor()
    return repr((sorted(code_version.versions().items()), settings, flags))


def key_of(*things: Any) -> str | None:
    """The key of what follows from plain data alone; None where some of them is not plain."""
    try:
        text = described(things)
    except NotPlainError:
        return None
    return _hashed(code_version.code_version(), text)


def _hashed(*texts: str) -> str:
    return digest("\0".join([_surroundings(), *texts]).encode())


def anything_compiled() -> bool:
    """Whether this process had to compile a program that it has kept."""
    return _programs.anything_compiled


def stored_text(make: Callable[[], str], *things: Any) -> str:
    """A text that follows from plain data, made once for all runs.

    Args:
        make: makes it.
        things: its name, and all that it follows from.
    """
    key = key_of("text", *things) if in_use() else None
    if key is None:
        return make()
    found = kept(program_folder(), key)
    if found is None:
        found = make().encode()
        keep(program_folder(), key, found)
    return found.decode()


def stored_jit(statics: int, **options: Any) -> Callable[[Callable[..., Any]], "StoredProgram"]:
    """As ``jax.jit`` of a function whose first arguments are static, and kept between runs.

    Args:
        statics: how many arguments are static.
        options: of XLA's compiler.
    """
    return lambda function: StoredProgram(function, statics, options)


@dataclass
class _Entry:
    """A program for some static arguments and shapes.

    Attributes:
        lock: of several threads one looks it up, or compiles.
        call: the program; None where JAX traces and keeps it.
        known: whether that is decided.
    """

    lock: threading.Lock = field(default_factory=threading.Lock)
    call: Call | None = None
    known: bool = False


class StoredProgram:
    """A function as ``jax.jit`` compiles it, kept between runs where its static data are plain.

    Args:
        function: the function.
        statics: how many of its arguments are static, the first ones.
        options: of XLA's compiler.

    Attributes:
        traced: the function by ``jax.jit``; itself it is ``__wrapped__``.
    """

    def __init__(self, function: Callable[..., Any], statics: int, options: dict[str, Any]) -> None:
        self.__doc__, self.__name__ = function.__doc__, function.__name__
        self.__wrapped__, self._statics, self._options = function, statics, options
        self.traced: Any = jax.jit(
            function, static_argnums=tuple(range(statics)), compiler_options=options or None
        )
        self._entries: dict[Any, _Entry] = {}
        self._digests: dict[Any, str] = {}

    def __call__(self, *arguments: Any) -> Any:
        """The function of its arguments."""
        found = self._stored(arguments)
        if found is None:
            return self.traced(*arguments)
        call, leaves = found
        try:
            return call(*leaves)
        except jax.errors.JaxRuntimeError:  # a stored program that this machine cannot run
            return self.traced(*arguments)

    def of_first(self, *arguments: Any) -> Call:
        """The function of its first array alone, for arrays of its shape; it looks up nothing.

        Args:
            arguments: all of them. The others stay as they are, and are on the device from now on.
        """
        static, others = arguments[: self._statics], jax.device_put(arguments[self._statics + 1 :])
        found, rest = self._stored(arguments), jax.tree.leaves(others)

        def traced(array: Any) -> Any:
            return self.traced(*static, array, *others)

        if found is None:
            return traced

        def stored(array: Any) -> Any:
            try:
                return found[0](array, *rest)
            except jax.errors.JaxRuntimeError:  # as above
                return traced(array)

        return stored

    def _stored(self, arguments: tuple[Any, ...]) -> tuple[Call, list[Any]] | None:
        """The program for the arguments and their leaves; None where JAX keeps it."""
        if not in_use():
            return None
        static, leaves, tree, shapes = self._split(arguments)
        if None in shapes:  # inside another program
            return None
        call = self._program(static, leaves, tree, shapes)
        return None if call is None else (call, leaves)

    def digest(self, *arguments: Any) -> str:
        """The SHA-256 of the program's text with all its constants, for arrays of these shapes.

        It is traced for that only where it was not yet.
        """
        static, leaves, tree, shapes = self._split(arguments)
        place = static, tree, shapes

        def traced() -> str:
            if place not in self._digests:
                self._lowered(static, leaves, tree)
            return self._digests[place]

        name = f"digest of {self.__name__}"
        return stored_text(traced, name, static, jax.tree.unflatten(tree, shapes))

    def _split(self, arguments: tuple[Any, ...]) -> tuple[Any, list[Any], Any, Any]:
        """The static arguments, the leaves of the others, their structure and their shapes."""
        static, given = arguments[: self._statics], arguments[self._statics :]
        leaves, tree = jax.tree.flatten(given)
        return static, leaves, tree, _shapes(leaves)

    def clear_cache(self) -> None:
        """Let go of all programs, as JAX's own functions do."""
        self._entries.clear()
        self._digests.clear()
        self.traced.clear_cache()

    def _cache_size(self) -> int:
        return len(self._entries) + int(self.traced._cache_size())

    def _program(self, static: Any, leaves: list[Any], tree: Any, shapes: Any) -> Call | None:
        entry = self._entries.setdefault((static, tree, shapes), _Entry())
        if not entry.known:
            with entry.lock:
                if not entry.known:
                    entry.call = self._found(static, leaves, tree, shapes)
                    entry.known = True
        return entry.call

    def _found(self, static: Any, leaves: list[Any], tree: Any, shapes: Any) -> Call | None:
        """The program from the folder, or compiled and stored; None where it has no identity."""
        function = self.__wrapped__
        place = f"{function.__module__}:{function.__qualname__}", [*self._options.items()]
        key = key_of(place, static, jax.tree.unflatten(tree, shapes))
        if key is None:
            return None
        found = kept(program_folder(), key)
        if found is not None:
            with suppress(Exception):  # damaged, or its program is gone
                known = json.loads(found)
                return _loaded(known["program"], read(known["result"], static), len(leaves))
        program, result, call = self._traced_anew(static, leaves, tree)
        with suppress(NotPlainError):
            known = {"program": program, "result": written(result, static)}
            keep(program_folder(), key, json.dumps(known).encode())
        return call

    def _traced_anew(
        self, static: Any, leaves: list[Any], tree: Any
    ) -> tuple[str, PyTreeDef, Call]:
        """The key of a program by its text, the structure of its result, and itself."""
        lowered, text, end = self._lowered(static, leaves, tree)
        key = _hashed(text, repr(self._options))
        with suppress(Exception):  # none yet, or damaged: compiled anew
            return key, end, _loaded(key, end, len(leaves))
        program = Program(key, len(leaves), end.num_leaves)
        return key, end, _calling(_compiled(lowered, program), end)

    def _lowered(self, static: Any, leaves: list[Any], tree: Any) -> tuple[Any, str, PyTreeDef]:
        """What XLA compiles, its text, and the structure of the result."""
        ends: list[PyTreeDef] = []

        def flat(*leaves: Any) -> list[Any]:
            given = jax.tree.unflatten(tree, leaves)
            found, ends[:] = _flattened(self.__wrapped__(*static, *given))
            return found

        flat.__name__ = flat.__qualname__ = f"stored_{self.__name__}"
        lowered = jax.jit(flat, compiler_options=self._options or None).lower(*leaves)
        text = lowered.as_text()
        self._digests[static, tree, _shapes(leaves)] = sha256(text.encode()).hexdigest()
        return lowered, text, ends[0]


def _shapes(leaves: list[Any]) -> tuple[tuple[tuple[int, ...], str, bool] | None, ...]:
    """Shape and type of each array; None of anything else."""
    return tuple(_shape(leaf) for leaf in leaves)


def _shape(leaf: Any) -> tuple[tuple[int, ...], str, bool] | None:
    if isinstance(leaf, jax.core.Tracer) or not isinstance(
        leaf, np.ndarray | np.generic | jax.Array
    ):
        return None
    return leaf.shape, leaf.dtype.str, bool(getattr(leaf, "weak_type", False))


def _flattened(result: Any) -> tuple[list[Any], list[PyTreeDef]]:
    leaves, tree = jax.tree.flatten(result)
    return leaves, [tree]


def _calling(compiled: Any, tree: PyTreeDef) -> Call:
    return lambda *leaves: jax.tree.unflatten(tree, compiled(*leaves))


def _compiled(lowered: Any, program: Program) -> Any:
    """A program, compiled and stored."""
    from jax.experimental.serialize_executable import serialize

    with not_by_jax() as parts:
        compiled = lowered.compile()
    if not parts:  # what JAX has read itself lacks some functions when it is written again
        with suppress(Exception):  # what cannot be stored is compiled in every run
            keep(program_folder(), program.key, zlib.compress(serialize(compiled)[0], 1))
            _programs.note(program, compiled=True)
    return compiled


def _loaded(key: str, tree: PyTreeDef, given: int) -> Call:
    """The program under a key, of so many leaves, with the structure of its result.

    Raises:
        Exception: of any kind, where it is missing or of no use.
    """
    return _calling(_programs.loaded(Program(key, given, tree.num_leaves)), tree)


@contextmanager
def as_last_time(*things: Any) -> Iterator[None]:
    """Load meanwhile, in another thread, the programs that the last run of the same name took.

    Args:
        things: its name, and what its programs may follow from: plain data.
    """
    key = key_of("last time", *things) if in_use() else None
    if key is None:
        yield
        return
    known = kept(program_folder(), key)
    with _programs.ahead([Program(*one) for one in json.loads(known or b"[]")]):
        yield
    taken = json.dumps(list(_programs.taken)).encode()
    if _programs.taken and taken != known:  # a run that is only planned takes none
        keep_alone(program_folder(), key, taken)
