"""Tune filters by optimisation: problems, solvers, certificates, logs, exports and studies.

Public names are imported from here; what they need is loaded when they are first used. Their list
is the stub beside this file, which type checkers read too.
"""

import os.path
from functools import cache
from importlib import import_module
from importlib.util import find_spec

# Nothing else: the command line handles signals only after this file has run.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

_STUB = f"{__file__.removesuffix('.py')}.pyi"


def _listed(stub: str) -> "dict[str, tuple[str, str]]":
    """Public names, each with its module and its name there: the imports of a stub."""
    import ast

    try:
        with open(stub, encoding="utf-8") as stream:
            text = stream.read()
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


@cache
def _home() -> "dict[str, tuple[str, str]]":
    return _listed(_STUB)


def __getattr__(name: str) -> "Any":
    if name == "__all__":
        return sorted(_home())
    if name.startswith("__") or name not in _home():
        raise AttributeError(f"module 'tuner' has no attribute {name!r}")
    module, there = _home()[name]
    return getattr(import_module(module), there)


def __dir__() -> "list[str]":
    return [*globals(), *sorted(_home())]


def _check_siblings() -> None:
    """Refuse to start beside another package called filters, objectives or studies."""
    root = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
    for name in ("filters", "objectives", "studies"):
        spec = find_spec(name)
        found = None if spec is None or spec.origin is None else os.path.realpath(spec.origin)
        if found != os.path.join(root, name, "__init__.py"):
            raise ImportError(
                f"tuner needs its package {name!r} in {os.path.join(root, name)}, but Python "
                f"finds {found or 'none'}; rename that one, or start Python with -P"
            )


_check_siblings()
