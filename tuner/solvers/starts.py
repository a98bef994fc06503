"""Descents from several starts, made by any number of processes on any number of machines."""

import hashlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from tuner.code_version import code_version
from tuner.problem.problem import Problem
from tuner.solvers.blas import blas_on_one_thread
from tuner.solvers.minimum import Descent, Minimum
from tuner.trials.search import Trials, opened

if TYPE_CHECKING:
    import optuna

REDRAWN = 20
"""So many starts that lead to no number are drawn again."""
_START, _END = "start", "end"


@dataclass(frozen=True)
class SharedStarts:
    """Where the descents of a search are kept, and shared with others.

    Attributes:
        url: of the database.
        solver: the method with all its options, as text.
    """

    url: str
    solver: str

    def help(self, problem: Problem, descend: Descent, count: int, seed: int) -> int:
        """Make the descents that nobody has begun, and return how many."""
        points = problem.starts(count + REDRAWN, seed)
        with blas_on_one_thread(), self._opened(problem, points, count) as trials:
            make = partial(_made, problem, descend, points)
            return trials.work(make, to_the_end=False)

    def ends(self, problem: Problem, descend: Descent, count: int, seed: int) -> Iterator[Minimum]:
        """Where the descents end, in the order of their starts, as many as are asked for."""
        points, known = problem.starts(count + REDRAWN, seed), dict[int, Minimum]()
        for i in range(len(points)):
            if i not in known:
                total = max(count, i + 1)
                with self._opened(problem, points, total) as trials:
                    if not any(t.user_attrs.get(_START) == i for t in trials.known()):
                        trials.add({_START: i})
                    trials.work(partial(_made, problem, descend, points))
                    known = dict(map(_read, trials.complete()))
            yield known[i]

    @contextmanager
    def _opened(self, problem: Problem, points: np.ndarray, total: int) -> Iterator[Trials]:
        import optuna

        digest = hashlib.sha256(
            f"{problem.identity()}{code_version()}{self.solver}".encode() + points.tobytes()
        )
        name = f"{problem.name[:80]}/starts/{digest.hexdigest()[:32]}"
        marks = [{_START: i} for i in range(total)]
        facts = {"problem": problem.name, "solver": self.solver}
        sampler = optuna.samplers.RandomSampler(seed=0)  # never asked: starts are no draws
        with opened(self.url, name, total, sampler, facts, marks=marks) as trials:
            yield trials


def _made(problem: Problem, descend: Descent, points: np.ndarray, trial: "optuna.Trial") -> float:
    end = descend(problem, points[trial.user_attrs[_START]])
    kept = {
        "z": end.z.tolist(),
        "evaluations": int(end.evaluations),
        "finished": bool(end.finished),
        "message": end.message,
        "excess": float(end.excess),
    }
    trial.set_user_attr(_END, kept)
    return float(end.value) if np.isfinite(end.value) else np.inf


def _read(trial: "optuna.trial.FrozenTrial") -> tuple[int, Minimum]:
    kept = trial.user_attrs[_END]
    value = np.inf if trial.value is None else float(trial.value)
    end = Minimum(
        np.array(kept["z"]),
        value,
        kept["evaluations"],
        kept["finished"],
        kept["message"],
        kept["excess"],
    )
    return trial.user_attrs[_START], end
