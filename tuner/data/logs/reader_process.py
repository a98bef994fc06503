"""Readers of other packages, each in a process of its own.

A damaged or hostile file can make a reader raise anything, run for hours, take all memory or end
its process by a signal. In a process with bounds of its own, each of these becomes one sentence.
"""

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any

import numpy as np

from tuner.data.logs.contents import Contents, table_of
from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw, Table
from tuner.limits import memory

_START = """import sys, os
sys.path[:] = sys.argv[1].split(os.pathsep)
from tuner.data.logs.reader_worker import main
main()"""
_SECONDS, _SECONDS_A_MIB = 60, 4
_BYTES, _BYTES_A_BYTE = 4 << 30, 32  # of addresses, which cost nothing until they are used
_HELD, _HELD_A_BYTE = 3 << 28, 32


@dataclass(frozen=True)
class Reader:
    """A reader that runs in a process of its own.

    Attributes:
        module: with the functions ``contents(path) -> Contents`` and
            ``load(path, names) -> dict`` of arrays.
        format: the format that it reads, for messages.
        package: the package that it needs.
        extra: the extra of this project that installs it.
        mend: advice for a damaged file.
    """

    module: str
    format: str
    package: str
    extra: str
    mend: str = "copy or record it again"


def open_in_process(path: Path, reader: Reader) -> Table:
    """Open a log by a reader of another package.

    Raises:
        LogError: where the package is missing, or the file is damaged; loading raises it too.
    """
    if not _there(reader.package):
        raise LogError(
            f"{path.name}: {reader.format} needs {reader.package}; "
            f"pip install 'filter-tuner[{reader.extra}]'"
        )
    answer, _ = _asked(path, reader, None)
    return table_of(path, Contents.of(answer), partial(_load, path, reader))


def _load(path: Path, reader: Reader, names: Sequence[str]) -> dict[str, Raw]:
    _, arrays = _asked(path, reader, list(names))
    return {name: arrays[name] for name in names}


def _there(package: str) -> bool:
    if sys.modules.get(package, package) is None:
        return False
    return package in sys.modules or find_spec(package) is not None


def _asked(
    path: Path, reader: Reader, names: list[str] | None
) -> tuple[dict[str, Any], dict[str, Raw]]:
    """The child's answer: a line of JSON, and the bytes of the arrays after it."""
    size = _size(path)
    seconds = _SECONDS + _SECONDS_A_MIB * (size >> 20)
    held = min(_HELD + _HELD_A_BYTE * size, memory())
    bounds = {"seconds": seconds, "bytes": _BYTES + _BYTES_A_BYTE * size, "held": held}
    question = {"module": reader.module, "path": str(path.resolve()), "names": names, **bounds}
    with TemporaryFile() as answer:  # from which arrays are read in place
        code = _answered(question, answer, 2 * seconds)
        answer.seek(0)
        line = answer.readline()
        if code is None:
            raise _damaged(path, reader, f"not read within {2 * seconds} s")
        if code or not line:
            raise _damaged(path, reader, _ended(code))
        reply = json.loads(line)
        if "refused" in reply:
            raise LogError(f"{path.name}: {reply['refused']}")
        if "broken" in reply:
            raise _damaged(path, reader, reply["broken"].replace(str(path.resolve()), path.name))
        return reply, {name: _array(answer, *how) for name, how in reply.get("arrays", {}).items()}


def _answered(question: dict[str, Any], answer: IO[bytes], seconds: int) -> int | None:
    """The exit code of the child, which answers into a file; None where it took too long."""
    search = os.pathsep.join(os.path.abspath(entry) for entry in sys.path)
    try:
        done = subprocess.run(
            [sys.executable, "-I", "-c", _START, search],
            input=json.dumps(question).encode(),
            stdout=answer,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None
    return done.returncode


def _size(path: Path) -> int:
    files = path.rglob("*") if path.is_dir() else [path]
    return sum(file.stat().st_size for file in files if file.is_file())


def _ended(code: int) -> str:
    return f"its reader was ended by signal {-code}" if code < 0 else "its reader broke off"


def _damaged(path: Path, reader: Reader, reason: str) -> LogError:
    short = " ".join(reason.split())[:160]
    return LogError(f"{path.name}: the {reader.format} file is damaged ({short}); {reader.mend}")


def _array(stream: IO[bytes], dtype: str, shape: list[int]) -> Raw:
    kind = np.dtype(dtype)
    count = int(np.prod(shape, dtype=np.int64))
    return np.fromfile(stream, kind, count).reshape(shape)
