"""Solvers whose work is shared by a database with other processes."""

import hashlib
import time
from collections.abc import Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from tuner.certificate.solution import Solution
from tuner.code_version import code_version
from tuner.problem.problem import Problem
from tuner.run.progress_file import check_solution
from tuner.run.result import SolutionRecord
from tuner.run.study import Plan
from tuner.solvers.solver import Solver
from tuner.solvers.starts import SharedStarts
from tuner.trials.database import DatabaseError, as_database_error
from tuner.trials.search import POLL, opened

if TYPE_CHECKING:
    import optuna

_TASK, _SOLUTION, _REFUSED = "task", "solution", "refused"


def shared(solver: Any, url: str) -> Any:
    """A solver whose descents are shared, where it makes several."""
    given: Any = replace  # of a dataclass, which a solver is
    if not is_dataclass(solver):
        return solver
    names = {each.name for each in fields(solver)}
    if "solver" in names:
        return given(solver, solver=shared(inner(solver), url))
    if "shared" in names and getattr(solver, "starts", 1) > 1:
        return given(solver, shared=SharedStarts(url, repr(solver)))
    return solver


def shared_plan(plan: Plan, url: str) -> Plan:
    """The same plan, whose searches are shared."""
    tasks = tuple(replace(task, solver=shared(task.solver, url)) for task in plan.tasks)
    return replace(plan, tasks=tasks, case=plan.share(plan.case, url))


def inner(solver: Any) -> Any:
    """The solver that another one wraps."""
    return getattr(solver, "solver", solver)


def help_with(problem: Any, solver: Any) -> None:
    """Make trials or descents of a problem that nobody has begun."""
    own = inner(solver)
    if hasattr(own, "help"):
        own.help(problem)


@dataclass(frozen=True)
class OneForAll:
    """A solver that all processes call with the same problem: all descend, and one concludes.

    Every process has the very same solution, to the bit, which one has concluded.

    Attributes:
        solver: what solves.
        url: of the database.
    """

    solver: Solver
    url: str

    @property
    def name(self) -> str:
        """As people call it."""
        return self.solver.name

    def __call__(self, problem: Problem) -> Solution:
        """The solution, found here or elsewhere.

        Raises:
            ValueError: where it was refused, here or elsewhere, or is none of the problem.
            DatabaseError: where the database is lost.
        """
        help_with(problem, self.solver)
        tasks = [(problem, self.solver)]
        with parts(self.url, self._name(problem), {"problem": problem.name}, len(tasks)) as trials:
            while not (found := trials.complete()):
                trials.look_after_the_lost()
                if not trials.make_one(partial(solved, self.url, tasks)):
                    time.sleep(POLL)
        solution = solution_of(found[0])
        check_solution(problem, solution)
        return solution

    def _name(self, problem: Problem) -> str:
        starts = b"".join(np.asarray(each, float).tobytes() for each in problem.known_starts)
        facts = f"{problem.identity()}{code_version()}{self.solver!r}".encode()
        return f"{problem.name[:80]}/one/{hashlib.sha256(facts + starts).hexdigest()[:32]}"


def parts(url: str, name: str, facts: dict[str, Any], count: int) -> Any:
    """Tasks in a database, each of which one process solves for all.

    Raises:
        DatabaseError: where the database cannot be used.
    """
    import optuna

    marks = [{_TASK: i} for i in range(count)]
    sampler = optuna.samplers.RandomSampler(seed=0)  # never asked: tasks are no draws
    return opened(url, name, count, sampler, facts, marks=marks)


def solved(url: str, tasks: Sequence[tuple[Any, Solver]], trial: "optuna.Trial") -> float:
    """Solve the task of a trial; what refuses it here would refuse it everywhere."""
    problem, solver = tasks[trial.user_attrs[_TASK]]
    try:
        solution = solver(problem)
    except DatabaseError:
        raise
    except Exception as error:
        words = str(error) if isinstance(error, ValueError) else repr(error)
        trial.set_user_attr(_REFUSED, words)
        return np.inf
    record = SolutionRecord.of(solution).model_dump(mode="json")
    with as_database_error(url):
        trial.set_user_attr(_SOLUTION, record)
    return float(solution.value) if np.isfinite(solution.value) else np.inf


def number_of(trial: "optuna.trial.FrozenTrial") -> int:
    """Which of the tasks a trial is of."""
    return int(trial.user_attrs[_TASK])


def solution_of(trial: "optuna.trial.FrozenTrial") -> Solution:
    """The solution in a finished trial.

    Raises:
        ValueError: where the task was refused.
    """
    if _REFUSED in trial.user_attrs:
        raise ValueError(trial.user_attrs[_REFUSED])
    return SolutionRecord.model_validate(trial.user_attrs[_SOLUTION]).solution()
