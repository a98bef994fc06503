"""Compiling and importing what a fit needs later, while it is planned and solved."""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import partial
from importlib import import_module
from typing import Any

import jax
import numpy as np

from tuner.certificate.single_precision import halved
from tuner.problem.problem import Problem
from tuner.problem.programs import run_filter, try_filter
from tuner.problem.samples import numbers
from tuner.run.comparison import Comparison
from tuner.run.study import Claim, Plan
from tuner.run.threads import at_once
from tuner.stored_programs import anything_compiled, in_use, key_of

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
    for compile_one in (differentiate, _compile_slopes, _compile_single_precision):
        compile_one(problem)


@contextmanager
def compiled_ahead(problem: Problem) -> Iterator[None]:
    """Compile meanwhile what a fit runs, and wait for it in the end.

    Programs that are kept between runs are not waited for: whoever needs one that is being compiled
    waits for that one.
    """
    if not _is_kept(problem):
        with in_background(partial(compile_ahead, problem)):
            yield
        return
    _begin(2, [partial(compile_one, problem) for compile_one in _IN_TURN])
    yield


def begin_gradients(problems: Iterable[Any]) -> None:
    """Begin to compile the gradients that are kept between runs, one after another.

    They take longest, and every certificate takes them. Nobody waits here: whoever needs one that
    is being compiled waits for that one.
    """
    kept = [problem for problem in of_each_program(problems) if _is_kept(problem)]
    _begin(1, [partial(differentiate, problem) for problem in kept])


def compile_gradients(pool: Executor, problems: Iterable[Any]) -> None:
    """Compile the others, where their search begins."""
    for problem in of_each_program(problems):
        if not _is_kept(problem):
            pool.submit(differentiate, problem)


def begin_claims(plan: Plan) -> dict[Claim, Future[list[Comparison]]]:
    """Begin to try the claims that need no solution, one after another; nobody waits here."""
    pool = ThreadPoolExecutor(1)
    claims = [claim for claim in plan.claims if not claim.needs]
    found = {claim: pool.submit(claim.compare, plan.case, {}) for claim in claims}
    pool.shutdown(wait=False)
    return found


def _begin(threads: int, work: Iterable[Callable[[], None]]) -> None:
    """Do something in threads that are not waited for."""
    pool = ThreadPoolExecutor(threads)
    for one in work:
        pool.submit(one)
    pool.shutdown(wait=False)


def _is_kept(problem: Problem) -> bool:
    """Whether the programs of a problem are kept between runs, and compiled by one thread each."""
    return in_use() and key_of(problem.scored) is not None


def _evaluate(problem: Problem) -> None:
    if _is_short(problem):
        with suppress(Exception):
            problem.value_by_xla(problem.space.start())


def _compile_slopes(problem: Problem) -> None:
    if _is_short(problem):
        with suppress(Exception):
            numbers(problem, problem.space.start())


def _compile_single_precision(problem: Problem) -> None:
    if _is_short(problem):
        with suppress(Exception):
            params = problem.made(problem.parameters(problem.space.start()))
            try_filter(problem.filter, *halved((params, problem.data.inputs)))


def compile_self_tests(problem: Problem) -> None:
    """Compile what a self-test of C runs, if anything else had to be compiled in this run."""
    if not (_is_short(problem) and anything_compiled()):
        return
    with suppress(Exception):
        from tuner.code.form import run_ahead

        params = problem.made(problem.parameters(problem.space.start()))
        what = problem.what_is_exported()
        for trial in what.written(problem.filter, params, problem.data.inputs).values():
            run_ahead(*trial)


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
            try_filter(filter, *halved(tuple(given)))


_IN_TURN = (
    differentiate,
    _evaluate,
    _compile_slopes,
    _compile_single_precision,
    compile_self_tests,
)
"""In the order in which a fit comes to need them; the last ones once its search has begun."""


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
