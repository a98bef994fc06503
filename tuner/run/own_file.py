"""A filter's class from a Python file of one's own: FILE.py:CLASS.

Only what a person names on a command line or in a program is loaded; nothing that is read as data
ever is. The file stands alone: it may import what is installed, and nothing beside it, so that its
checksum covers all of it that runs.
"""

import hashlib
import re
import sys
import traceback
from contextlib import redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from tuner.files import whole
from tuner.names import unknown

LARGEST = 10_000_000
"""Bytes of a file; none that a person wrote has more."""


@dataclass(frozen=True)
class OwnFile:
    """A class in a Python file.

    Attributes:
        path: the file.
        name: the class; "" where none was named.
    """

    path: Path
    name: str

    @property
    def reference(self) -> str:
        """As it is written into recipes and results: without a folder, for these are passed on."""
        return f"{self.path.name}:{self.name}"

    @property
    def sha256(self) -> str:
        """The file's checksum.

        Raises:
            ValueError: where it cannot be read.
        """
        return hashlib.sha256(self._read()).hexdigest()

    def load(self, sha256: str | None = None) -> type[Any]:
        """The class; a file is run once, and again where it has changed.

        Args:
            sha256: what the file has to have; None: anything.

        Raises:
            ValueError: for a file that is not there, has changed or cannot be run, and a name that
                is none of its classes.
        """
        data = self._read()
        if sha256 is not None and hashlib.sha256(data).hexdigest() != sha256:
            raise ValueError(
                f"{self.path.name} has changed: its SHA-256 differs; to run it all the "
                f"same, name it with --filter {self.path}:{self.name}"
            )
        return self._class_in(_module(self.path.resolve(), data))

    def _read(self) -> bytes:
        try:
            return whole(self.path, LARGEST, "Python file")
        except OSError as error:
            raise ValueError(f"{self.path} cannot be read: {error.strerror}") from None

    def _class_in(self, module: ModuleType) -> type[Any]:
        own = [
            name
            for name, thing in vars(module).items()
            if isinstance(thing, type) and hasattr(thing, "step")
        ]
        if not self.name:
            there = f", such as {self.path.name}:{own[-1]}" if own else "; it has no method step"
            raise ValueError(f"{self.path.name} is a file; name the filter's class in it{there}")
        if self.name not in vars(module):
            raise unknown(f"class of {self.path.name}", self.name, own)
        found = getattr(module, self.name)
        if not isinstance(found, type):
            raise ValueError(
                f"{self.name} of {self.path.name} is no class but {type(found).__name__}; "
                f"name a class{_listed(own)}"
            )
        return found


def own_file(reference: str) -> OwnFile | None:
    """The file and class that FILE.py:CLASS, or FILE.py alone, names; None for another name.

    >>> own_file("filters/robot.py:Robot"), own_file("local-level")
    (OwnFile(path=PosixPath('filters/robot.py'), name='Robot'), None)
    """
    if reference.endswith(".py"):
        return OwnFile(Path(reference), "")
    file, colon, name = reference.rpartition(":")
    return OwnFile(Path(file), name) if colon and file.endswith(".py") else None


def _listed(names: list[str]) -> str:
    return f": {', '.join(names)}" if names else ""


def _module(path: Path, data: bytes) -> ModuleType:
    """The file as a module, under a name that is nobody else's.

    Dataclasses and annotations look their module up by its name, so it has to be known by one;
    the name has no dot, so that a relative import finds no package.
    """
    digest = hashlib.sha256(str(path).encode() + b"\0" + data).hexdigest()
    name = f"{re.sub(r'[^0-9A-Za-z]', '_', path.stem)}_{digest[:16]}"
    if name in sys.modules:
        return sys.modules[name]
    module = ModuleType(name)
    module.__file__ = str(path)
    module.__package__ = ""
    sys.modules[name] = module
    try:
        with redirect_stdout(sys.stderr):  # stdout is for results
            exec(compile(data, str(path), "exec", dont_inherit=True), vars(module))
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise ValueError(_why(path, error)) from error
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _why(path: Path, error: BaseException) -> str:
    """Why a file could not be run: where, what, and the way out."""
    lines = [f.lineno for f in traceback.extract_tb(error.__traceback__) if f.filename == str(path)]
    line = error.lineno if isinstance(error, SyntaxError) else (lines or [None])[-1]
    at = "" if line is None else f" line {line}:"
    what = " ".join(f"{type(error).__name__}: {_words(error)}".split()).rstrip(": ")
    way = "mend that line" if line else "give a Python file"
    if isinstance(error, ImportError):
        way = "a filter's file is self-contained: put what it needs into it, or install that"
    elif isinstance(error, SystemExit):
        way = 'put what ends the program below if __name__ == "__main__"'
    return f"{path.name} cannot be loaded:{at} {what}; {way}"


def _words(error: BaseException) -> str:
    return error.msg if isinstance(error, SyntaxError) else str(error)
