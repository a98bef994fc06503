"""A tuning problem: a filter, free parameters, data and an objective. One number per point z."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import jax
import numpy as np
from jax import Array

from filters import AnyFilter
from objectives import Data, Objective, Way
from objectives.in_numpy import Method, in_numpy
from tuner.certificate.single_precision import SinglePrecision, single_precision
from tuner.certificate.solution import Solution
from tuner.data.source import Source
from tuner.export.tuned import Quantity
from tuner.native.route import PRICES, Route
from tuner.problem.aligned import aligned
from tuner.problem.constant_gains import share_of_constant_gains
from tuner.problem.constraint import Constraint
from tuner.problem.derived import derived_numbers
from tuner.problem.differences import differences
from tuner.problem.exported import Exported, Trial, exported_of, one_of, quantities_of
from tuner.problem.identity import identity_of
from tuner.problem.lines import Lines, OneRecord, lines_of
from tuner.problem.paths import turns_round, way_of
from tuner.problem.physics import check_data, check_present, check_start
from tuner.problem.programs import (
    Assemble,
    Build,
    Static,
    by_name,
    excesses_of,
    finite,
    kept_bytes_of,
    run_filter,
    value_and_gradient_of,
    value_of,
)
from tuner.problem.shape_checks import check_shapes
from tuner.problem.shared_gradients import SharedGradients
from tuner.problem.space import Space
from tuner.problem.steady_form import steady_form_of
from tuner.stored_programs import Call

NO_DATA = Data(None, None)
"""The empty data of a design."""


@dataclass(frozen=True, eq=False)
class Problem:
    """A filter, its free parameters, an objective and data; or a design that needs no data.

    Attributes:
        name: the problem's name in results and files.
        space: the parameters.
        filter: the filter that is tuned; None where nothing is run: the objective and the
            constraints then judge what ``build`` makes.
        build: makes the filter's parameters from the space's, by name; None where the space has
            the names that the filter declares. A module-level function is compiled once; a new
            lambda is compiled anew.
        objective: the function to minimise.
        data: the filter's inputs and the truth, float64 throughout; NaN means missing.
        derive: numbers that follow from the parameters, by name; None: those the filter derives.
        constraints: bounds that a solution must satisfy; not every solver supports them.
        known_starts: points z ``(space.size,)`` to begin from before random ones.
        source: the origin of the data.
        exported: the export besides the parameters; None: what the filter declares.
        way: direction of a gradient through the time loop; None: the faster by measured cost.
        steady: whether a likelihood goes on with constant gains where they have settled, which is
            exact (:class:`filters.Settling`); None: where a long record makes it pay.
        gradients: a program for gradients that problems with other parameters share; None: its own.
        seconds: durations of the first evaluations in a search.

    Raises:
        ValueError: where the data hold single precision, anything but real numbers, infinities,
            impossible outliers, unequal lengths, or an input without a single sample; where an
            evaluation by shapes alone shows a mistake in the filter or its parameters; and where
            the search would begin with variances that are negative, or covariances that are none.
    """

    name: str
    space: Space
    filter: AnyFilter | None
    build: Build | None
    objective: Objective
    data: Data = NO_DATA
    derive: Callable[[dict[str, Array]], dict[str, Array]] | None = None
    constraints: tuple[Constraint, ...] = ()
    known_starts: tuple[np.ndarray, ...] = ()
    source: Source | None = None
    exported: Exported | None = None
    way: Way | None = None
    steady: bool | None = None
    gradients: SharedGradients | None = None
    _runs: dict[bytes, Any] = field(default_factory=dict, init=False, repr=False)
    _routes: list[Route] = field(default_factory=list, init=False, repr=False)
    seconds: list[float] = field(default_factory=list, init=False, repr=False)
    _along_at: dict[Way, Call] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        check_data(self.name, self.data)
        object.__setattr__(self, "data", aligned(self.data))
        if self.filter is not None:
            build = self.static.build
            check_shapes(self.name, self.filter, build, self.space, self.objective, self.data)
            check_present(self.name, self.filter, self.data.inputs)
            check_start(self.name, self.space, build, self.filter)

    def starts(self, count: int, seed: int) -> np.ndarray:
        """Starting points, ``(count, size)``: the initial values, known starts, random points."""
        random = self.space.starts(max(count - len(self.known_starts), 1), seed)
        return np.vstack([random[:1], *self.known_starts, random[1:]])[:count]

    def identity(self) -> str:
        """A digest of objective, coordinates and data, equal only for equal problems.

        It does not depend on names, solvers or their starts.
        """
        programs = [value_of.digest(self.static, *self._at(self.space.start())[1:])]
        if self.constraints:
            programs.append(excesses_of.digest(self.static, self.space.start(), self.data))
        return identity_of(programs, self.space, self.data)

    def value(self, z: np.ndarray) -> float:
        """The objective at z ``(space.size,)``; infinite where it is not a number."""
        found = None if self.way is not None else self.route.value(z)
        return finite(self.value_by_xla(z) if found is None else found)

    def value_by_xla(self, z: np.ndarray) -> float:
        """The same by XLA; it may not be a number."""
        if self.in_lines is not None:
            return self.in_lines.value(np.asarray(z, float), *self._by_z)
        return float(np.asarray(self._value_at(np.asarray(z, float))))

    @cached_property
    def _value_at(self) -> Call:
        return value_of.of_first(*self._at(self.space.start()))

    def _at(self, z: np.ndarray) -> tuple[Any, ...]:
        """The parameters and data from which the objective at z follows."""
        return self.scored, np.asarray(z, float), *self._by_z, self.data

    @cached_property
    def _by_z(self) -> tuple[dict[str, Array], Array]:
        """Values by name, and that they are not given: those at z are meant."""
        return by_name(self.parameters(self.space.start()), given=False)

    @cached_property
    def in_lines(self) -> Lines | None:
        """Its recordings end to end, where there are many samples; they are evaluated then."""
        return lines_of(self.static, self.data)

    def value_and_gradient(self, z: np.ndarray) -> tuple[float, np.ndarray]:
        """The objective and its gradient in z, ``(space.size,)``; see :attr:`gradient_by`."""
        found = None if self.way is not None else self.route.value_and_gradient(z)
        value, gradient = found or self.by_xla(z)
        return finite(value), gradient

    @property
    def route(self) -> Route:
        """Whether its gradient is computed by compiled C, where that pays, or by XLA."""
        if not self._routes:
            lines, whole = self.in_lines, OneRecord(self.static, self.data)
            static, data, at = whole if lines is None else lines.end_to_end()
            given = static, data, self.space.size, self.by_xla, self.value_by_xla, self._price
            self._routes.append(Route(*given, at, settle=self.steady is not False))
        return self._routes[0]

    def _price(self) -> tuple[int, float]:
        """Price of a gradient by XLA that goes backwards, and its share of constant gains."""
        return PRICES[self.gradient_way], self.settled

    @property
    def gradient_by(self) -> str:
        """The way its gradients, or values alone by C, were computed, and why; "" before that."""
        forced = "XLA: forced" if self.way is not None else ""
        route = self.route.choice or self.route.values_by or forced
        share = f", constant gains for {self.settled:.1%}" if self.settled else ""
        return route.replace("XLA:", f"XLA, {self.gradient_way}{share}:", 1)

    def by_xla(self, z: np.ndarray) -> tuple[float, np.ndarray]:
        """The objective, which may not be a number, and its gradient in z, by XLA."""
        way = self.gradient_way
        value, gradient = self._along(way, z)
        chosen = self.way is None and way != "forwards"
        if chosen and np.isfinite(value) and not np.isfinite(gradient).all():
            # Backwards 0 meets what is infinite in the branch that was not taken.
            return self._along("forwards", z)
        return value, gradient

    def _along(self, way: Way, z: np.ndarray) -> tuple[float, np.ndarray]:
        z = np.asarray(z, float)
        if self.in_lines is not None:
            return self.in_lines.value_and_gradient(way, z)
        if self.gradients is not None:
            return self.gradients.value_and_gradient(self.static, way, z, self.data)
        if way not in self._along_at:
            self._along_at[way] = value_and_gradient_of.of_first(self.scored, way, z, self.data)
        value, gradient = self._along_at[way](z)
        return float(np.asarray(value)), np.asarray(gradient)

    @cached_property
    def gradient_way(self) -> Way:
        """The direction of :meth:`value_and_gradient` through the time loop."""
        start = self.space.start()
        params = None if self.filter is None else jax.eval_shape(self.static.built, start)
        way = way_of(self.filter, params, self.space.size, self.way)
        if self.way is None and way != "forwards":
            traced = value_of.traced.trace(*self._at(start)).jaxpr
            return way if turns_round(traced.jaxpr) else "forwards"
        return way

    @cached_property
    def kept_bytes(self) -> int:
        """Memory in bytes that a run keeps for what follows its time loop."""
        return kept_bytes_of(self.static, self.space.start(), self.data)

    def hessian(self, z: np.ndarray, step: float = 1e-3) -> np.ndarray:
        """The Hessian in z, ``(n, n)``: central differences of the exact gradient, of XLA.

        A step of 1e-3 (a thousandth of a logarithm) leaves an error of about 1e-6 and keeps
        clear of the rounding noise that a step of 1e-5 meets in filters with slow gains.
        """
        return differences(lambda at: self.by_xla(at)[1], z, step)

    def excesses(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Relative excess of each constraint ``(m,)``, negative if kept; Jacobian ``(m, n)``."""
        if not self.constraints:
            return np.zeros(0), np.zeros((0, self.space.size))
        excess, slopes = excesses_of(self.static, np.asarray(z, float), self.data)
        return np.asarray(excess), np.asarray(slopes)

    def constraint_hessian(
        self, z: np.ndarray, weights: np.ndarray, step: float = 1e-3
    ) -> np.ndarray:
        """The weighted sum of the constraints' Hessians, relative as in :meth:`excesses`.

        A design's step is smaller: it has no noise, and may lie close to instability.
        """
        step = step if self.filter is not None else 1e-2 * step
        return differences(lambda at: weights @ self.excesses(at)[1], z, step)

    def score(self, parameters: Mapping[str, Any]) -> float:
        """The objective of parameters given by name, exactly as they are.

        Raises:
            ValueError: for unknown or missing names, or values outside their constraints.
        """
        given = by_name(self.space.complete(parameters, self.name), given=True)
        if self.in_lines is not None:
            return self.in_lines.value(self.space.start(), *given)
        return float(value_of(self.scored, self.space.start(), *given, self.data))

    def parameters(self, z: np.ndarray) -> dict[str, np.ndarray]:
        """The parameters that z stands for, by name, fixed ones included."""
        values: dict[str, np.ndarray] = in_numpy(Method(self.space, "constrain"), z)
        return values

    def derived(self, z: np.ndarray) -> dict[str, float]:
        """The derived quantities at z, by name."""
        return derived_numbers(self.derive, self.filter, self.parameters(z), self.static.build)

    def params(self, solution: Solution) -> Any:
        """The filter's parameters that a solution stands for."""
        return self.made({name: p.value for name, p in solution.parameters.items()})

    def made(self, values: Mapping[str, Any]) -> Any:
        """The filter's parameters of values by name, all of them."""
        given = {name: np.asarray(value, float) for name, value in values.items()}
        return jax.device_put(in_numpy(self.static.build, given))

    def outputs(self, solution: Solution, inputs: Any = None) -> Any:
        """The outputs of the filter for a solution, time first.

        Args:
            solution: the solution.
            inputs: the inputs to run over; None: the problem's own data, over which it is run
                once per solution, and the result kept.

        Raises:
            ValueError: for a design, which runs no filter.
        """
        if self.filter is None:
            raise ValueError(f"{self.name} runs no filter, so it has no outputs")
        if inputs is not None:
            return run_filter(self.filter, self.params(solution), inputs)
        key = b"".join(p.value.tobytes() for p in solution.parameters.values())
        if key not in self._runs:
            self._runs[key] = run_filter(self.filter, self.params(solution), self.data.inputs)
        return self._runs[key]

    def single_precision(self, solution: Solution) -> tuple[SinglePrecision, ...]:
        """The deviation in float32 of the tuned filter, or of what runs on the machine instead.

        Nothing for a design that does not say what runs. The steady form of a filter that offers
        one (a method ``steady``) is checked as well.
        """
        what, params = self.what_is_exported(), self.params(solution)
        trials = what.tried(self.filter, params, self.data.inputs)
        return tuple(single_precision(form, *trial) for form, trial in trials.items())

    def on_machine(self, solution: Solution) -> Mapping[str, Trial]:
        """The forms to write as C for a solution, by name, the main one first.

        Nothing for a design that does not say what runs.
        """
        what, params = self.what_is_exported(), self.params(solution)
        trials = what.written(self.filter, params, self.data.inputs)
        if what.machine or what.runs or self.filter is None or "steady" in trials:
            return trials
        return {**trials, **steady_form_of(one_of(self.filter), params)}

    def what_is_exported(self) -> Exported:
        """The filter's name, its states, its sample time and what follows from its parameters."""
        return exported_of(self.filter) if self.exported is None else self.exported

    def quantities(self, solution: Solution) -> tuple[Quantity, ...]:
        """The quantities to export for a solution: its parameters, the filter's, and derived ones.

        No name occurs twice. Of names that differ in case only, which one C header cannot hold,
        the later one, as the variance per sample Q besides the density q, is ``Q_derived``.
        """
        params = self.params(solution)
        return quantities_of(self.space, solution, self.filter, params, self.what_is_exported())

    @cached_property
    def settled(self) -> float:
        """Share of the record that is taken with constant gains where a search begins.

        It is 0 of recordings end to end, whose every sample is taken.
        """
        if self.filter is None or self.steady is False or self.in_lines is not None:
            return 0.0
        wanted = self.steady is True
        return share_of_constant_gains(self.static, self.space.start(), self.data, wanted=wanted)

    @cached_property
    def scored(self) -> "Static":
        """The static part of its values and gradients."""
        return self.static._replace(steady=self.settled > 0)

    @cached_property
    def static(self) -> "Static":
        """The static part for which code is compiled: everything but the numbers."""
        build = Assemble(self.filter) if self.build is None else self.build
        return Static(self.space.form(), self.filter, self.objective, build, self.constraints)
