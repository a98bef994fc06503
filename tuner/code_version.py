"""The version of the code: a saved search is valid only for the code that made it."""

import hashlib
import sys
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

OURS = ("filters", "objectives", "tuner", "studies")
NUMERIC = ("jax", "jaxlib", "numpy", "scipy", "optuna", "cmaes", "casadi", "cvxpy", "clarabel")
"""Distributions whose version decides what a search finds."""


@cache
def code_version() -> str:
    """The SHA-256 of our own source files and of the versions of the numerical packages.

    >>> len(code_version())
    64
    """
    root = Path(__file__).parent.parent
    digest = hashlib.sha256(repr(sorted(versions().items())).encode())
    for name in OURS:
        digest.update(sources_digest(root / name).encode())
    return digest.hexdigest()


def changed_since(moment: float) -> bool:
    """Whether any of our own source files changed after a moment, s since 1970."""
    root = Path(__file__).parent.parent
    found = (file.stat() for name in OURS for file in (root / name).rglob("*.py"))
    return any(max(each.st_mtime, each.st_ctime) > moment for each in found)


def versions() -> dict[str, str]:
    """The versions of the numerical packages, by name; "" for a missing one."""
    return {name: _version(name) for name in NUMERIC}


def code_of(module: str) -> str:
    """The SHA-256 of the source files of the package that a module is in; "" where it has none."""
    top = sys.modules.get(module.partition(".")[0])
    file = getattr(top, "__file__", None)
    if file is None:
        return ""
    path = Path(file)
    return sources_digest(path.parent if path.name == "__init__.py" else path)


def sources_digest(path: Path) -> str:
    """The SHA-256 of a Python file, or of all below a folder with their names."""
    digest = hashlib.sha256()
    for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
        name = file.relative_to(path).as_posix()
        digest.update(f"{name}\0{hashlib.sha256(file.read_bytes()).hexdigest()}\n".encode())
    return digest.hexdigest()


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""
