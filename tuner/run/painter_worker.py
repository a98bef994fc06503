"""The other end of :mod:`tuner.run.painter`: it imports what draws, and nothing that computes."""

import pickle
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import IO

from tuner.run.drawing import picture
from tuner.run.figure import Figure

_PACKAGES = ("matplotlib.figure", "matplotlib.backends.backend_agg")
_LENGTH = 8
"""Bytes that tell the length of what follows."""


def import_drawing() -> None:
    """Import what draws pictures; what is not installed is missed where something is drawn."""
    for name in _PACKAGES:
        with suppress(Exception):
            import_module(name)


def serve(asked: IO[bytes], answers: IO[bytes], draw: Callable[[Figure], bytes] = picture) -> None:
    """Draw figures one after another until there are no more; nothing of one that fails.

    Args:
        asked: figures, as :func:`write` writes them.
        answers: where pictures are written to.
        draw: draws one.
    """
    import_drawing()
    with suppress(EOFError):
        while True:
            figure = pickle.loads(read(asked))
            try:
                made = draw(figure)
            except Exception:
                made = b""
            write(answers, made)


def write(stream: IO[bytes], data: bytes) -> None:
    """Write bytes with their length before them."""
    stream.write(len(data).to_bytes(_LENGTH, "big") + data)
    stream.flush()


def read(stream: IO[bytes]) -> bytes:
    """The bytes that :func:`write` wrote.

    Raises:
        EOFError: where there are no more, or not all of them.

    >>> from io import BytesIO
    >>> pipe = BytesIO()
    >>> write(pipe, b"a picture")
    >>> read(BytesIO(pipe.getvalue()))
    b'a picture'
    """
    head = stream.read(_LENGTH)
    length = int.from_bytes(head, "big")
    data = stream.read(length)
    if len(head) < _LENGTH or len(data) < length:
        raise EOFError
    return data
