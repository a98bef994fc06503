"""Tune filters by optimisation: problems, solvers, certificates, logs, exports and studies.

Public names are imported from here; what they need is loaded when they are first used. Their list
is the stub beside this file, which type checkers read too.
"""

import ast
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any


def _listed(stub: Path) -> dict[str, tuple[str, str]]:
    """Public names, each with its module and what it is called there: the imports of a stub."""
    try:
        text = stub.read_text(encoding="utf-8")
    except OSError as error:
        raise ImportError(
            f"{stub} is missing, the list of tuner's names; install filter-tuner again"
        ) from error
    return {
        alias.asname or alias.name: (statement.module, alias.name)
        for statement in ast.parse(text).body
        if isinstance(statement, ast.ImportFrom) and statement.module
        for alias in statement.names
    }


_HOME = _listed(Path(__file__).with_suffix(".pyi"))

__all__ = sorted(_HOME)  # noqa: PLE0605  # the names are those of the stub


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'tuner' has no attribute {name!r}")
    module, there = _HOME[name]
    return getattr(import_module(module), there)


def __dir__() -> list[str]:
    return [*globals(), *__all__]


def _check_siblings() -> None:
    """Refuse to start beside another package called filters, objectives or studies."""
    root = Path(__file__).resolve().parents[1]
    for name in ("filters", "objectives", "studies"):
        spec = find_spec(name)
        found = None if spec is None or spec.origin is None else Path(spec.origin).resolve()
        if found != root / name / "__init__.py":
            raise ImportError(
                f"tuner needs its own package {name!r} in {root / name}, but Python finds "
                f"{found or 'none'}; rename yours, or start Python with -P so that the current "
                "folder does not come first"
            )


_check_siblings()
