"""The options that any command has, wherever they stand: --traceback and --memory SIZE."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from tuner.limits import VARIABLE, bound_process, parse_size


@dataclass(frozen=True)
class CommonOptions:
    """The options that every command takes.

    Attributes:
        rest: its other words.
        traceback: whether tracebacks are shown.
        memory: the bound on memory as it was written; None for none.
    """

    rest: list[str]
    traceback: bool = False
    memory: str | None = None

    @classmethod
    def of(cls, arguments: Sequence[str]) -> "CommonOptions":
        """Take the options out of a line; what stands behind ``--`` is none.

        >>> CommonOptions.of(["run", "--memory", "2GB", "toy", "--traceback"])
        CommonOptions(rest=['run', 'toy'], traceback=True, memory='2GB')
        """
        rest: list[str] = []
        traceback, memory = False, None
        words = iter(arguments)
        for word in words:
            if word == "--":
                rest += [word, *words]
            elif word == "--traceback":
                traceback = True
            elif word == "--memory":
                memory = next(words, "")
            elif word.startswith("--memory="):
                memory = word.removeprefix("--memory=")
            else:
                rest.append(word)
        return cls(rest, traceback, memory)

    @contextmanager
    def bounded(self, *, alone: bool) -> Iterator[None]:
        """The bound on memory holds while this lasts, here and in processes that are started.

        What is refused before it is made goes by it; what is taken unforeseen meets it, where the
        process does nothing else.

        Args:
            alone: whether it does nothing else.

        Raises:
            ValueError: for a bound that is no size, or too small to run in.
        """
        if self.memory is None:
            yield
            return
        before = os.environ.get(VARIABLE)
        size = parse_size("--memory", self.memory)
        os.environ[VARIABLE] = str(size)
        if alone:
            bound_process(size)
        try:
            yield
        finally:
            os.environ.pop(VARIABLE)
            if before is not None:
                os.environ[VARIABLE] = before
