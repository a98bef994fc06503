"""The size of compiled code, by the installed compiler."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import NamedTuple

from tuner.compiler import supported

_QUICKLY = ("--param=sccvn-max-alias-queries-per-access=50",)
"""Half the time for the longest files; a few become smaller, by one or two hundredths."""


class Size(NamedTuple):
    """The size of a source file compiled for size on this machine.

    Attributes:
        code: bytes of code and constants.
        stack: bytes of stack that its largest function takes.
    """

    code: int
    stack: int


def size(header: str, source: str, include: str) -> Size | None:
    """Code size and stack of a compiled source file; None where no compiler tells them.

    Args:
        header: text of the header.
        source: text of the source.
        include: name of the header's file.
    """
    compiler, counter = shutil.which("cc"), shutil.which("size")
    if compiler is None or counter is None:
        return None
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / include).write_text(header, "ascii")
        (folder / "code.c").write_text(source, "ascii")
        options = "-std=c99", "-Os", "-fstack-usage", *supported((compiler,), _QUICKLY)
        command = [compiler, *options, "-c", "code.c", "-o", "code.o"]
        try:
            subprocess.run(command, cwd=folder, capture_output=True, check=True, timeout=60)
            counted = subprocess.run(
                [counter, "code.o"], cwd=folder, capture_output=True, check=True, timeout=60
            )
            stack = (folder / "code.su").read_text()
        except (OSError, subprocess.SubprocessError):
            return None
        sizes = re.findall(r"^\s*(\d+)\s+\d+\s+\d+\s", counted.stdout.decode(), re.MULTILINE)
        stacks = re.findall(r"\t(\d+)\t", stack)
        return Size(int(sizes[0]), max(map(int, stacks))) if sizes and stacks else None
