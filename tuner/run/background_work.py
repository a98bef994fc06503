"""Compiling and importing what a fit needs later, while it is planned and solved."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from typing import Any

import jax
import numpy as np

from tuner.certificate.single_precision import halved
from tuner.problem.problem import Problem
from tuner.problem.programs import run_filter
from tuner.problem.samples import numbers
from tuner.run.threads import at_once

LONG_RECORD = 1_000_000
"""Samples from which a trial run takes longer than compiling."""
REPORT_PACKAGES = ("contourpy", "jinja2")
"""Modules that write reports."""


@contextmanager
def in_background(work: Callable[[], None]) -> Iterator[None]:
    """Do something in another thread, which is waited for in the end.

    >>> done = []
    >>> with in_background(lambda: done.append("compiled")):
    ...     pass
    >>> done
    ['compiled']
    """
    with at_once(1) as pool:
        pool.submit(work)
        yield


def compile_ahead(problem: Problem) -> None:
    """Compile what a search and what follows it run, at the start of the search.

    XLA compiles without the interpreter's lock. What fails here fails again where it is needed,
    and is told there.
    """
    if not _is_short(problem):
        return
    z = problem.space.start()
    for trial in (
        lambda: problem.by_xla(z),
        lambda: numbers(problem, z),
        lambda: run_filter(
            problem.filter, *halved((problem.made(problem.parameters(z)), problem.data.inputs))
        ),
    ):
        with suppress(Exception):
            trial()


def differentiate(problem: Any) -> None:
    """Compile a problem's gradient, which every certificate takes, where its search would begin."""
    if _is_short(problem):
        with suppress(Exception):
            problem.by_xla(problem.space.start())


def compile_checks(problem: Problem) -> None:
    """Compile what tries a tuned filter in single precision, by trying it where a search begins."""
    if not _is_short(problem):
        return
    with suppress(Exception):
        params = problem.made(problem.parameters(problem.space.start()))
        what = problem.what_is_exported()
        for filter, *given in what.tried(problem.filter, params, problem.data.inputs).values():
            run_filter(filter, *given)
            run_filter(filter, *halved(tuple(given)))


def of_each_program(problems: Iterable[Any]) -> list[Problem]:
    """One problem of those that share a gradient's program, in order; convex ones have none."""
    found: dict[Any, Problem] = {}
    for problem in problems:
        if isinstance(problem, Problem):
            leaves, tree = jax.tree.flatten(problem.data)
            shapes = tuple((np.shape(leaf), np.asarray(leaf).dtype) for leaf in leaves)
            own = problem.scored if problem.gradients is None else problem.gradients
            found.setdefault((own, problem.objective, problem.way, shapes, tree), problem)
    return list(found.values())


def _is_short(problem: Problem) -> bool:
    """Whether there is something to compile, and a trial run takes less time than that."""
    leaves = jax.tree.leaves(problem.data.inputs)
    return bool(problem.space.size and leaves and len(leaves[0]) <= LONG_RECORD)


def import_report_packages() -> None:
    """Import what the end of a run takes; what is not installed is missed there."""
    for name in REPORT_PACKAGES:
        with suppress(Exception):
            import_module(name)
