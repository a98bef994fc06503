"""A parametrised convex program, and its solution for given values."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from threading import RLock
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from tuner.convex.answer import Answer, Report
from tuner.convex.clarabel import compiled, descend
from tuner.convex.cones import kind_of
from tuner.convex.reading import read
from tuner.names import unknown

if TYPE_CHECKING:
    import cvxpy as cp


@dataclass(frozen=True, eq=False)
class ConvexProgram:
    """A convex minimisation in cvxpy whose parameters may change without building it again.

    Build it under :func:`tuner.convex.building` where several threads do so. A program is solved
    by one thread at a time; the others wait.

    Attributes:
        name: of the program.
        problem: the cvxpy problem, a minimisation by cvxpy's rules for parameters (DPP).
        parameters: all its parameters, by name.
        variables: the variables to be read, by name.
        constraints: the constraints whose dual variables are read, by name.
        values: values of the parameters where none are given.
        units: units of the variables; "1" where none is given.
        report: derived numbers, given the answer.

    Raises:
        ValueError: for a problem that is not such a minimisation, or for names of what is not
            part of it.

    >>> import cvxpy as cp
    >>> x, low = cp.Variable(), cp.Parameter()
    >>> problem = cp.Problem(cp.Minimize(x**2), [x >= low])
    >>> program = ConvexProgram("square", problem, {"low": low}, {"x": x})
    >>> answer = solve(program, {"low": 3.0})
    >>> print(f"{answer.value:.6f} at {answer.variables['x']:.6f}, {answer.status.value}")
    9.000000 at 3.000000, converged
    """

    name: str
    problem: "cp.Problem"
    parameters: Mapping[str, "cp.Parameter"]
    variables: Mapping[str, "cp.Variable"]
    constraints: Mapping[str, "cp.Constraint"] = field(default_factory=dict)
    values: Mapping[str, ArrayLike] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    report: Report | None = None
    lock: Any = field(default_factory=RLock, repr=False)

    def __post_init__(self) -> None:
        self._refuse_other_problems()
        self._refuse_strangers("parameter", self.parameters, self.problem.parameters())
        self._refuse_strangers("variable", self.variables, self.problem.variables())
        self._refuse_strangers("constraint", self.constraints, self.problem.constraints)
        self._refuse_nameless()
        for name in self.units:
            if name not in self.variables:
                raise unknown(f"variable of {self.name}", name, self.variables)
        self._refuse_unknown(self.values)

    def _refuse_other_problems(self) -> None:
        import cvxpy as cp

        if not isinstance(self.problem.objective, cp.Minimize):
            raise ValueError(f"{self.name} is not a minimisation; minimise the negative objective")
        if not self.problem.is_dpp():
            raise ValueError(
                f"{self.name} breaks cvxpy's rules for parametrised convex problems (DPP); "
                "let each parameter enter affinely, and multiply no two of them"
            )

    def _refuse_strangers(self, kind: str, named: Mapping[str, Any], there: list[Any]) -> None:
        known = {thing.id for thing in there}
        for name, thing in named.items():
            if thing.id not in known:
                raise ValueError(
                    f"the {kind} named {name!r} is not part of {self.name}; leave it out"
                )

    def _refuse_nameless(self) -> None:
        named = {parameter.id for parameter in self.parameters.values()}
        for parameter in self.problem.parameters():
            if parameter.id not in named:
                raise ValueError(
                    f"{self.name} has a parameter {parameter.name()} of shape {parameter.shape} "
                    "without a name in parameters; add it there"
                )

    def _refuse_unknown(self, values: Mapping[str, ArrayLike]) -> None:
        for name in values:
            if name not in self.parameters:
                raise unknown(f"parameter of {self.name}", name, self.parameters)

    def at(self, values: Mapping[str, ArrayLike]) -> "ConvexProgram":
        """The same program with other default values; nothing is built again."""
        return replace(self, values={**self.values, **values})

    def answer(self) -> Answer:
        """The solution for its own values."""
        return solve(self)

    @property
    def kind(self) -> str:
        """The class for its own values: lp, qp, socp, sdp, or conic for any other."""
        with self.lock:
            self._assign({})
            return kind_of(compiled(self.problem).data)

    def _assign(self, values: Mapping[str, ArrayLike]) -> None:
        self._refuse_unknown(values)
        given = {**self.values, **values}
        checked = {
            name: _checked(self.name, name, parameter.shape, given)
            for name, parameter in self.parameters.items()
        }
        for name, value in checked.items():
            try:
                self.parameters[name].value = value
            except ValueError as error:
                raise ValueError(f"{self.name}: {name!r}: {error}") from error


def _checked(
    program: str, name: str, shape: tuple[int, ...], given: Mapping[str, ArrayLike]
) -> np.ndarray:
    if name not in given:
        raise ValueError(f"{program} needs a value of shape {shape} for its parameter {name!r}")
    value = np.asarray(given[name], float)
    if value.shape != shape:
        raise ValueError(f"{program}: {name!r} has shape {value.shape}, but needs {shape}")
    if not np.isfinite(value).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(value))[0])
        raise ValueError(f"{program}: {name!r} is {value[where]} at {where}; give finite numbers")
    return value


def solve(program: ConvexProgram, values: Mapping[str, ArrayLike] | None = None) -> Answer:
    """Solve a program by Clarabel, an interior-point method, and check what it returns.

    The solver is given :data:`tuner.convex.TOLERANCES` one after the other until it reports that it
    converged; the message tells where that was not the first.

    Args:
        program: what is minimised.
        values: of its parameters; the program's own apply to those that are not named.

    Raises:
        ValueError: for a parameter that does not exist, has no value, a wrong shape, or a value
            that is not finite or not allowed.
    """
    begun = time.perf_counter()
    with program.lock:
        program._assign(values or {})
        return read(program, descend(program.problem), begun)
