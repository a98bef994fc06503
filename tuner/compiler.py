"""The system's C compiler, and the folder of compiled libraries."""

import ctypes
import os
import shlex
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Literal, NamedTuple, TypeAlias, cast

from tuner.cached import digest, own, unaltered

FLAGS = ("-std=gnu11", "-fno-math-errno", "-ffp-contract=fast", "-w", "-fPIC")
"""Compiler options, with strict arithmetic: NaN is a missing sample."""
HERE = ("-march=native",)
"""Options for this processor, where a compiler supports them."""
_ROWS = (
    "-ftree-vectorize",
    "-fvect-cost-model=dynamic",
    "-fassociative-math",
    "-fno-signed-zeros",
    "-fno-trapping-math",
)
"""Options for loops over rows of matrices, whose sums may be taken in any order."""
_SCALARS = (
    "-mtune=generic",
    "-fno-gcse",
    "-frename-registers",
    "-fno-reorder-blocks",
    "-fno-reorder-blocks-and-partition",
)
"""Options for samples of many scalars: tuned for a processor, GCC keeps real numbers in registers
of whole ones, and to move them takes longer than memory does. What is stored under a condition it
moves far from the rest, and jumps there and back a hundred times in a sample."""
_FEW_SCALARS = ("-fschedule-insns", "-fsched-pressure", "-fno-tree-slp-vectorize")
"""Further options where a sample has a few thousand of them at most."""
LONG = 4000
"""Lines beyond which code is optimised less, if no option tells otherwise: in two thirds of the
time, with equal speed."""
SECONDS = 30
"""Time limit of a compiler."""


def options_of_rows(length: int, *, long: bool = False) -> tuple[str, ...]:
    """Compiler options for loops over rows of matrices.

    Of vectors of 256 bits a row of nine entries would leave the third nearly empty.

    Args:
        length: of a row.
        long: whether the code has more lines than :data:`LONG`.

    >>> [options_of_rows(16, long=long)[-1] for long in (False, True)]
    ['-O3', '-O1']
    """
    wide = length == 9
    effort = "-O1" if long else "-O2" if wide else "-O3"
    return (*_ROWS, f"-mprefer-vector-width={512 if wide else 256}", effort)


def options_of_scalars(*, few: bool, in_order: bool) -> tuple[str, ...]:
    """Compiler options for samples of many scalars.

    Args:
        few: whether they are a few thousand at most.
        in_order: whether their statements are in order, which less optimisation would not keep.
    """
    return (*_SCALARS, *(_FEW_SCALARS if few else ()), *(("-O2",) if in_order else ()))


Use: TypeAlias = Literal["auto", "on", "off"]
"""C where it pays, wherever it is possible, or never."""


def use() -> Use:
    """The value of ``TUNER_NATIVE``; ``auto`` where it is not set.

    Raises:
        ValueError: for another word.
    """
    word = os.environ.get("TUNER_NATIVE") or "auto"
    if word not in ("auto", "on", "off"):
        raise ValueError(f"TUNER_NATIVE is {word!r}; set it to auto, on or off")
    return cast("Use", word)


class NoCodeError(Exception):
    """The reason why there is no compiled code."""


class Compiler(NamedTuple):
    """A compiler that works.

    Attributes:
        command: the program with its fixed arguments.
        name: its name and version, in words.
        key: of its code: the compiler, and the processor.
    """

    command: tuple[str, ...]
    name: str
    key: str


def compiler() -> Compiler:
    """The system's compiler: what ``CC`` names, with its arguments, or ``cc``.

    Raises:
        NoCodeError: where there is none, or it does not work.
    """
    wanted, *more = shlex.split(os.environ.get("CC", "")) or ["cc"]
    path = shutil.which(wanted)
    if path is None:
        raise NoCodeError(f"there is no C compiler ({wanted})")
    found = _asked((path, *more))
    if isinstance(found, NoCodeError):
        raise NoCodeError(*found.args)
    return found


@cache
def _asked(program: tuple[str, ...]) -> Compiler | NoCodeError:
    """A compiler's own description; it is asked once."""
    try:
        lines = _ran([*program, "--version"]).decode(errors="replace").splitlines()
    except NoCodeError as error:
        return error
    name = lines[0].strip() if lines else Path(program[0]).name
    refused = NoCodeError("")
    for here in (HERE, ()):
        command = (*program, *FLAGS, *here)
        try:
            macros = _ran([*command, "-dM", "-E", "-x", "c", os.devnull])
        except NoCodeError as error:
            refused = error
        else:
            return Compiler(command, name, "\0".join([*command, name, digest(macros)]))
    return refused


def _ran(command: list[str], cwd: Path | None = None) -> bytes:
    """The output of a program, which is stopped with all its children where it takes too long."""
    name, pipe = Path(command[0]).name, subprocess.PIPE
    try:
        process = subprocess.Popen(
            command,
            cwd=cwd,
            stdin=subprocess.DEVNULL,
            stdout=pipe,
            stderr=pipe,
            start_new_session=True,
        )
    except OSError as error:
        raise NoCodeError(f"{name} cannot be started: {error.strerror}") from None
    try:
        out, said = process.communicate(timeout=SECONDS)
    except subprocess.TimeoutExpired:
        raise NoCodeError(f"{name} did not end within {SECONDS} s") from None
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.communicate()
    if process.returncode != 0:
        lines = said.decode(errors="replace").split("\n")
        first = next((line for line in lines if "error" in line), lines[0]).strip()[:200]
        raise NoCodeError(f"{name} ended with status {process.returncode}: {first or 'no message'}")
    return out


def library(source: str, folder: Path, more: Sequence[str] = ()) -> ctypes.CDLL:
    """Compiled code, cached in a folder under hashes of its source and of itself.

    Loaded files were written by this user: a folder or a file that belongs to another, that others
    may write to, or that is a link, is not used, and the code is compiled for this process alone.

    Args:
        source: the code.
        folder: of compiled code.
        more: compiler options.

    Raises:
        NoCodeError: where there is no compiler that works.
    """
    found = compiler()
    more = supported(found.command, tuple(more))
    effort = ["-O1" if source.count("\n") > LONG else "-O2", *more]
    key = digest("\0".join([source, *effort, found.key]).encode())
    if own(folder):
        for kept in folder.glob(f"{key}-*.so"):
            loaded = _loaded(kept)
            if loaded is not None:
                return loaded
        try:
            loaded = _compiled((*found.command, *effort), source, folder, key)
        except OSError:  # full, or read-only
            loaded = None
        if loaded is not None:
            return loaded
    with tempfile.TemporaryDirectory() as name:
        loaded = _compiled((*found.command, *effort), source, Path(name), key)
    if loaded is None:
        raise NoCodeError(f"the library from {Path(found.command[0]).name} cannot be loaded")
    return loaded


@cache
def supported(command: tuple[str, ...], options: tuple[str, ...]) -> tuple[str, ...]:
    """Those of some options that a compiler knows.

    Args:
        command: the compiler, with its arguments.
        options: that are asked for.
    """

    def known(some: tuple[str, ...]) -> bool:
        try:
            _ran([*command, *some, "-Werror", "-fsyntax-only", "-x", "c", os.devnull])
        except NoCodeError:
            return False
        return True

    return options if known(options) else tuple(one for one in options if known((one,)))


def _compiled(command: tuple[str, ...], source: str, folder: Path, key: str) -> ctypes.CDLL | None:
    with tempfile.TemporaryDirectory(dir=folder) as name:
        inside = Path(name)
        (inside / "loop.c").write_text(source, "ascii")
        _ran([*command, "-shared", "loop.c", "-o", "loop.so", "-lm"], inside)
        made = inside / "loop.so"
        made.chmod(0o700)
        to = folder / f"{key}-{digest(made.read_bytes())}.so"
        made.replace(to)
    return _loaded(to)


def _loaded(file: Path) -> ctypes.CDLL | None:
    """A library, if it belongs to this user and matches its name."""
    if unaltered(file) is None:
        return None
    try:
        return ctypes.CDLL(str(file))
    except OSError:  # not a library
        return None
