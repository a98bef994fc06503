"""Compiling and importing what a fit needs later, while it is planned and solved."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import import_module

import jax

from tuner.certificate.single_precision import halved
from tuner.problem.problem import Problem
from tuner.problem.programs import run_filter
from tuner.problem.samples import numbers
from tuner.run.threads import at_once

LONG_RECORD = 1_000_000
"""Samples from which a trial run takes longer than compiling."""
REPORT_PACKAGES = ("matplotlib.figure", "matplotlib.backends.backend_agg", "contourpy", "jinja2")
"""What draws pictures and writes reports."""


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
    leaves = jax.tree.leaves(problem.data.inputs)
    if not problem.space.size or not leaves or len(leaves[0]) > LONG_RECORD:
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


def import_report_packages() -> None:
    """Import what the end of a run takes; what is not installed is missed there."""
    for name in REPORT_PACKAGES:
        with suppress(Exception):
            import_module(name)
