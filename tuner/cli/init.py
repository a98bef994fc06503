"""tuner init: a commented model to begin with."""

import sys
from pathlib import Path

from tuner.atomic import write_bytes
from tuner.model.template import template


def show(kind: str, output: str | None, *, force: bool) -> None:
    """Print a model, or write it to a file.

    Args:
        kind: one of :data:`tuner.model.template.KINDS`.
        output: the file; None or ``-`` is stdout.
        force: whether a file that is there is replaced.

    Raises:
        ValueError: for an unknown kind, and a file that is there.
    """
    text = template(kind)
    if output in (None, "-"):
        sys.stdout.write(text)
        return
    path = Path(str(output))
    write_bytes(path, text.encode(), overwrite=force)
    print(
        f"wrote {path}; change it to your model, then tuner fit LOG --model {path} --map ...",
        file=sys.stderr,
    )
