"""The mistakes in a document, collected and reported together."""

from collections.abc import Iterable, Mapping
from typing import Any

from tuner.model.lines import Lines, Path, shown
from tuner.names import unknown

MOST_SHOWN = 8


class Findings:
    """Errors with the entries that they concern.

    Args:
        lines: of the entries; unknown for a document without a text.
    """

    def __init__(self, lines: Lines) -> None:
        self.lines = lines
        self.found: list[tuple[int, str]] = []

    def __len__(self) -> int:
        return len(self.found)

    def add(self, path: Path, sentence: str) -> None:
        """Add an error of an entry."""
        line = self.lines.line(path)
        where = f"line {line}, {shown(path)}" if line else shown(path)
        error = (line or 0, f"{where}: {sentence}" if path else sentence)
        if error not in self.found:
            self.found.append(error)

    def keys(self, path: Path, table: Mapping[str, Any], known: Iterable[str]) -> None:
        """Add an error for each unknown key of a table."""
        for key in table:
            if key not in known:
                self.add((*path, key), str(unknown("entry", key, known)))

    def table(self, path: Path, value: Any) -> Mapping[str, Any]:
        """A table; where the value is another thing, an error is added and the table is empty."""
        if isinstance(value, Mapping):
            return value
        self.add(path, f"is {brief(value)}; give a table, as in {shown(path)} = {{ ... }}")
        return {}

    def check(self, name: str) -> None:
        """Raise the errors, if any.

        Args:
            name: of the file, or "model".

        Raises:
            ValueError: with all sentences, in the order of their lines.
        """
        if not self.found:
            return
        sentences = [sentence for _, sentence in sorted(self.found, key=lambda each: each[0])]
        if len(sentences) == 1:
            raise ValueError(f"{name}: {sentences[0]}")
        more = len(sentences) - MOST_SHOWN
        rest = f"; and {more} more" if more > 0 else ""
        raise ValueError(
            f"{len(sentences)} errors in {name}: {'; '.join(sentences[:MOST_SHOWN])}{rest}"
        )


def brief(value: Any) -> str:
    """Any value in few words."""
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    text = repr(value) if not isinstance(value, int) or abs(value) < 10**20 else "a huge number"
    return text if len(text) <= 60 else f"{text[:57]}..."
