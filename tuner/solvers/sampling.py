"""Samplers of Optuna: CMA-ES and TPE, for objectives with thresholds or many local minima."""

import tempfile
import time
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from tuner.problem import Problem
from tuner.solution import Solution
from tuner.solvers.multistart import Minimum, conclude

if TYPE_CHECKING:
    import optuna


@dataclass(frozen=True)
class Sampler:
    """Trials drawn by Optuna in the box of z, kept in a database, best one certified.

    Trials found in the storage under the same name count: a search that was interrupted goes on.

    Attributes:
        name: cma-es (covariance matrix adaptation) or tpe (tree-structured Parzen estimator).
        seed: where the draws come from.
        storage: database URL; "" for an SQLite file that is deleted at the end.
        trials: how many trials in all.
    """

    name: Literal["cma-es", "tpe"]
    seed: int
    storage: str = ""
    trials: int = 150

    def __call__(self, problem: Problem) -> Solution:
        """Solve a problem."""
        import optuna

        begun = time.perf_counter()
        with _quiet(), _database(self.storage) as url:
            study = self._study(problem, url)
            done = len(study.get_trials(deepcopy=False, states=(optuna.trial.TrialState.COMPLETE,)))
            if not study.trials:
                study.enqueue_trial(dict(zip(_keys(problem), problem.space.start(), strict=True)))
            study.sampler = self._sampler(problem, done)
            study.optimize(lambda trial: self._trial(problem, trial), max(self.trials - done, 0))
            best = study.best_trial
        end = Minimum(
            z=np.array([best.params[key] for key in _keys(problem)]),
            value=float(best.value if best.value is not None else np.inf),
            evaluations=len(study.trials),
            finished=True,
            message=f"best of {len(study.trials)} trials, Optuna {optuna.__version__}",
        )
        return conclude(problem, self.name, [end], time.perf_counter() - begun)

    def _study(self, problem: Problem, url: str) -> "optuna.Study":
        import optuna

        storage = optuna.storages.RDBStorage(url, heartbeat_interval=60)
        return optuna.create_study(
            storage=storage,
            study_name=f"{problem.name}/{self.name}/{self.seed}",
            load_if_exists=True,
            direction="minimize",
        )

    def _sampler(self, problem: Problem, done: int) -> "optuna.samplers.BaseSampler":
        import optuna

        seed = self.seed + done  # a resumed search must not draw the same trials again
        if self.name == "tpe":
            return optuna.samplers.TPESampler(seed=seed, multivariate=True)
        return optuna.samplers.CmaEsSampler(
            seed=seed,
            # One parameter alone is drawn at random by default; CMA-ES needs two.
            warn_independent_sampling=False,
        )

    def _trial(self, problem: Problem, trial: "optuna.Trial") -> float:
        low, high = problem.space.box()
        z = [trial.suggest_float(key, low[i], high[i]) for i, key in enumerate(_keys(problem))]
        return problem.value(np.array(z))


def _keys(problem: Problem) -> list[str]:
    return [f"z{i}" for i in range(problem.space.size)]


@contextmanager
def _database(url: str) -> Iterator[str]:
    """The database's URL, or that of a temporary one."""
    if url:
        yield url
        return
    with tempfile.TemporaryDirectory() as folder:
        yield f"sqlite:///{folder}/trials.sqlite3"


@contextmanager
def _quiet() -> Iterator[None]:
    """Optuna's own log off stderr, and its notes on experimental options too."""
    import optuna

    level = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        yield
    optuna.logging.set_verbosity(level)
