"""tuner example: a log to try things on."""

import sys
from pathlib import Path

from tuner.atomic import write_bytes
from tuner.data.example import example


def show(kind: str, output: str | None, *, force: bool) -> None:
    """Write a simulated log to ``KIND.csv``, another file or stdout.

    Args:
        kind: one of :data:`tuner.data.example.KINDS`.
        output: the file; None is ``KIND.csv``, ``-`` is stdout.
        force: whether a file that is there is replaced.

    Raises:
        ValueError: for an unknown kind, and a file that is there.
    """
    text = example(kind)
    if output == "-":
        sys.stdout.write(text)
        return
    path = Path(output or f"{kind}.csv")
    write_bytes(path, text.encode(), overwrite=force)
    print(f"wrote {path}: {text.splitlines()[0].removeprefix('# ')}", file=sys.stderr)
