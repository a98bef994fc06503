"""One run, solved by any number of processes on any number of machines that share a database.

Each helps first with the trials of samplers and the starts of descents; then each solves whole
problems, folds and recordings as they are free. What a process that is lost was at is begun again.
"""

import hashlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tuner.names import unknown
from tuner.run.progress import key_of
from tuner.run.result import SolutionRecord
from tuner.run.study import Plan, Solutions, Task
from tuner.solvers.starts import SharedStarts
from tuner.trials.database import DatabaseError, close, open_storage, told
from tuner.trials.search import POLL, Trials, opened

if TYPE_CHECKING:
    import optuna

LARGEST_RECIPE = 10_000_000
"""Characters of a recipe that a database may hold."""
_TASK, _SOLUTION, _REFUSED, _RECIPE, _IDENTITY = "task", "solution", "refused", "recipe", "identity"


@dataclass(frozen=True, eq=False)
class Together:
    """A run that several processes solve.

    Attributes:
        url: of their database.
        name: of the run in it.
        recipe: of the run, as the text of a study.toml.
        identity: of the run; see :mod:`tuner.run.identity`.
        tasks: of the run, whose descents are shared.
    """

    url: str
    name: str
    recipe: str
    identity: Mapping[str, str]
    tasks: tuple[Task, ...]

    @classmethod
    def of(
        cls, url: str, study: str, recipe: bytes, identity: Mapping[str, str], plan: Plan
    ) -> "Together":
        """A run under the name that its identity gives it."""
        digest = hashlib.sha256(json.dumps([dict(identity)], sort_keys=True).encode()).hexdigest()
        tasks = tuple(replace(task, solver=_shared(task.solver, url)) for task in plan.tasks)
        return cls(url, f"{study}-{digest[:12]}", recipe.decode(), identity, tasks)

    def work(self, news: Callable[[Solutions], None]) -> None:
        """Work until every task is solved, beside whoever else does.

        Args:
            news: told of all that is solved so far, here or elsewhere.

        Raises:
            ValueError: where a task was refused, here or elsewhere.
            DatabaseError: where the database is lost.
        """
        with self._opened() as parts:
            news(self._solutions(parts))
            for task in self.tasks:
                help_with(task)
                news(self._solutions(parts))
            while len(parts.complete()) < parts.total:
                parts.look_after_the_lost()
                if not parts.make_one(self._solved):
                    time.sleep(POLL)
                news(self._solutions(parts))
            news(self._solutions(parts))  # others may have solved the last

    @contextmanager
    def _opened(self) -> Iterator[Trials]:
        import optuna

        facts = {_RECIPE: self.recipe, _IDENTITY: dict(self.identity)}
        marks = [{_TASK: i} for i in range(len(self.tasks))]
        sampler = optuna.samplers.RandomSampler(seed=0)  # never asked: tasks are no draws
        with opened(self.url, self.name, len(marks), sampler, facts, marks=marks) as parts:
            yield parts

    def _solved(self, trial: "optuna.Trial") -> float:
        """Solve a task; what refuses one would refuse it everywhere."""
        task = self.tasks[trial.user_attrs[_TASK]]
        try:
            solution = task.solver(task.problem)
        except DatabaseError:
            raise
        except Exception as error:
            words = str(error) if isinstance(error, ValueError) else repr(error)
            trial.set_user_attr(_REFUSED, words)
            return np.inf
        record = SolutionRecord.of(solution).model_dump(mode="json")
        with told(self.url):
            trial.set_user_attr(_SOLUTION, record)
        return float(solution.value) if np.isfinite(solution.value) else np.inf

    def _solutions(self, parts: Trials) -> Solutions:
        found = {}
        for trial in parts.complete():
            if _REFUSED in trial.user_attrs:
                raise ValueError(trial.user_attrs[_REFUSED])
            task = self.tasks[trial.user_attrs[_TASK]]
            record = SolutionRecord.model_validate(trial.user_attrs[_SOLUTION])
            found[key_of(task)] = record.solution()
        return found


def help_with(task: Task) -> None:
    """Make trials or descents of a task that nobody has begun."""
    solver: Any = _inner(task.solver)
    if hasattr(solver, "help"):
        solver.help(task.problem)


def facts_of(url: str, name: str) -> tuple[str, dict[str, str]]:
    """The recipe and the identity of a run in a database.

    Raises:
        ValueError: where there is none of that name, with the near ones.
        DatabaseError: where the database cannot be used.
    """
    storage: Any = open_storage(url)
    try:
        with told(url):
            known = {study.study_name: study.user_attrs for study in storage.get_all_studies()}
    finally:
        close(storage)
    runs = {each: attrs for each, attrs in known.items() if _RECIPE in attrs}
    if name not in runs:
        raise unknown("run", name, runs)
    return str(runs[name][_RECIPE])[:LARGEST_RECIPE], dict(runs[name][_IDENTITY])


@contextmanager
def workers(count: int, url: str, name: str, words: Sequence[str]) -> Iterator[None]:
    """So many processes more that work on a run; they end with this one.

    Args:
        count: how many.
        url: of the database, which no list of processes shows.
        name: of the run.
        words: options that say where logs and a filter's file are.
    """
    import tuner

    root = str(Path(tuner.__file__).parent.parent)
    path = os.pathsep.join([root, *filter(None, [os.environ.get("PYTHONPATH")])])
    code = "import sys; from tuner.cli import invoke; sys.exit(invoke(sys.argv[1:]))"
    command = [sys.executable, "-P", "-c", code, "worker", "--study", name, "--leashed", *words]
    started = [
        subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            env={**os.environ, "TUNER_STORAGE": url, "PYTHONPATH": path},
            start_new_session=True,  # a Ctrl-C is this process's to pass on
        )
        for _ in range(count)
    ]
    try:
        yield
    finally:
        for each in started:
            if each.stdin is not None:
                each.stdin.close()  # the leash
        for each in started:
            _ended(each)


def _ended(process: "subprocess.Popen[bytes]") -> None:
    """Wait until a worker has given back what it was at."""
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _inner(solver: Any) -> Any:
    """The solver that another one wraps."""
    return getattr(solver, "solver", solver)


def _shared(solver: Any, url: str) -> Any:
    """A solver whose descents are shared, where it makes several."""
    given: Any = replace  # of a dataclass, which a solver is
    if not is_dataclass(solver):
        return solver
    names = {each.name for each in fields(solver)}
    if "solver" in names:
        return given(solver, solver=_shared(_inner(solver), url))
    if "shared" in names and getattr(solver, "starts", 1) > 1:
        return given(solver, shared=SharedStarts(url, repr(solver)))
    return solver
