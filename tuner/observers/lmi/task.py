"""Both observers as tasks of a study."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from tuner.certificate.solution import Status
from tuner.convex import Answer, Report
from tuner.observers.lmi.fastest import FastestObserver, fastest_observer
from tuner.observers.lmi.least import H2Observer, h2_observer
from tuner.observers.lmi.model import Model


@dataclass(frozen=True, eq=False)
class LeastTask:
    """The observer with the least variance as a task of :class:`tuner.solvers.convex.Convex`.

    Its value is the sum of the variances of M e under the gain. Its variables are the gain, the
    poles' real parts and, named after the errors, their variances.

    Attributes:
        name: what it is called.
        model: what is designed for; without noise that w and v share.
        errors: names of the errors M e, ``(k,)``.
        units: units of the variables, where they are to be told.
        report: more derived numbers, given the answer.
    """

    name: str
    model: Model
    errors: tuple[str, ...]
    units: Mapping[str, str] = field(default_factory=dict)
    report: Report | None = None
    kind: str = field(default="sdp", init=False)

    def design(self) -> H2Observer:
        """The observer itself."""
        return h2_observer(*self.model.matrices, discrete=self.model.discrete)

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
class FastestTask:
    """The fastest observer as a task of :class:`tuner.solvers.convex.Convex`.

    Its value is the time in which the slowest error falls to 1/e, as far as the inequalities
    promise it and the observer keeps it; its lower bound holds for designs with one Lyapunov
    matrix. Its variables are the gain and the poles' real parts; its multipliers are named after
    the errors.

    Attributes:
        name: what it is called.
        model: what is designed for; without noise that w and v share.
        bound: of the variances of M e, ``(k,)`` or a number.
        errors: names of the errors M e, ``(k,)``.
        dt: sample time where discrete, s.
        units: units of the variables ``gain`` and ``poles``, where they are to be told.
        report: more derived numbers, given the answer.
    """

    name: str
    model: Model
    bound: ArrayLike
    errors: tuple[str, ...]
    dt: float = 1.0
    units: Mapping[str, str] = field(default_factory=dict)
    report: Report | None = None
    kind: str = field(default="sdp", init=False)

    def design(self) -> FastestObserver:
        """The observer itself."""
        return fastest_observer(
            *self.model.matrices, self.bound, discrete=self.model.discrete, dt=self.dt
        )

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
