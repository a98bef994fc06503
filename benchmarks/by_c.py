"""Gradients by compiled C, or without it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def native(word: str) -> Iterator[None]:
    """Choose C, or exclude it."""
    before = os.environ.get("TUNER_NATIVE")
    os.environ["TUNER_NATIVE"] = word
    try:
        yield
    finally:
        if before is None:
            del os.environ["TUNER_NATIVE"]
        else:
            os.environ["TUNER_NATIVE"] = before
