"""The problem at one decay rate: the least share of all bounds, and what it proves."""

from dataclasses import dataclass

import numpy as np

from objectives import unobservable
from tuner.certificate.solution import Status
from tuner.convex import Answer, solve
from tuner.observers.lmi.design import Design
from tuner.observers.lmi.inequalities import gain_of, share_program, values_of
from tuner.observers.lmi.units import scaled

KEPT = 1e-6
"""Relative tolerance of an observer's rate and variances against those of its inequalities."""


@dataclass(frozen=True)
class Point:
    """The result at one rate.

    Attributes:
        alpha: the rate.
        answer: the least share there.
        gain: for the design as it was given.
        kept: whether poles and Lyapunov equation confirm the rate and the share 1.
        needed: the proved lower bound of the share; inf where there is no observer.
    """

    alpha: float
    answer: Answer
    gain: np.ndarray
    kept: bool
    needed: float

    @property
    def admissible(self) -> bool:
        """Whether an observer was found that meets rate and bounds."""
        return self.kept and self.answer.value <= 1 and not self.refused

    @property
    def refused(self) -> bool:
        """Whether it is proved that no point has t <= 1."""
        return self.needed > 1


class Rates:
    """Least shares at given rates, in coordinates that may change; counts the programs solved."""

    def __init__(self, design: Design) -> None:
        self.scaled = scaled(design, np.ones(len(design.M)))
        self.program = share_program(self.design)
        self.solved = 0
        # No gain moves a hidden pole.
        fixed = self.design.system.rates(unobservable(self.design.system).values)
        self.ceiling = float(fixed.min(initial=np.inf)) * (1 + KEPT / 10)

    @property
    def design(self) -> Design:
        """The design in the present coordinates."""
        return self.scaled.inner

    def __call__(self, alpha: float) -> Point:
        """The least share at a rate."""
        self.solved += 1
        answer = solve(self.program, {"decay": self.decay(alpha)})
        gain = gain_of(answer, self.design)
        variances = self.design.variances_under(gain)
        kept = self.design.system.decay(gain) >= alpha * (1 - KEPT) and np.all(
            variances <= 1 + KEPT
        )
        needed = -np.inf if answer.lower_bound is None else answer.lower_bound
        if answer.status is Status.INFEASIBLE or alpha > self.ceiling:
            needed = np.inf
        return Point(alpha, answer, self.scaled.gain(gain), bool(kept), needed)

    def decay(self, alpha: float) -> float:
        """The programs' parameter for a rate."""
        return float(np.exp(-2 * alpha)) if self.design.system.discrete else 2 * alpha

    def whiten(self, point: Point) -> None:
        """Change to coordinates in which the covariance of the last solved point is about one."""
        covariance = self.scaled.outer.covariance(point.gain)
        if np.isfinite(covariance).all():
            inside = self.scaled.covariance_inside(covariance)
            self.scaled = self.scaled.whitened(inside)
            self.program = self.program.at(values_of(self.design))

    def multipliers(self, point: Point) -> np.ndarray:
        """d ln alpha / d ln bound, from the duals: t's slopes in both."""
        duals, Y = point.answer.duals, point.answer.variables["Y"]
        shares = [float(duals[f"error {i}"][0, 0]) for i in range(len(self.design.M))]
        n = len(Y)
        block, factor = duals["decay"], 2.0
        if self.design.system.discrete:
            block, factor = block[n:, n:], 2 * self.decay(point.alpha)
        slope = point.alpha * factor * np.sum(block * Y)
        return np.asarray(np.array(shares) * point.answer.value / slope)
