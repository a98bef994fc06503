"""A folder for what is unpacked, as long as someone needs it."""

import shutil
import weakref
from pathlib import Path
from tempfile import mkdtemp


class Home:
    """A new folder that is removed when the last one who holds this object is gone.

    Attributes:
        path: the folder.
    """

    def __init__(self) -> None:
        self.path = Path(mkdtemp(prefix="tuner-"))
        weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)
