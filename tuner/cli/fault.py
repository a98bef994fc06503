"""The sentence and the exit code of an error."""

import json
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_REFUSED, _FAILED = 2, 1
_ROOT = Path(__file__).resolve().parents[2]
_OURS = tuple(f"{_ROOT / name}" for name in ("tuner", "filters", "objectives", "studies"))
_LONGEST = 300
_PYTHON = Path(json.__file__).resolve().parents[1]
_LIBRARY = {"site-packages", "dist-packages"}
_NUMBERS = {"numpy", "scipy", "jax", "jaxlib", "cvxpy", "matplotlib", "pydantic", "casadi"}
_DATABASE = ("sqlalchemy", "alembic", "optuna", "psycopg", "sqlite3")
_WAY_OUT = "--traceback shows where"


@dataclass(frozen=True)
class Fault:
    """The outcome of an error.

    Attributes:
        sentence: what was wrong, and the way out.
        code: 2 where the user can mend it, 1 where the program is at fault.
    """

    sentence: str
    code: int = _REFUSED


def fault_of(error: BaseException) -> Fault:
    """The sentence and the exit code of an error.

    >>> fault_of(ValueError("there is no column 'gx'; name another")).sentence
    "there is no column 'gx'; name another"
    >>> fault_of(KeyError("starts")).code
    1
    """
    for holds, sentence in _KINDS:
        if holds(error):
            return Fault(sentence(error))
    return Fault(
        f"{type(error).__name__}: {_words(error)}{_at(error)}; that is a fault of the program: "
        f"{_WAY_OUT}, please report it",
        _FAILED,
    )


def _words(error: BaseException) -> str:
    """The message of an error, of many lines the first one."""
    lines = [line for line in str(error).splitlines() if line.strip()]
    words = " ".join(lines[0].split()) if lines else type(error).__name__
    return words if len(words) <= _LONGEST else f"{words[:_LONGEST]} ..."


def _of(error: BaseException, packages: tuple[str, ...]) -> bool:
    return type(error).__module__.partition(".")[0] in packages


def _is_sentence(error: BaseException) -> bool:
    """Whether someone raised it for people: by a line of Python, and not one of a library's."""
    frames = traceback.extract_tb(error.__traceback__)
    if not frames or not frames[-1].line:
        return True
    place = Path(frames[-1].filename)
    standard = _PYTHON in place.parents and _LIBRARY.isdisjoint(place.parts)
    return frames[-1].line.startswith("raise") and not standard and _NUMBERS.isdisjoint(place.parts)


def _usage(error: BaseException) -> str:
    words = error.format_message().rstrip(".")  # type: ignore[attr-defined]
    command = getattr(getattr(error, "ctx", None), "command_path", "tuner")
    see = f" See {command} --help" if words.endswith("?") else f"; see {command} --help"
    return f"{words[:1].lower()}{words[1:]}{see}"


def _value(error: BaseException) -> str:
    return str(error) if _is_sentence(error) else f"{_words(error)}{_at(error)}; {_WAY_OUT}"


def _at(error: BaseException) -> str:
    """The last line of ours on the way to an error."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if frame.filename.startswith(_OURS)]
    return f", at {Path(ours[-1].filename).name} line {ours[-1].lineno}" if ours else ""


def _of_system(error: Any) -> str:
    """The system's message, with the file's name before it."""
    if error.strerror is None:
        return f"{_words(error)}; {_WAY_OUT}"
    name = "" if error.filename is None else f"{error.filename}: "
    return f"{name}{error.strerror}; check path and permissions"


_KINDS: tuple[tuple[Callable[[BaseException], bool], Callable[[BaseException], str]], ...] = (
    (lambda error: hasattr(error, "format_message"), _usage),
    (
        lambda error: isinstance(error, MemoryError) or "RESOURCE_EXHAUSTED" in str(error),
        lambda error: (
            f"there is not enough memory ({_words(error)}); take fewer samples, or a shorter time"
        ),
    ),
    (
        lambda error: isinstance(error, RecursionError),
        lambda error: f"something is nested too deep ({_words(error)}); flatten it; {_WAY_OUT}",
    ),
    (
        lambda error: isinstance(error, ArithmeticError),
        lambda error: (
            "a number is too large, too small or 0 where it must not be "
            f"({_words(error)}{_at(error)}); take values of a usual size; {_WAY_OUT}"
        ),
    ),
    (
        lambda error: _of(error, _DATABASE),
        lambda error: (
            f"the database failed ({_words(error)}); check --storage and its disk; {_WAY_OUT}"
        ),
    ),
    (
        lambda error: isinstance(error, ImportError),
        lambda error: (
            f"a package is missing or broken ({_words(error)}); install filter-tuner again"
        ),
    ),
    (lambda error: isinstance(error, OSError), _of_system),
    (lambda error: isinstance(error, ValueError), _value),
)
"""The sentence for each kind of error; the first that fits."""
