"""The C limit: baseline.c and tilt.c, compiled for this machine on demand."""

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from benchmarks.work import DT

SOURCES = tuple(Path(__file__).with_name(name) for name in ("baseline.c", "tilt.c"))
OPTIONS = ("-O3", "-march=native", "-shared", "-fPIC")
_LANES = 32  # costs() takes whole groups of vectors
_ARRAY = np.ctypeslib.ndpointer(dtype=np.float64, flags="C_CONTIGUOUS")
_SIGNATURES = {  # how many sizes, numbers and arrays
    "forward": (1, 3, 2),
    "two_signals": (1, 3, 2),
    "costs": (2, 1, 7),
    "gradients": (2, 1, 9),
    "tilt": (1, 3, 4),
}


class NoCompilerError(Exception):
    """The reason why there is no C limit on this machine."""


@dataclass(frozen=True)
class Baseline:
    """The compiled functions.

    Attributes:
        library: the shared library.
        compiler: its compiler, in words.
    """

    library: ctypes.CDLL
    compiler: str

    def forward(
        self, z: np.ndarray, R: float, Q: float, out: np.ndarray | None = None
    ) -> np.ndarray:
        """The output for a signal ``(N,)``, or for two side by side, ``(N, 2)``."""
        out = np.empty_like(z) if out is None else out
        call = self.library.forward if z.ndim == 1 else self.library.two_signals
        call(len(z), DT, R, Q, z, out)
        return out

    def costs(self, points: np.ndarray, z: np.ndarray, weights: "Weights") -> np.ndarray:
        """The cost at each (R, Q) of ``(m, 2)``, ``(m,)``."""
        Rs, Qs = _columns(points)
        cost = np.empty_like(Rs)
        self.library.costs(len(z), len(Rs), DT, Rs, Qs, z, *weights.arrays, cost)
        return cost[: len(points)]

    def gradients(self, points: np.ndarray, z: np.ndarray, weights: "Weights") -> np.ndarray:
        """The cost and its derivatives by ln R and ln Q, ``(3, m)``."""
        Rs, Qs = _columns(points)
        found = np.empty((3, len(Rs)))
        self.library.gradients(len(z), len(Rs), DT, Rs, Qs, z, *weights.arrays, *found)
        return found[:, : len(points)]

    def tilt(
        self,
        numbers: tuple[float, float, float],
        acceleration: np.ndarray,
        rate: np.ndarray,
        noise: np.ndarray,
        out: np.ndarray,
    ) -> np.ndarray:
        """The extended filter's angles ``(N, 2)``: sample time, delta and P0; its six numbers."""
        self.library.tilt(len(rate), *numbers, acceleration, rate, noise, out)
        return out

    @property
    def vector_bits(self) -> int:
        """The widest vector the compiler uses here."""
        return int(self.library.vector_bits())


@dataclass(frozen=True)
class Weights:
    """Truth of each sample in the cost, ``(N,)`` each: see ``objectives.StepTruth``."""

    step: np.ndarray
    lag: np.ndarray
    power: np.ndarray

    @property
    def arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The numbers in the order of the C functions."""
        return self.step, self.lag, self.power


@cache
def baseline() -> Baseline:
    """Compile and load.

    Raises:
        NoCompilerError: where there is no compiler, or it refuses.
    """
    compiler = _compiler()
    return Baseline(_signed(_compile(compiler, SOURCES, ())), _version(compiler))


def compiled(sources: Sequence[str], options: Sequence[str]) -> ctypes.CDLL:
    """Files of this folder as a library, with further options.

    Raises:
        NoCompilerError: where there is no compiler, or it refuses.
    """
    files = [Path(__file__).with_name(name) for name in sources]
    return _compile(_compiler(), files, options)


def _compiler() -> str:
    named = os.environ.get("CC")
    for name in (named, "cc", "gcc", "clang"):
        if name and (path := shutil.which(name)):
            return path
    raise NoCompilerError("no C compiler found (cc, gcc or clang; CC names another)")


def _compile(compiler: str, sources: Sequence[Path], options: Sequence[str]) -> ctypes.CDLL:
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        target = Path(folder) / "baseline.so"
        command = [compiler, *OPTIONS, *options, *map(str, sources), "-o", str(target), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise NoCompilerError(f"the C compiler refused: {done.stderr.strip().splitlines()[0]}")
        return ctypes.CDLL(str(target))


def _signed(library: ctypes.CDLL) -> ctypes.CDLL:
    for name, (sizes, numbers, arrays) in _SIGNATURES.items():
        function = getattr(library, name)
        scalars = (ctypes.c_double,) * numbers
        function.argtypes = (*(ctypes.c_size_t,) * sizes, *scalars, *(_ARRAY,) * arrays)
        function.restype = None
    return library


def _version(compiler: str) -> str:
    asked = subprocess.run([compiler, "--version"], capture_output=True, text=True, check=False)
    words = asked.stdout.splitlines()[0].split() if asked.stdout else []
    number = next((word for word in reversed(words) if word[:1].isdigit()), "")
    return f"{Path(compiler).name} {number}".strip()


def _columns(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    padded = np.vstack([points, np.repeat(points[-1:], -len(points) % _LANES, axis=0)])
    return np.ascontiguousarray(padded[:, 0]), np.ascontiguousarray(padded[:, 1])
