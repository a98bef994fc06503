"""The paper's method: Octave's fminsearch on the cost, timed per evaluation."""

import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.baseline import Weights
from benchmarks.work import DT, Q, R

SCRIPT = Path(__file__).with_name("kownacki.m")
_PATIENCE = 120  # s


@dataclass(frozen=True)
class Search:
    """A finished search.

    Attributes:
        cost: at the start.
        seconds: one evaluation took.
        evaluations: were made.
    """

    cost: float
    seconds: float
    evaluations: int


def search(z: np.ndarray, weights: Weights, most: int) -> Search | None:
    """Run fminsearch from (R, Q) with a limit of evaluations; None where Octave is missing."""
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        np.savetxt(Path(folder) / "data.txt", np.column_stack([z, *weights.arrays]), fmt="%.17g")
        np.savetxt(Path(folder) / "start.txt", [[R, Q, DT, most]], fmt="%.17g")
        code = f'FOLDER = "{Path(folder).as_posix()}"; source("{SCRIPT.as_posix()}");'
        command = [octave, "--no-init-file", "--no-gui", "--quiet", "--eval", code]
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_PATIENCE, check=True
        )
    cost, seconds, evaluations = done.stdout.split()[-3:]
    return Search(float(cost), float(seconds) / int(evaluations), int(evaluations))
