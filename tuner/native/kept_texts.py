"""Texts of a problem's C, kept between runs under what they follow from."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeAlias

from tuner.code.graph import TooLargeError
from tuner.code.refused import NoCounterpartError
from tuner.stored_programs import stored_text

Kept: TypeAlias = Callable[[Callable[[], Any]], Any]
"""What a function makes, or what it made in an earlier run."""
_REFUSED = {error.__name__: error for error in (NoCounterpartError, TooLargeError)}


@dataclass(frozen=True)
class KeptTexts:
    """The texts of one problem.

    Attributes:
        things: what they follow from; texts of what is no plain data are made in every run.
    """

    things: tuple[Any, ...] | None = None

    def of(self, name: str, make: Callable[[], Any]) -> Any:
        """What a function makes, JSON-able; a refusal is kept as well.

        Raises:
            NoCounterpartError, TooLargeError: as the function did.
        """
        if self.things is None:
            return make()
        found = json.loads(stored_text(lambda: _written(make), "C", name, self.things))
        if "refused" in found:
            raise _REFUSED[found["refused"]](found["why"])
        return found["made"]

    def __call__(self, name: str) -> Kept:
        """The same of a text that is made later."""
        return partial(self.of, name)


UNKEPT = KeptTexts()
"""Texts that are made in every run."""


def _written(make: Callable[[], Any]) -> str:
    try:
        return json.dumps({"made": make()})
    except (NoCounterpartError, TooLargeError) as error:
        return json.dumps({"refused": type(error).__name__, "why": str(error)})


def at_once(make: Callable[[], Any]) -> Any:
    """What a function makes, which nobody keeps."""
    return make()
