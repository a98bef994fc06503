"""What a design amounts to on the model as it was given: gains, poles, covariance."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from objectives import LinearSystem
from studies.design.settings import Settings
from tuner.certificate.solution import Solution
from tuner.export.tuned import Quantity
from tuner.observers import gain_of
from tuner.problem.problem import Problem
from tuner.run.study import Target


@dataclass(frozen=True, eq=False)
class Designed:
    """A system, the part of it that a problem is about, and the problem.

    Attributes:
        full: the system.
        error: weights of the error that counts, ``(n,)``.
        part: without what nothing drives, where the design is one of the steady state.
        T: from the part's states to the system's, ``(n, r)``.
        problem: posed on the part.
    """

    full: LinearSystem
    error: np.ndarray
    part: LinearSystem
    T: np.ndarray
    problem: Problem

    def gain(self, solution: Solution) -> np.ndarray:
        """L for the system, ``(n, m)``."""
        return np.asarray(self.T @ gain_of(self.problem, solution.z))

    def covariance(self, solution: Solution) -> np.ndarray:
        """Steady covariance of the error, ``(n, n)``; zero along what nothing drives."""
        P = self.part.covariance(gain_of(self.problem, solution.z))
        return np.asarray(self.T @ P @ self.T.T)


def target(settings: Settings, designed: Designed) -> Target:
    """What is exported: model, gain, poles and covariance."""
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
    variance = np.array(designed.error @ P @ designed.error)
    quantities += [
        Quantity("W", full.W, "", "density of the process noise; discrete: covariance a sample"),
        Quantity("V", full.V, "", "the same of the measurement noise"),
        Quantity("error", designed.error, "", "weights of the error that counts"),
        Quantity("P", P, "", "steady covariance of the error; discrete: before a measurement"),
        Quantity("variance", variance, unit, "of the error that counts"),
    ]
    return tuple(quantities)
