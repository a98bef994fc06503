"""Compiling what JAX is not to keep itself."""

import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from functools import cache
from typing import Any

from jax import monitoring

_READ = "/jax/compilation_cache/cache_hits"
_heard = threading.local()


@contextmanager
def not_by_jax() -> Iterator[list[str]]:
    """Keep JAX's own cache from writing what is compiled meanwhile; tells what it has read."""
    _listen()
    _heard.events = []
    with _never_long():
        yield _heard.events


def _never_long() -> AbstractContextManager[Any]:
    """Let JAX take each compilation of this thread for a short one, which it does not keep."""
    with suppress(ImportError):
        from jax._src.config import persistent_cache_min_compile_time_secs as least

        never: AbstractContextManager[Any] = least(float("inf"))
        return never
    return nullcontext()


@cache
def _listen() -> None:
    monitoring.register_event_listener(_hear)


def _hear(event: str, **_: Any) -> None:
    if event == _READ and hasattr(_heard, "events"):
        _heard.events.append(event)
