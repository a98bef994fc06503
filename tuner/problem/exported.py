"""The export of a tuned filter, with what follows from its tuned parameters."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import AnyFilter, Lanes
from filters.declared import bare, channel_facts, in_unit, parameter_facts, values_of
from tuner.certificate.solution import Solution
from tuner.export.tuned import Quantity
from tuner.problem.space import Space
from tuner.problem.steady_gains import a_sample


def no_more(params: Any) -> tuple[Quantity, ...]:
    """Nothing follows."""
    return ()


class Trial(NamedTuple):
    """A filter as it runs on the machine, and its inputs for a trial.

    Attributes:
        filter: the filter.
        params: its parameters.
        inputs: its inputs, time first.
    """

    filter: AnyFilter
    params: Any
    inputs: Any


def one_of(filter: Any) -> Any:
    """The filter of one record, of those that may run side by side."""
    return filter.filter if isinstance(filter, Lanes) else filter


def trials_of(filter: Any, params: Any, inputs: Any) -> dict[str, Trial]:
    """A filter as it is, and its steady form if it has a method ``steady``; nothing of None."""
    if filter is None:
        return {}
    trials = {"full": Trial(filter, params, inputs)}
    if hasattr(filter, "steady"):
        steady, steady_params = filter.steady(params)
        trials["steady"] = Trial(steady, steady_params, inputs)
    return trials


@dataclass(frozen=True)
class Weighed:
    """A filter that outputs one weighted sum of its estimate, a vector.

    Attributes:
        filter: the filter.
        weights: of the estimate's entries.
    """

    filter: AnyFilter
    weights: tuple[float, ...]

    def init(self, params: Any) -> Any:
        """The filter's own start."""
        return self.filter.init(params)

    def step(self, params: Any, state: Any, inputs: Any) -> tuple[Any, Array]:
        """Take one sample; the sum, ``()``."""
        state, x = self.filter.step(params, state, inputs)
        return state, jnp.asarray(self.weights, x.dtype) @ x


@dataclass(frozen=True)
class Exported:
    """The contents of an export besides the parameters.

    Attributes:
        filter: name of the filter's class.
        states: names of its states, in their order.
        dt: sample time, s; 0 where it is continuous.
        derived: numbers that follow from the filter's parameters.
        unit: of the measurement, where the filter takes it in any.
        runs: makes the forms that run on the machine, by name, from the same parameters, where
            these are not the problem's own filter, as with a design; tried in single precision.
        machine: the form that is written as C, where it is another one.
    """

    filter: str
    states: tuple[str, ...] = ()
    dt: float = 0.0
    derived: Callable[[Any], tuple[Quantity, ...]] = no_more
    unit: str = ""
    runs: Callable[[Any], Mapping[str, Trial]] | None = None
    machine: Callable[[Any], Mapping[str, Trial]] | None = None

    def tried(self, filter: Any, params: Any, inputs: Any) -> Mapping[str, Trial]:
        """The forms to try in single precision, by name.

        Args:
            filter: of the problem.
            params: its parameters.
            inputs: its inputs, time first.
        """
        return trials_of(filter, params, inputs) if self.runs is None else self.runs(params)

    def written(self, filter: Any, params: Any, inputs: Any) -> Mapping[str, Trial]:
        """The forms to write as C, by name; the arguments are those of :meth:`tried`."""
        made = self.machine or self.runs
        return trials_of(filter, params, inputs) if made is None else made(params)


def exported_of(filter: Any, unit: str = "") -> Exported:
    """The declared export of a filter: its states, and what it derives from its parameters."""
    if filter is None:
        return Exported("Design")
    filter = bare(filter)
    states = channel_facts(filter, "states") if hasattr(filter, "states") else {}
    names = [f"{name}_{axis}" for name, c in states.items() for axis in c.axes or ("",)]
    return Exported(
        type(filter).__name__,
        tuple(name.rstrip("_") for name in names),
        float(getattr(filter, "dt", 0.0)),
        partial(derived_of, filter, unit=unit),
        unit,
    )


def derived_of(filter: Any, params: Any, unit: str = "") -> tuple[Quantity, ...]:
    """Numbers that follow from a filter's parameters, by its ``derive`` and its ``linear``."""
    found = a_sample(filter, params)
    facts = {name: fact for name, (_, fact) in found.items()}
    return _quantities(facts, {name: value for name, (value, _) in found.items()}, unit)


def held_of(filter: Any, params: Any, unit: str = "") -> tuple[Quantity, ...]:
    """The filter's own parameters, as it declares them."""
    filter = bare(filter)
    if not hasattr(filter, "params"):
        return ()
    return _quantities(parameter_facts(filter), values_of(filter, params), unit)


def _quantities(
    facts: Mapping[str, Any], values: Mapping[str, Any], unit: str
) -> tuple[Quantity, ...]:
    """Numbers with their facts; one that is not finite does not exist and is left out."""
    arrays = {name: np.asarray(value, float) for name, value in values.items()}
    return tuple(
        Quantity(name, array, in_unit(facts[name].unit, unit), facts[name].meaning)
        for name, array in arrays.items()
        if np.isfinite(array).all()
    )


def quantities_of(
    space: Space, solution: Solution, filter: Any, params: Any, what: Exported
) -> tuple[Quantity, ...]:
    """The quantities to export: a solution's parameters, the filter's, and what follows."""
    tuned = _tuned(space, solution)
    return once((*tuned, *held_of(filter, params, what.unit), *what.derived(params)))


def _tuned(space: Space, solution: Solution) -> tuple[Quantity, ...]:
    """The parameters of a solution, with the units and meanings that the space has for them."""
    meanings = {name: parameter.meaning for name, parameter in space.parameters}
    return tuple(
        Quantity(name, p.value, p.unit, meanings.get(name, ""))
        for name, p in solution.parameters.items()
    )


def once(quantities: Iterable[Quantity]) -> tuple[Quantity, ...]:
    """Every name once; where names differ in case only, the later one is renamed."""
    found: dict[str, Quantity] = {}
    for quantity in quantities:
        first = found.get(quantity.name.lower())
        if first is None:
            found[quantity.name.lower()] = quantity
        elif first.name != quantity.name:
            name = f"{quantity.name}_derived"
            found.setdefault(name.lower(), replace(quantity, name=name))
    return tuple(found.values())
