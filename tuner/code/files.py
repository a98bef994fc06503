"""C files as text."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Files:
    """The text of C files.

    Attributes:
        header: constants, types and declarations.
        source: the functions.
        selftest: their test.
    """

    header: str
    source: str
    selftest: str

    @property
    def in_order(self) -> tuple[str, str, str]:
        """Header, source and self-test."""
        return self.header, self.source, self.selftest

    @property
    def whole(self) -> str:
        """Header and source as one text."""
        lines = self.source.splitlines(keepends=True)
        return self.header + "".join(line for line in lines if not line.startswith('#include "'))
