"""Gains for a linear model of the user's own: no paper, no data, a study.toml with matrices.

The same methods as for :mod:`studies.ha1981`: with a bound the fastest observer that keeps it, by
a search and by a matrix inequality; without one the quietest, by the Riccati equation, by a
search and by a matrix inequality that proves it. docs/design.md shows how.
"""

import hashlib
from functools import partial
from typing import Any

import numpy as np

from studies.design.designed import Designed, target
from studies.design.figures import figures
from studies.design.rows import compare_fastest, compare_quietest
from studies.design.settings import Settings, model
from tuner.data.logs import Log
from tuner.observers import LinearDesign, fastest, quietest, riccati
from tuner.observers.lmi import Attempt, FastestTask, LeastTask, observer_model
from tuner.run.study import Plan, Source, Study, Task
from tuner.solvers import Convex, Ipopt


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """Search and proof for one observer."""
    full = model(settings)
    if settings.bound is None:
        return _quietest(settings, full, seed)
    return _fastest(settings, full, settings.bound, seed)


def _quietest(settings: Settings, full: LinearDesign, seed: int) -> Plan:
    driven, T, modes = full.driven()
    undriven = [mode.words(full.states) for mode in modes]
    if not driven.error.any():
        raise ValueError(
            f"nothing drives {' and '.join(undriven)}: the error that counts falls to zero by "
            "itself, as 1/t, and no steady gain is needed for it; let Q drive it, name another "
            "error, or give a bound"
        )
    problem = quietest("quietest", driven)
    # One start: gains elsewhere than near those of the Riccati equation are mostly unstable.
    known, search = riccati(driven), Ipopt(seed=seed, starts=1)
    proof = LeastTask("quietest_lmi", _convex(driven), ("error",))
    return Plan(
        source=_source(full),
        tasks=(
            Task(problem, known, known.name),
            Task(problem, search, search.name),
            Task(proof, Convex("sdp"), "sdp"),
        ),
        targets=(target(settings, Designed(full, driven, T, problem)),),
        compare=partial(compare_quietest, undriven),
        figures=partial(figures, Designed(full, driven, T, problem)),
    )


def _fastest(settings: Settings, full: LinearDesign, bound: float, seed: int) -> Plan:
    unit = f"({settings.unit})^2" if settings.unit else ""
    problem = fastest("fastest", full, bound, unit)
    bounded = np.array([bound])
    proof = Attempt(
        FastestTask("fastest_lmi", _convex(full), bounded, ("error",), dt=full.dt or 1.0)
    )
    designed = Designed(full, full, np.eye(len(full.states)), problem)
    return Plan(
        source=_source(full),
        tasks=(
            Task(problem, Ipopt(seed=seed, starts=settings.starts), "ipopt"),
            Task(proof, Convex("sdp"), "sdp"),
        ),
        targets=(target(settings, designed),),
        compare=compare_fastest,
        figures=partial(figures, designed),
    )


def _convex(design: LinearDesign) -> Any:
    d = design
    return observer_model(d.A, d.C, d.W, d.V, d.error[None], discrete=d.discrete)


def _source(design: LinearDesign) -> Source:
    parts = (design.A, design.C, design.W, design.V, design.error)
    text = repr([part.tolist() for part in parts]) + repr((design.states, design.dt))
    rate = 0.0 if design.dt is None else 1 / design.dt
    return Source("none: the model alone", hashlib.sha256(text.encode()).hexdigest(), 0, rate)


STUDY = Study(
    name="design",
    title="Gains for a linear model of your own, without data: fastest within a bound, or quietest",
    paper="none: a study.toml with A, C, Q, R",
    settings=Settings,
    channels={},
    plan=plan,
)
