"""Samplers of Optuna: CMA-ES and TPE, for objectives with thresholds or many local minima."""

import time
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

import numpy as np

from tuner.certificate.solution import Solution
from tuner.code_version import code_version
from tuner.names import counted, unknown
from tuner.problem.problem import Problem
from tuner.solvers.conclude import conclude
from tuner.solvers.minimum import Minimum
from tuner.solvers.multistart import refuse
from tuner.trials.search import Trials, opened

if TYPE_CHECKING:
    import optuna

_Name: TypeAlias = Literal["cma-es", "tpe"]
SAME = 1e-6
"""Share by which a value that is scored again may differ: machines round differently."""


@dataclass(frozen=True)
class Sampler:
    """Trials drawn by Optuna in the box of z, kept in a database, best one certified.

    Trials of the very same problem, sampler, seed and code that are in the database count: a
    search that was interrupted goes on, and processes that search at once share the trials.

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
        """Solve a problem.

        Raises:
            ValueError: where the database cannot be used, or holds values that are not this
                problem's.
        """
        import optuna

        self.check(problem)
        begun = time.perf_counter()
        with self.search(problem) as trials:
            trials.work(partial(evaluated, problem))
            found = trials.complete()
        best = min(found, key=_kept)
        end = Minimum(
            z=np.array([best.params[key] for key in _keys(problem)]),
            value=_scored_again(problem, best),
            evaluations=len(found) + 1,
            finished=True,
            message=f"best of {counted(len(found), 'trial')}, Optuna {optuna.__version__}",
        )
        return conclude(problem, self.name, [end], begun)

    def help(self, problem: Problem) -> int:
        """Make those trials of a search that nobody has begun; returns how many."""
        self.check(problem)
        with self.search(problem) as trials:
            return trials.work(partial(evaluated, problem), to_the_end=False)

    def check(self, problem: Problem) -> None:
        """Refuse what cannot begin.

        Raises:
            ValueError: where no trial is asked for, nothing is free, or there are constraints.
        """
        refuse(problem, self.name, self.trials, "trial")

    def search(self, problem: Problem) -> AbstractContextManager[Trials]:
        """The trials of a problem, which any number of processes make together."""
        from tuner.trials.numbered import Numbered

        identity, code = problem.identity(), code_version()
        start = dict(zip(_keys(problem), map(float, problem.space.start()), strict=True))
        facts = {"problem": problem.name, "identity": identity, "code": code, "trials": self.trials}
        return opened(
            self.storage,
            f"{problem.name[:80]}/{self.name}/{self.seed}/{identity[:16]}{code[:16]}",
            self.trials,
            Numbered(self._sampler, self.seed),
            facts,
            first=start,
        )

    def _sampler(self, seed: int) -> "optuna.samplers.BaseSampler":
        import optuna

        if self.name == "tpe":
            return optuna.samplers.TPESampler(seed=seed, multivariate=True)
        return optuna.samplers.CmaEsSampler(
            seed=seed,
            # One parameter alone is drawn at random by default; CMA-ES needs two.
            warn_independent_sampling=False,
        )


def evaluated(problem: Problem, trial: "optuna.Trial") -> float:
    """The objective at the point of a trial."""
    low, high = problem.space.box()
    z = [trial.suggest_float(key, low[i], high[i]) for i, key in enumerate(_keys(problem))]
    return problem.value(np.array(z))


def _scored_again(problem: Problem, best: "optuna.trial.FrozenTrial") -> float:
    """The value of a trial, computed here and now.

    Raises:
        ValueError: where the database says otherwise.
    """
    kept = _kept(best)
    value = problem.value(np.array([best.params[key] for key in _keys(problem)]))
    if not np.isclose(value, kept, rtol=SAME, atol=0.0):
        raise ValueError(
            f"trial {best.number} of {problem.name} has the value {kept:.6g} in the database, and "
            f"{value:.6g} where it is scored again; the database was changed: use another"
        )
    return value


def _kept(trial: "optuna.trial.FrozenTrial") -> float:
    """The value that the database has of a trial."""
    return np.inf if trial.value is None else float(trial.value)


def _keys(problem: Problem) -> list[str]:
    return [f"z{i}" for i in range(problem.space.size)]
