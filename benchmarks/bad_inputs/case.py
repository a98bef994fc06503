"""One case: files, and a command line that reads them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Case:
    """A command line in a folder of its own.

    Attributes:
        kind: the kind of bad input.
        words: the command line.
        files: files of the folder, by name.
        special: names of special entries: "fifo", "folder", "loop", "device" or "locked".
    """

    kind: str
    words: Sequence[str]
    files: Mapping[str, bytes] = field(default_factory=dict)
    special: Mapping[str, str] = field(default_factory=dict)

    def lay(self, folder: Path) -> None:
        """Make the files."""
        for name, data in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
        for name, kind in self.special.items():
            _SPECIAL[kind](folder / name)


def _fifo(path: Path) -> None:
    import os

    os.mkfifo(path)


def _locked(path: Path) -> None:
    path.write_text("t,gx\n0,1\n")
    path.chmod(0)


_SPECIAL = {
    "fifo": _fifo,
    "folder": Path.mkdir,
    "loop": lambda path: path.symlink_to(path.name),
    "device": lambda path: path.symlink_to("/dev/zero"),
    "locked": _locked,
}
