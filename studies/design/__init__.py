"""Gains for a linear model of the user's own: no paper, no data, a study.toml with matrices.

The same methods as for :mod:`studies.ha1981`: with a bound the fastest observer that keeps it, by
a search and by a matrix inequality; without one that of minimum variance, by the Riccati
equation, by a search and by a matrix inequality that proves it. docs/design.md shows how.
"""

import hashlib
from functools import partial

import numpy as np

from objectives import LinearSystem, without_undriven
from studies.design.designed import Designed, target
from studies.design.figures import figures
from studies.design.rows import compare_fastest_decay, compare_minimum_variance
from studies.design.settings import Settings, error_of, system_of
from tuner.data.logs import Log
from tuner.observers import fastest_decay, minimum_variance, riccati
from tuner.observers.gains import Variance
from tuner.observers.lmi import Attempt, FastestDecayTask, MinimumVarianceTask
from tuner.run.study import Plan, Source, Study, Task
from tuner.solvers import Convex, Ipopt


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """Search and proof for one observer."""
    full = system_of(settings)
    variance = Variance.of(full, error_of(settings, full))
    if settings.bound is None:
        return _minimum_variance(settings, full, variance.error, seed)
    return _fastest_decay(settings, full, variance.error, settings.bound, seed)


def _minimum_variance(settings: Settings, full: LinearSystem, error: np.ndarray, seed: int) -> Plan:
    T, driven, modes = without_undriven(full)
    undriven = [mode.words(full.states) for mode in modes]
    if not (error @ T).any():
        raise ValueError(
            f"nothing drives {' and '.join(undriven)}: the error that counts falls to zero by "
            "itself, as 1/t, and no steady gain is needed for it; let Q drive it, name another "
            "error, or give a bound"
        )
    problem = minimum_variance("minimum_variance", driven, error @ T)
    # One start: gains elsewhere than near those of the Riccati equation are mostly unstable.
    known, search = riccati(driven), Ipopt(seed=seed, starts=1)
    M = (error @ T)[None]
    proof = MinimumVarianceTask("minimum_variance_lmi", driven, M, ("error",))
    designed = Designed(full, error, driven, T, problem)
    return Plan(
        source=_source(full, error),
        tasks=(
            Task(problem, known, known.name),
            Task(problem, search, search.name),
            Task(proof, Convex("sdp"), "sdp"),
        ),
        targets=(target(settings, designed),),
        compare=partial(compare_minimum_variance, undriven),
        figures=partial(figures, designed),
    )


def _fastest_decay(
    settings: Settings, full: LinearSystem, error: np.ndarray, bound: float, seed: int
) -> Plan:
    unit = f"({settings.unit})^2" if settings.unit else ""
    problem = fastest_decay("fastest_decay", full, error, bound, unit)
    proof = FastestDecayTask("fastest_decay_lmi", full, error[None], [bound], ("error",))
    designed = Designed(full, error, full, np.eye(len(full.A)), problem)
    return Plan(
        source=_source(full, error),
        tasks=(
            Task(problem, Ipopt(seed=seed, starts=settings.starts), "ipopt"),
            Task(Attempt(proof), Convex("sdp"), "sdp"),
        ),
        targets=(target(settings, designed),),
        compare=compare_fastest_decay,
        figures=partial(figures, designed),
    )


def _source(system: LinearSystem, error: np.ndarray) -> Source:
    parts = (system.A, system.C, system.W, system.V, error)
    text = repr([part.tolist() for part in parts]) + repr((system.states, system.dt))
    rate = 0.0 if system.dt is None else 1 / system.dt
    return Source("none: the model alone", hashlib.sha256(text.encode()).hexdigest(), 0, rate)


STUDY = Study(
    name="design",
    title="Gains for a linear model of your own, without data: least variance, or fastest decay",
    paper="none: a study.toml with A, C, Q, R",
    settings=Settings,
    channels={},
    plan=plan,
)
