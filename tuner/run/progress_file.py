"""The finished part of a run: ``progress.json``, written at every solution."""

import contextlib
from collections.abc import Iterator, Mapping
from typing import Any, Literal

import numpy as np
from pydantic import Field, ValidationError

from tuner.certificate.solution import Solution
from tuner.problem.problem import Problem
from tuner.run.fit_record import Recorded
from tuner.run.identity import differences
from tuner.run.result import SolutionRecord
from tuner.run.study import Solutions, Task

SCORE_TOLERANCE = 1e-4
"""Share by which a solution that is scored again may differ from what was written."""


SCHEMA: Literal["tuner.progress/1"] = "tuner.progress/1"


class Finished(Recorded):
    """A solution, and the identity of the problem that it solves; "" of a convex program."""

    identity: str
    solution: SolutionRecord


class ProgressFile(Recorded):
    """The finished part of a run.

    Attributes:
        schema_: of this file.
        identity: of the run; see :mod:`tuner.run.identity`.
        finished: the solutions.
    """

    schema_: Literal["tuner.progress/1"] = Field(alias="schema")
    identity: dict[str, str]
    finished: list[Finished]

    def to_json(self) -> str:
        """JSON text."""
        return self.model_dump_json(by_alias=True) + "\n"


def read_progress(data: bytes) -> ProgressFile:
    """The finished part of a run.

    Raises:
        ValueError: where it is no progress.json.
    """
    try:
        return ProgressFile.model_validate_json(data)
    except ValidationError:
        raise ValueError("progress.json is not that of a run; start again with --force") from None


def resumed_solutions(
    progress: ProgressFile, identity: Mapping[str, str], tasks: tuple[Task, ...]
) -> Solutions:
    """The solutions of an interrupted run that its tasks need not find again.

    Each is scored again: it counts where it solves the very problem of its name.

    Args:
        progress: of the interrupted run.
        identity: of the run that goes on.
        tasks: of the run that goes on.

    Raises:
        ValueError: where settings, data, code or a problem are not those of the interrupted run.
    """
    if changed := differences(identity, progress.identity):
        raise ValueError(
            f"--resume: there are {', '.join(changed)} than in the interrupted run; restore them, "
            "or start again with --force or in another folder"
        )
    known = {task_key(task): task.problem for task in tasks}
    found = {}
    for each in progress.finished:
        solution = _solution(each.solution)
        key = solution.problem, solution.solver
        if key in known:
            check_solution(known[key], solution, each.identity)
            found[key] = solution
    return found


def check_solution(problem: Any, solution: Solution, identity: str | None = None) -> None:
    """Refuse a solution that is none of a problem; convex programs are proved by their duals.

    Args:
        problem: what it should solve.
        solution: found before, or by another process.
        identity: of the problem that it solves, where that is known.

    Raises:
        ValueError: where the problem is another one, or its value at the solution.
    """
    if not isinstance(problem, Problem):
        return
    values = _values(problem, solution)
    same = any(
        np.isclose(value, solution.value, rtol=SCORE_TOLERANCE, atol=0.0) for value in values
    )
    if not same or identity not in (None, problem.identity()):
        raise ValueError(
            f"{solution.problem} is not the problem that {solution.solver} solved before: its data "
            "or what it computes has changed; start again with --force or in another folder"
        )


def _values(problem: Problem, solution: Solution) -> Iterator[float]:
    """The value of a solution, at its point; and of its parameters, where a search went beyond."""
    if solution.z.shape == (problem.space.size,):
        yield problem.value(solution.z)
    with contextlib.suppress(ValueError):
        yield problem.score({name: each.value for name, each in solution.parameters.items()})


def task_key(task: Task) -> tuple[str, str]:
    """By which the solution of a task is known."""
    return task.problem.name, task.solver.name


def problem_identity(task: Task) -> str:
    """The identity of a task's problem; "" of a convex program, which its data make."""
    return task.problem.identity() if isinstance(task.problem, Problem) else ""


def _solution(record: SolutionRecord) -> Solution:
    try:
        return record.solution()
    except (TypeError, KeyError, AttributeError):
        raise ValueError("progress.json is not that of a run; start again with --force") from None
