"""The separate process of a reader: a question in JSON, an answer, then the arrays' bytes."""

import importlib
import json
import os
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from tuner.data.logs.error import LogError
from tuner.data.logs.table import Raw


def main() -> None:
    """Answer the question on stdin; a reader's own output is discarded."""
    question = json.loads(sys.stdin.buffer.read())
    nowhere = os.open(os.devnull, os.O_WRONLY)
    with os.fdopen(os.dup(1), "wb") as out:
        os.dup2(nowhere, 1)
        _bound(question["seconds"], question["bytes"], question["held"])
        answer, arrays = _answer(question)
        _write(out, answer, arrays)
    os._exit(0)  # a library's cleanup can fail on a damaged file, after the answer


def _bound(seconds: int, size: int, held: int) -> None:
    """Bound processor time and memory where the system can."""
    try:
        import resource
    except ImportError:  # not on Windows, where the parent's patience bounds the time
        return
    bounds = (
        (resource.RLIMIT_CPU, seconds),
        (resource.RLIMIT_AS, size),
        (resource.RLIMIT_DATA, held),
        (resource.RLIMIT_FSIZE, size),
        (resource.RLIMIT_CORE, 0),
    )
    for kind, bound in bounds:
        with suppress(ValueError, OSError):  # a stricter bound is there already
            resource.setrlimit(kind, (bound, bound))


def _answer(question: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Raw]]:
    try:
        reader = importlib.import_module(question["module"])
        path = Path(question["path"])
        if question["names"] is None:
            return reader.contents(path).plain(), {}
        arrays = {name: np.asarray(a) for name, a in reader.load(path, question["names"]).items()}
        if any(array.dtype.hasobject for array in arrays.values()):
            raise TypeError("it holds what is neither number nor text")
        return {"arrays": {n: [a.dtype.str, a.shape] for n, a in arrays.items()}}, arrays
    except LogError as error:
        return {"refused": str(error)}, {}
    except BaseException as error:  # any exception of another package means a damaged file here
        return {"broken": f"{type(error).__name__}: {error}" if str(error) else repr(error)}, {}


def _write(out: BinaryIO, answer: dict[str, Any], arrays: dict[str, Raw]) -> None:
    out.write(json.dumps(answer).encode() + b"\n")
    for array in arrays.values():
        out.write(np.ascontiguousarray(array).tobytes())
