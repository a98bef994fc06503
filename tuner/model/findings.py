"""All that is wrong with a document, collected and told at once."""

from collections.abc import Iterable, Mapping
from typing import Any

from tuner.model.lines import Lines, Path, shown
from tuner.names import unknown

MOST_TOLD = 8


class Findings:
    """Sentences with the entries that they are about.

    Args:
        lines: where entries stand; of a document without a text none is known.
    """

    def __init__(self, lines: Lines) -> None:
        self.lines = lines
        self.found: list[tuple[int, str]] = []

    def __len__(self) -> int:
        return len(self.found)

    def add(self, path: Path, sentence: str) -> None:
        """Note what is wrong with an entry."""
        line = self.lines.line(path)
        where = f"line {line}, {shown(path)}" if line else shown(path)
        told = (line or 0, f"{where}: {sentence}" if path else sentence)
        if told not in self.found:
            self.found.append(told)

    def keys(self, path: Path, table: Mapping[str, Any], known: Iterable[str]) -> None:
        """Note the keys of a table that are not known."""
        for key in table:
            if key not in known:
                self.add((*path, key), str(unknown("entry", key, known)))

    def table(self, path: Path, value: Any) -> Mapping[str, Any]:
        """A value that has to be a table; an empty one where it is not."""
        if isinstance(value, Mapping):
            return value
        self.add(path, f"is {brief(value)}; give a table, as in {shown(path)} = {{ ... }}")
        return {}

    def check(self, name: str) -> None:
        """Raise what was found.

        Args:
            name: of the file, or "model".

        Raises:
            ValueError: with all sentences, in the order of their lines.
        """
        if not self.found:
            return
        told = [sentence for _, sentence in sorted(self.found, key=lambda each: each[0])]
        if len(told) == 1:
            raise ValueError(f"{name}: {told[0]}")
        more = len(told) - MOST_TOLD
        rest = f"; and {more} more" if more > 0 else ""
        raise ValueError(f"{len(told)} errors in {name}: {'; '.join(told[:MOST_TOLD])}{rest}")


def brief(value: Any) -> str:
    """A value in few words, whatever it is."""
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    text = repr(value) if not isinstance(value, int) or abs(value) < 10**20 else "a huge number"
    return text if len(text) <= 60 else f"{text[:57]}..."
