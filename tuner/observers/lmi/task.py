"""Both observers as tasks of a study."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from objectives import LinearSystem
from tuner.certificate.solution import Status
from tuner.convex import Answer, Report
from tuner.observers.lmi.fastest_decay import FastestObserver, fastest_observer
from tuner.observers.lmi.minimum_variance import H2Observer, h2_observer


@dataclass(frozen=True, eq=False)
class MinimumVarianceTask:
    """The observer with the least variance as a task of :class:`tuner.solvers.convex.Convex`.

    Its value is the sum of the variances of M e under the gain. Its variables are the gain, the
    poles' real parts and, named after the errors, their variances.

    Attributes:
        name: of the task.
        system: the system.
        M: the errors that count, M e, ``(k, n)``.
        errors: their names, ``(k,)``.
        units: units of the variables, where they are known.
        report: more derived numbers, given the answer.
    """

    name: str
    system: LinearSystem
    M: np.ndarray
    errors: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    report: Report | None = None
    kind: str = field(default="sdp", init=False)

    def design(self) -> H2Observer:
        """The observer itself."""
        return h2_observer(self.system, self.M)

    def answer(self) -> Answer:
        """The observer as the answer of a convex program."""
        found = self.design()
        variances = dict(zip(self.errors, map(np.asarray, found.variances), strict=True))
        return Answer(
            status=found.status,
            message=found.message,
            value=found.value,
            variables={"gain": found.gain, "poles": found.poles.real, **variances},
            duals={},
            multipliers={},
            lower_bound=found.lower_bound,
            gap=found.value - found.lower_bound,
            violation=0.0,
            iterations=found.primal.iterations + found.dual.iterations,
            seconds=found.seconds,
        )


@dataclass(frozen=True, eq=False)
class FastestDecayTask:
    """The fastest observer as a task of :class:`tuner.solvers.convex.Convex`.

    Its value is the time in which the slowest error falls to 1/e, as far as the inequalities
    promise it and the observer keeps it; its lower bound holds for designs with one Lyapunov
    matrix. Its variables are the gain and the poles' real parts; its multipliers are named after
    the errors.

    Attributes:
        name: of the task.
        system: the system.
        M: the errors that count, M e, ``(k, n)``.
        bound: of their variances, ``(k,)`` or a number.
        errors: their names, ``(k,)``.
        units: units of the variables ``gain`` and ``poles``, where they are known.
        report: more derived numbers, given the answer.
    """

    name: str
    system: LinearSystem
    M: np.ndarray
    bound: ArrayLike
    errors: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    report: Report | None = None
    kind: str = field(default="sdp", init=False)

    def design(self) -> FastestObserver:
        """The observer itself."""
        return fastest_observer(self.system, self.M, self.bound)

    def answer(self) -> Answer:
        """The observer as the answer of a convex program."""
        found = self.design()
        value, lower = 1 / min(found.alpha, found.rate), 1 / found.limit
        return Answer(
            status=found.status,
            message=found.message,
            value=value,
            variables={"gain": found.gain, "poles": found.poles.real},
            duals={},
            multipliers=dict(zip(self.errors, found.multipliers.tolist(), strict=True)),
            lower_bound=lower,
            gap=value - lower,
            violation=float(max(np.max(found.variances / np.asarray(self.bound)) - 1, 0.0)),
            iterations=found.solved,
            seconds=found.seconds,
        )


@dataclass(frozen=True)
class Attempt:
    """A matrix inequality beside a search: where it fails numerically, the search still counts.

    Attributes:
        task: the matrix inequality.
    """

    task: FastestDecayTask
    kind: str = "sdp"
    report: None = None

    @property
    def name(self) -> str:
        """The task's name."""
        return self.task.name

    @property
    def units(self) -> Mapping[str, str]:
        """The task's units."""
        return self.task.units

    def answer(self) -> Answer:
        """The task's answer, or a failed one."""
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
