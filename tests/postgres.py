"""A private PostgreSQL server for tests; skipped with a message where there is none."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from benchmarks import postgres


@contextmanager
def server() -> Iterator[str]:
    """Start a server and yield its URL."""
    try:
        with postgres.server() as url:
            yield url
    except postgres.NoServerError as error:
        pytest.skip(str(error))
