"""Convex programs as problems of a study: solved once, and proved by their dual."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from tuner.certificate.solution import Certificate, Solution, Starts, TunedParameter
from tuner.convex import Answer, Report
from tuner.names import unknown

KINDS = {
    "lp": "linear objective and constraints",
    "sdp": "every convex program, matrix inequalities included",
}
"""The options of each of these solvers, by name; both are Clarabel."""


class ConvexTask(Protocol):
    """A program that a convex solver takes: :class:`tuner.convex.ConvexProgram`, or its like."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def kind(self) -> str:
        """The least class of programs it belongs to: lp, qp, socp, sdp or conic."""

    @property
    def units(self) -> Mapping[str, str]:
        """Units of the variables that are read."""

    @property
    def report(self) -> Report | None:
        """Derived numbers, given the answer."""

    def answer(self) -> Answer:
        """Its solution."""


@dataclass(frozen=True)
class Convex:
    """The solver of convex programs; there is nothing to start from, and nothing to seed.

    Attributes:
        name: lp, which refuses all but linear programs, or sdp, which takes every convex one.

    Raises:
        ValueError: for another name, with the near ones.

    >>> from tuner.convex import linear_program
    >>> solution = Convex("lp")(linear_program([1.0, 1.0], low=[2.0, 3.0]))
    >>> print(f"{solution.value:.6f}, {solution.status.value}")
    5.000000, converged
    """

    name: Literal["lp", "sdp"]

    def __post_init__(self) -> None:
        if self.name not in KINDS:
            raise unknown("convex solver", self.name, KINDS)

    def __call__(self, task: ConvexTask) -> Solution:
        """Solve a program for its own values.

        The solution has no coordinates z: what speaks for it are its multipliers and its lower
        bound, not a gradient.

        Raises:
            ValueError: for a program that is more than linear where the name is lp.
        """
        if self.name == "lp" and task.kind != "lp":
            raise ValueError(
                f"{task.name} is no linear program (it needs {_NEEDS[task.kind]}); solve it by sdp"
            )
        answer = task.answer()
        reported = task.report(answer) if task.report and answer.variables else {}
        return Solution(
            problem=task.name,
            solver=self.name,
            status=answer.status,
            message=answer.message,
            value=answer.value,
            z=np.empty(0),
            parameters={
                name: TunedParameter(value, task.units.get(name, ""), None)
                for name, value in answer.variables.items()
            },
            derived=reported,
            evaluations=answer.iterations,
            seconds=answer.seconds,
            certificate=_certificate(answer),
        )


_NEEDS = {
    "qp": "a quadratic objective",
    "socp": "second-order cones",
    "sdp": "matrix inequalities",
    "conic": "exponential or power cones",
}


def _certificate(answer: Answer) -> Certificate:
    return Certificate(
        gradient={},
        active_bounds=(),
        curvatures=(),
        flat_directions=(),
        starts=Starts(1, 1, 0.0),
        methods={},
        multipliers=answer.multipliers,
        lower_bound=answer.lower_bound,
    )
