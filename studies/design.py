"""Gains for a linear model of the user's own: no paper, no data, a study.toml with matrices.

The same methods as for :mod:`studies.ha1981`: with a bound the fastest observer that keeps it, by
a search and by a matrix inequality; without one the quietest, by the Riccati equation, by a
search and by a matrix inequality that proves it. docs/design.md shows how.
"""

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any

import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.linalg import expm
from pydantic import BaseModel, ConfigDict, Field, Strict, field_validator, model_validator

from filters import van_loan
from tuner.comparison import Comparison, Verdict, claim
from tuner.convex import Answer
from tuner.design import LinearDesign, fastest, gain_of, quietest, riccati
from tuner.export.checks import require, require_name, require_once
from tuner.export.tuned import Quantity
from tuner.figure import Chart, Figure, Line
from tuner.logs import Log
from tuner.names import unknown
from tuner.observer import FastestTask, LeastTask, observer_model
from tuner.parameters import covariance
from tuner.problem import Problem
from tuner.solution import Solution, Status
from tuner.solvers import Convex, Ipopt
from tuner.study import Plan, Solutions, Source, Study, Target, Task, best

Number = Annotated[float, Strict()]
Matrix = tuple[tuple[Number, ...], ...]
AGREE = 1e-7
"""How closely the matrix inequality has to give the Riccati equation's variance."""
CURVE = 400


class Settings(BaseModel):
    """The model, and what is wanted of its observer."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    A: Matrix = Field(description="dynamics: dx/dt = A x + G w; x' = A x + G w with dt")
    C: Matrix = Field(description="measurements: y = C x + v")
    Q: Matrix = Field(description="spectral density of w (two-sided); covariance with dt")
    R: Matrix = Field(description="spectral density of v; covariance with dt or sample_time")
    error: str | tuple[Number, ...] = Field(description="the state whose error counts, or a row")
    G: Matrix | None = Field(None, description="where w enters; the unit matrix if unset")
    bound: float | None = Field(None, gt=0, description="of that error's variance; none: least")
    states: tuple[str, ...] | None = Field(None, description="names of the states; x1, x2, ...")
    dt: float | None = Field(None, gt=0, description="sample time of a discrete model, s")
    sample_time: float | None = Field(
        None, gt=0, description="of the measurements of a continuous model, s"
    )
    unit: str = Field("", description="of the error that counts, for the exports")
    starts: int = Field(4, ge=1, description="starts of each search")

    @field_validator("A", "C", "Q", "R", "G")
    @classmethod
    def _rectangular(cls, value: Matrix | None) -> Matrix | None:
        if value is not None and (not value or len({len(row) for row in value}) != 1):
            raise ValueError("must be a matrix: rows of one length")
        return value

    @field_validator("states")
    @classmethod
    def _names(cls, value: tuple[str, ...] | None) -> tuple[str, ...] | None:
        for name in value or ():
            require_name("a state", name, 25)
        if value is not None:
            require_once("state", [name.lower() for name in value])
            require(len(value) > 0, "name every state, or leave the names out")
        return value

    @model_validator(mode="after")
    def _one_clock(self) -> "Settings":
        if self.dt is not None and self.sample_time is not None:
            raise ValueError("dt says that A is discrete, sample_time that it is not: give one")
        return self


@dataclass(frozen=True, eq=False)
class Designed:
    """A model, the part of it that a problem is about, and the problem.

    Attributes:
        full: the model.
        part: without what nothing drives, where the design is one of the steady state.
        T: from the part's states to the model's, ``(n, r)``.
        problem: posed on the part.
    """

    full: LinearDesign
    part: LinearDesign
    T: np.ndarray
    problem: Problem

    def gain(self, solution: Solution) -> np.ndarray:
        """L for the model, ``(n, m)``."""
        return np.asarray(self.T @ gain_of(self.problem, solution.z))

    def covariance(self, solution: Solution) -> np.ndarray:
        """Steady covariance of the error, ``(n, n)``; zero along what nothing drives."""
        P = self.part.covariance(gain_of(self.problem, solution.z))
        return np.asarray(self.T @ P @ self.T.T)


def plan(settings: Settings, log: Log | None, seed: int, storage: str) -> Plan:
    """Search and proof for one observer."""
    full = model(settings)
    if settings.bound is None:
        return _quietest(settings, full, seed)
    return _fastest(settings, full, settings.bound, seed)


def model(settings: Settings) -> LinearDesign:
    """The model as it is designed for; a sampled continuous one is discretised exactly.

    Raises:
        ValueError: where a matrix does not fit, noise is no covariance, or a mode is unseen.
    """
    A, C, Q, R = (
        np.array(part, float) for part in (settings.A, settings.C, settings.Q, settings.R)
    )
    n = len(A)
    G = np.eye(n) if settings.G is None else np.array(settings.G, float)
    if A.shape != (n, n) or G.shape != (n, len(Q)):
        raise ValueError(
            f"A {A.shape}, G {G.shape} and Q {Q.shape} do not fit; they are (n, n), (n, p) and "
            "(p, p), and G is the unit matrix where it is not given"
        )
    for name, matrix in (("Q", Q), ("R", R)):
        try:
            covariance(matrix)
        except ValueError as error:
            raise ValueError(f"{name} {error}") from None
    states = settings.states or tuple(f"x{i + 1}" for i in range(n))
    if len(states) != n:
        raise ValueError(f"{len(states)} names ({', '.join(states)}) for {n} states; give one each")
    W, dt = G @ Q @ G.T, settings.dt
    if settings.sample_time is not None:
        dt = settings.sample_time
        given = (jnp.asarray(part) for part in (A, G, Q, dt))
        step = jax.jit(van_loan)(*given)
        A, W = np.asarray(step.F), np.asarray(step.Q)
    return LinearDesign(states, A, C, W, R, _error(settings.error, states), dt)


def _error(given: str | tuple[float, ...], states: tuple[str, ...]) -> np.ndarray:
    if not isinstance(given, str):
        if not any(given):
            raise ValueError("the error that counts is zero in every state; name one, or weights")
        return np.array(given, float)
    if given not in states:
        raise unknown("state", given, states)
    return np.asarray(np.eye(len(states))[states.index(given)])


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
        targets=(_target(settings, Designed(full, driven, T, problem)),),
        compare=partial(_compare_quietest, undriven),
        figures=partial(_figures, Designed(full, driven, T, problem)),
    )


def _fastest(settings: Settings, full: LinearDesign, bound: float, seed: int) -> Plan:
    unit = f"({settings.unit})^2" if settings.unit else ""
    problem = fastest("fastest", full, bound, unit)
    # Gains of several measurements have one start: elsewhere most of them are unstable.
    starts = settings.starts if len(full.C) == 1 else 1
    bounded = np.array([bound])
    proof = Attempt(
        FastestTask("fastest_lmi", _convex(full), bounded, ("error",), dt=full.dt or 1.0)
    )
    designed = Designed(full, full, np.eye(len(full.states)), problem)
    return Plan(
        source=_source(full),
        tasks=(
            Task(problem, Ipopt(seed=seed, starts=starts), "ipopt"),
            Task(proof, Convex("sdp"), "sdp"),
        ),
        targets=(_target(settings, designed),),
        compare=partial(_compare_fastest, designed),
        figures=partial(_figures, designed),
    )


@dataclass(frozen=True)
class Attempt:
    """A matrix inequality beside a search: where its numbers fail, the search still counts.

    Attributes:
        task: the matrix inequality.
    """

    task: FastestTask
    kind: str = "sdp"
    report: None = None

    @property
    def name(self) -> str:
        """That of the task."""
        return self.task.name

    @property
    def units(self) -> Mapping[str, str]:
        """Those of the task."""
        return self.task.units

    def answer(self) -> Answer:
        """The task's answer, or one that says that there is none."""
        try:
            return self.task.answer()
        except ValueError as error:
            return Answer(
                status=Status.FAILED,
                message=f"the matrix inequalities were not solved: {error}",
                value=np.inf,
                variables={},
                duals={},
                multipliers={},
                lower_bound=None,
                gap=np.inf,
                violation=np.inf,
                iterations=0,
                seconds=0.0,
            )


def _convex(design: LinearDesign) -> Any:
    d = design
    return observer_model(d.A, d.C, d.W, d.V, d.error[None], discrete=d.discrete)


def _source(design: LinearDesign) -> Source:
    parts = (design.A, design.C, design.W, design.V, design.error)
    text = repr([part.tolist() for part in parts]) + repr((design.states, design.dt))
    rate = 0.0 if design.dt is None else 1 / design.dt
    return Source("none: the model alone", hashlib.sha256(text.encode()).hexdigest(), 0, rate)


def _compare_quietest(undriven: list[str], solutions: Solutions) -> list[Comparison]:
    found, proof = best("quietest", solutions), solutions["quietest_lmi", "sdp"]
    excess = proof.value / found.value - 1
    rows = [
        claim(
            "quietest.matrix_inequality",
            "the Riccati equation's variance is the least",
            abs(excess) <= AGREE,
            ours=found.value,
            note=f"the matrix inequality's gain gives {excess:+.1e} of it, and its dual proves "
            f"that no observer is below {_proved(proof)}",
        )
    ]
    if undriven:
        rows.append(
            claim(
                "quietest.every_mode_driven",
                "a steady state exists",
                False,
                ours=None,
                note=f"nothing drives {' and '.join(undriven)}: its error falls to zero as 1/t, "
                "and the steady gain leaves it alone; store the first gains, or let Q drive it",
            )
        )
    return rows


def _compare_fastest(designed: Designed, solutions: Solutions) -> list[Comparison]:
    found, proof = best("fastest", solutions), solutions["fastest_lmi", "sdp"]
    reached = designed.full.decay(designed.gain(found))
    share = 1 / (proof.value * reached)
    verdict = Verdict.HOLDS if share <= 1 + 1e-6 else Verdict.FAILS
    note = (
        f"with one Lyapunov matrix for both demands, which designs with two need not have, no time "
        f"constant below {_proved(proof)} s is possible ({proof.status.value}); ours is the decay "
        f"rate of its gain as a share of the {reached:.6g} 1/s that the search found"
    )
    if verdict is Verdict.FAILS:
        note = f"the search ({found.status.value}) missed the gain of {proof.problem}: {note}"
    if proof.status is Status.FAILED:
        verdict, note = Verdict.NOT_IDENTIFIABLE, proof.message
    where = "one Lyapunov matrix is never faster"
    return [Comparison("fastest.matrix_inequality", where, None, share, "", None, verdict, note)]


def _proved(proof: Solution) -> str:
    bound = proof.certificate.lower_bound
    return "-" if bound is None else f"{bound:.8g}"


def _target(settings: Settings, designed: Designed) -> Target:
    return Target(
        problem=designed.problem,
        filter="Observer",
        states=designed.full.states,
        dt=designed.full.dt or 0.0,
        quantities=partial(_quantities, settings, designed),
        single=lambda _: (),
    )


def _quantities(settings: Settings, designed: Designed, solution: Solution) -> tuple[Quantity, ...]:
    full, L = designed.full, designed.gain(solution)
    poles = full.poles(L)
    per = "" if full.discrete else "1/s"
    quantities = [
        Quantity("A", full.A, per, "the model's dynamics"),
        Quantity("C", full.C, "", "the model's measurements"),
        Quantity("L", L, "", "gain of the observer x' = A x + L (y - C x)"),
        Quantity("poles_re", poles.real.copy(), per, "real parts of the poles of A - L C"),
        Quantity("poles_im", poles.imag.copy(), per, "their imaginary parts"),
    ]
    if full.discrete and np.linalg.cond(full.A) < 1e12:
        K = np.linalg.solve(full.A, L)
        quantities.append(Quantity("K", K, "", "gain on a sample: x+ = x + K (y - C x), L = A K"))
    P = designed.covariance(solution)
    unit = f"({settings.unit})^2" if settings.unit else ""
    variance = np.array(full.error @ P @ full.error)
    quantities += [
        Quantity("W", full.W, "", "density of the process noise; discrete: covariance a sample"),
        Quantity("V", full.V, "", "the same of the measurement noise"),
        Quantity("error", full.error, "", "weights of the error that counts"),
        Quantity("P", P, "", "steady covariance of the error; discrete: before a measurement"),
        Quantity("variance", variance, unit, "of the error that counts"),
    ]
    return tuple(quantities)


def _figures(designed: Designed, solutions: Solutions) -> Iterator[Figure]:
    full = designed.full
    L = designed.gain(best(designed.problem.name, solutions))
    yield _response(full, L)
    poles = full.poles(L)
    per = "" if full.discrete else ", 1/s"
    yield Chart(
        name="poles",
        title="Poles of the observer's error",
        x_label=f"real part{per}",
        y_label=f"imaginary part{per}",
        lines=tuple(
            Line(f"{pole:.4g}", np.array([pole.real]), np.array([pole.imag])) for pole in poles
        ),
    )


def _response(full: LinearDesign, L: np.ndarray) -> Chart:
    """What an error in each state does to the error that counts."""
    closed = full.A - L @ full.C
    decay = full.decay(L)
    span = 8 / decay if decay > 0 else 100 * (full.dt or 1.0)
    step = full.dt or span / CURVE
    F = closed if full.discrete else np.asarray(expm(jnp.asarray(closed * step)))
    count = min(int(np.ceil(span / step)), 20 * CURVE) + 1
    rows = [full.error]
    for _ in range(count - 1):
        rows.append(rows[-1] @ F)
    found, at = np.array(rows), np.arange(count) * step
    size = np.abs(found).max(axis=0)
    return Chart(
        name="response",
        title="The error that counts after an error in one state, each over its largest",
        x_label="t, s",
        y_label="share of its largest",
        lines=tuple(
            Line(f"{name} (x {size[i]:.3g})", at, found[:, i] / size[i])
            for i, name in enumerate(full.states)
            if size[i] > 0
        ),
    )


STUDY = Study(
    name="design",
    title="Gains for a linear model of your own, without data: fastest within a bound, or quietest",
    paper="none: a study.toml with A, C, Q, R",
    settings=Settings,
    channels={},
    plan=plan,
)
