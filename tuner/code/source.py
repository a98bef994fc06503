"""The assignment in the source whose whole value an operation is: for names and comments.

JAX records where each operation was traced. Without a record there is no name.
"""

import ast
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from types import CodeType
from typing import Any, NamedTuple, TypeAlias

from tuner.syntax import parsed

Span: TypeAlias = tuple[int, int, int, int]
"""First line and column of a value, last line and column."""


class Assignment(NamedTuple):
    """An assignment.

    Attributes:
        name: of the target.
        text: the statement, on one line.
        where: the file's name and the line.
    """

    name: str
    text: str
    where: str


def assignment(source: Any) -> Assignment | None:
    """The assignment whose whole value an operation is, from the innermost call outwards.

    Args:
        source: JAX's record of the operation.
    """
    for file, span in _frames(getattr(source, "traceback", None)):
        found = _assigned(file).get(span)
        if found is None:
            return None
        if found.name:
            return found
    return None


def _frames(traceback: Any) -> Iterator[tuple[str, Span]]:
    """The calls outside of JAX, innermost first."""
    try:
        codes, at = traceback.raw_frames()
    except AttributeError:
        return
    for code, instruction in zip(codes, at, strict=True):
        if code.co_filename.startswith(_libraries()):
            continue
        span = _span(code, instruction // 2)
        if span is not None:
            yield code.co_filename, span


@cache
def _span(code: CodeType, at: int) -> Span | None:
    """Where in its file an instruction is written; None where that is unknown."""
    first, last, left, right = next(islice(code.co_positions(), at, None))
    if first is None or last is None or left is None or right is None:
        return None
    return first, left, last, right


@cache
def _libraries() -> tuple[str, ...]:
    specs = [find_spec(name) for name in ("jax", "jaxlib", "numpy")]
    return tuple(str(Path(spec.origin).parent) for spec in specs if spec and spec.origin)


@cache
def _assigned(file: str) -> dict[Span, Assignment]:
    """Names that a file assigns, by the position of the value; no name for returned values."""
    try:
        text = Path(file).read_text("utf-8")
        tree = parsed(text)
    except (OSError, SyntaxError, ValueError):
        return {}
    lines = text.encode().splitlines()
    found: dict[Span, Assignment] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Return | ast.Assign | ast.AnnAssign):
            whole = " ".join(_segment(lines, node).split())
            for target, value in _pairs(node):
                ends = value.end_lineno or 0, value.end_col_offset or 0
                place = Assignment(target, whole, f"{Path(file).name}:{node.lineno}")
                found[(value.lineno, value.col_offset, *ends)] = place
    return found


def _segment(lines: list[bytes], node: ast.stmt) -> str:
    """The text of a statement; the standard library splits the whole file for each."""
    last = (node.end_lineno or node.lineno) - 1
    rows = [*lines[node.lineno - 1 : last], lines[last][: node.end_col_offset]]
    rows[0] = rows[0][node.col_offset :]  # columns are counted in bytes
    return b"\n".join(rows).decode()


def _pairs(node: ast.Return | ast.Assign | ast.AnnAssign) -> Iterator[tuple[str, ast.expr]]:
    """Names with the values that a statement gives them."""
    if node.value is None:
        return
    if isinstance(node, ast.Return):
        yield "", node.value
        return
    target = node.targets[0] if isinstance(node, ast.Assign) else node.target
    pairs: list[tuple[ast.expr, ast.expr]] = [(target, node.value)]
    if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
        pairs = list(zip(target.elts, node.value.elts, strict=False))
    for one, value in pairs:
        if isinstance(one, ast.Name):
            yield one.id, value
