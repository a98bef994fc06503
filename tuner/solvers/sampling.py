"""Samplers of Optuna: CMA-ES and TPE, for objectives with thresholds or many local minima."""

import time
import warnings
from dataclasses import dataclass
from threading import Lock
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

import numpy as np

from tuner.certificate.solution import Solution
from tuner.names import unknown
from tuner.problem.problem import Problem
from tuner.solvers.conclude import conclude
from tuner.solvers.minimum import Minimum
from tuner.solvers.multistart import refuse

if TYPE_CHECKING:
    import optuna

_Name: TypeAlias = Literal["cma-es", "tpe"]
_OPENING = Lock()  # two threads that open one new database would both create its tables


@dataclass(frozen=True)
class Sampler:
    """Trials drawn by Optuna in the box of z, kept in a database, best one certified.

    Trials found in the storage under the same name count: a search that was interrupted goes on.

    Attributes:
        name: cma-es (covariance matrix adaptation) or tpe (tree-structured Parzen estimator).
        seed: where the draws come from.
        storage: database URL; "" keeps nothing.
        trials: how many trials in all.

    Raises:
        ValueError: for an unknown name, with the near ones.
    """

    name: _Name
    seed: int
    storage: str = ""
    trials: int = 150

    def __post_init__(self) -> None:
        if self.name not in get_args(_Name):
            raise unknown("sampler", self.name, get_args(_Name))

    def __call__(self, problem: Problem) -> Solution:
        """Solve a problem."""
        import optuna

        refuse(problem, self.name, self.trials, "trial")
        begun = time.perf_counter()
        study = self._study(problem)
        done = len(study.get_trials(deepcopy=False, states=(optuna.trial.TrialState.COMPLETE,)))
        if not study.trials:
            study.enqueue_trial(dict(zip(_keys(problem), problem.space.start(), strict=True)))
        study.sampler = self._sampler(done)
        study.optimize(lambda trial: self._trial(problem, trial), max(self.trials - done, 0))
        best = study.best_trial
        end = Minimum(
            z=np.array([best.params[key] for key in _keys(problem)]),
            value=float(best.value if best.value is not None else np.inf),
            evaluations=len(study.trials),
            finished=True,
            message=f"best of {len(study.trials)} trials, Optuna {optuna.__version__}",
        )
        return conclude(problem, self.name, [end], begun)

    def _study(self, problem: Problem) -> "optuna.Study":
        import optuna

        optuna.logging.set_verbosity(optuna.logging.WARNING)  # its own log off stderr
        with _OPENING:
            return optuna.create_study(
                storage=_storage(self.storage),
                study_name=f"{problem.name}/{self.name}/{self.seed}",
                load_if_exists=True,
                direction="minimize",
            )

    def _sampler(self, done: int) -> "optuna.samplers.BaseSampler":
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


def _storage(url: str) -> "optuna.storages.BaseStorage":
    """The database, or memory for ""."""
    import optuna
    from sqlalchemy.exc import SQLAlchemyError

    if not url:
        return optuna.storages.InMemoryStorage()
    try:
        with warnings.catch_warnings():  # the heartbeat is an experimental option
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            return optuna.storages.RDBStorage(url, heartbeat_interval=60)
    except (ImportError, SQLAlchemyError) as error:
        # The URL may hold a password, and so may what follows the first line.
        reason = str(error).partition("\n")[0]
        raise ValueError(f"the database of --storage cannot be used: {reason}") from None
