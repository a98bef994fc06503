"""One run, solved by any number of processes on any number of machines that share a database.

Each helps first with the trials of samplers and the starts of descents; then each solves whole
problems, folds and recordings as they are free; at last all search a front together, point by
point. What a process that is lost was at is begun again.
"""

import hashlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from tuner.names import unknown
from tuner.run.progress_file import task_key
from tuner.run.sharing import help_with, number_of, parts, solution_of, solved
from tuner.run.study import Plan, Solutions, Task
from tuner.trials.database import as_database_error, close, merge_log, open_storage
from tuner.trials.search import POLL, Trials

LARGEST_RECIPE = 10_000_000
"""Characters of a recipe that a database may hold."""
_RECIPE, _IDENTITY = "recipe", "identity"


@dataclass(frozen=True, eq=False)
class Together:
    """A run that several processes solve.

    Attributes:
        url: of their database.
        name: of the run in it.
        recipe: of the run, as the text of a study.toml.
        identity: of the run; see :mod:`tuner.run.identity`.
        plan: of the run, whose descents are shared; see :func:`tuner.run.sharing.shared_plan`.
    """

    url: str
    name: str
    recipe: str
    identity: Mapping[str, str]
    plan: Plan

    @property
    def tasks(self) -> tuple[Task, ...]:
        """The tasks that are solved."""
        return self.plan.tasks

    @classmethod
    def of(
        cls, url: str, study: str, recipe: bytes, identity: Mapping[str, str], plan: Plan
    ) -> "Together":
        """A run under the name that its identity gives it."""
        digest = hashlib.sha256(json.dumps([dict(identity)], sort_keys=True).encode()).hexdigest()
        return cls(url, f"{study}-{digest[:12]}", recipe.decode(), identity, plan)

    def work(self, news: Callable[[Solutions], None]) -> None:
        """Work until every task is solved and every search is over, beside whoever else does.

        Args:
            news: told of all that is solved so far, here or elsewhere.

        Raises:
            ValueError: where a task was refused, here or elsewhere.
            DatabaseError: where the database is lost.
        """
        facts = {_RECIPE: self.recipe, _IDENTITY: dict(self.identity)}
        tasks = [(task.problem, task.solver) for task in self.tasks]
        with parts(self.url, self.name, facts, len(tasks)) as trials:
            news(self._solutions(trials))
            for problem, solver in tasks:
                help_with(problem, solver)
                news(self._solutions(trials))
            while len(trials.complete()) < trials.total:
                trials.look_after_the_lost()
                if not trials.make_one(partial(solved, self.url, tasks)):
                    time.sleep(POLL)
                news(self._solutions(trials))
            news(self._solutions(trials))  # others may have solved the last
        self.plan.last(self.plan.case)

    def _solutions(self, trials: Trials) -> Solutions:
        return {task_key(self.tasks[number_of(t)]): solution_of(t) for t in trials.complete()}


def facts_of(url: str, name: str) -> tuple[str, dict[str, str]]:
    """The recipe and the identity of a run in a database.

    Raises:
        ValueError: where there is none of that name, with the near ones.
        DatabaseError: where the database cannot be used.
    """
    storage: Any = open_storage(url)
    try:
        with as_database_error(url):
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
    code = "from tuner.cli import main; main()"
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
        merge_log(url)


def _ended(process: "subprocess.Popen[bytes]") -> None:
    """Wait until a worker has given back what it was at."""
    try:
        process.wait(10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
