"""Line numbers of the entries of a TOML text, for error messages."""

import re
from dataclasses import dataclass, field
from typing import TypeAlias

Path: TypeAlias = tuple[str | int, ...]
_KEY = re.compile(r"""\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*=""")
_HEADER = re.compile(r"\s*\[\s*([^\[\]]+?)\s*\]\s*(?:#.*)?$")
_QUIET = re.compile(r""""(?:\\.|[^"\\])*"|'[^']*'|\#.*""")


@dataclass(frozen=True)
class Lines:
    """The line of each key, and of each element of an array over several lines."""

    at: dict[Path, int] = field(default_factory=dict)

    @classmethod
    def of(cls, text: str) -> "Lines":
        """The lines of a text that is valid TOML.

        >>> lines = Lines.of('[model]\\nA = [\\n [1, 0],\\n [0, 1],\\n]')
        >>> lines.line(("model", "A", 1)), lines.line(("model", "A", 0, 1))
        (4, 3)
        """
        found: dict[Path, int] = {}
        table: Path = ()
        walk: _Array | None = None
        for number, line in enumerate(text.split("\n"), 1):
            plain = _QUIET.sub(lambda m: "" if m[0][0] == "#" else "s" * len(m[0]), line)
            if walk is None and (header := _HEADER.match(line)):
                table = _split(header[1])
                found.setdefault(table, number)
                continue
            if walk is None:
                key = _KEY.match(line)
                if key is None:
                    continue
                path = table + _split(key[1])
                for end in range(len(table) + 1, len(path) + 1):
                    found.setdefault(path[:end], number)
                walk, plain = _Array(path), plain[key.end() :]
            if not walk.take(plain, number, found):
                walk = None
        return cls(found)

    def line(self, path: Path) -> int | None:
        """The line of an entry, or of the enclosing one; None where that is not known."""
        for end in range(len(path), 0, -1):
            if path[:end] in self.at:
                return self.at[path[:end]]
        return None


class _Array:
    """The elements of one array whose brackets are open."""

    def __init__(self, path: Path) -> None:
        self.path, self.depth, self.index, self.fresh = path, 0, 0, True

    def take(self, plain: str, number: int, found: dict[Path, int]) -> bool:
        """Read one line of it; whether the array continues."""
        for sign in plain:
            if self.depth == 1 and self.fresh and sign not in " \t,]":
                found.setdefault((*self.path, self.index), number)
                self.fresh = False
            if sign in "[{":
                self.depth += 1
            elif sign in "]}":
                self.depth -= 1
            elif sign == "," and self.depth == 1:
                self.index, self.fresh = self.index + 1, True
        return self.depth > 0


def _split(key: str) -> Path:
    parts = re.findall(r"""[\w-]+|"[^"]*"|'[^']*'""", key)
    return tuple(part.strip("\"'") for part in parts)


def shown(path: Path) -> str:
    """The usual notation of an entry.

    >>> shown(("model", "A", 0, 1)), shown(("parameters", "q", "low"))
    ('model.A, row 1, column 2', 'parameters.q.low')
    """
    keys = ".".join(part for part in path if isinstance(part, str))
    places = [part for part in path if isinstance(part, int)]
    if not places:
        return keys
    if len(places) == 1:
        return f"{keys}, entry {places[0] + 1}"
    return f"{keys}, row {places[0] + 1}, column {places[1] + 1}"
