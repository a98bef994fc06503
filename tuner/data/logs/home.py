"""A folder for unpacked files that lasts as long as it is needed."""

import shutil
import weakref
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

_OPEN: "weakref.WeakSet[Home]" = weakref.WeakSet()  # for a process that ends without finalizers


class Home:
    """A new folder that is removed with the last reference to this object.

    Attributes:
        path: the folder.
    """

    def __init__(self) -> None:
        self.path = Path(mkdtemp(prefix="tuner-"))
        self.remove: Any = weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)
        _OPEN.add(self)


def remove_all() -> None:
    """Remove all of them, at the very end."""
    for home in list(_OPEN):
        home.remove()
