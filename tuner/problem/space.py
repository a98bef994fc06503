"""The search space: named parameters in a fixed order, as one unconstrained vector z."""

from collections.abc import Mapping
from dataclasses import dataclass, is_dataclass, replace
from typing import Any

import numpy as np
from jax import Array

from filters.declared import Param, parameter_facts
from tuner.names import unknown
from tuner.problem.parameters import Bounded, Fixed, Parameter, Positive


@dataclass(frozen=True)
class Space:
    """Named parameters in a fixed order, and the unconstrained vector z they share.

    >>> from tuner.problem.parameters import Fixed, Positive
    >>> space = Space.of(R=Positive(init=1e-4, low=1e-8, high=1.0, unit="(rad/s)^2"), T=Fixed(0.01))
    >>> space.size, space.constrain(space.start())["T"].item()
    (1, 0.01)
    """

    parameters: tuple[tuple[str, Parameter], ...]

    @classmethod
    def of(cls, **parameters: Parameter) -> "Space":
        """A space of the parameters given by name."""
        return cls(tuple(parameters.items()))

    @classmethod
    def of_filter(cls, filter: Any, **overrides: Parameter | float | tuple[Any, ...]) -> "Space":
        """The space of a filter's parameters, as its facts suggest it.

        A parameter with a search range is free, positive where the range is, otherwise bounded;
        the rest keep their typical values.

        Args:
            filter: a filter that declares its parameters, or its class.
            overrides: other decisions by name: a parameter of any kind, or its fixed value, a
                number or nested tuples. Unit and meaning come from the facts where they are left
                out.

        Raises:
            ValueError: for an unknown name, with the near ones, a filter without facts, and facts
                whose typical value lies outside their range.

        >>> from filters import Complementary
        >>> space = Space.of_filter(Complementary, tau=Positive(2.0, low=0.1, high=50.0))
        >>> space.coordinates
        ['ln tau']
        """
        facts = parameter_facts(filter)
        for name in overrides:
            if name not in facts:
                raise unknown("parameter", name, facts)
        decided = {name: _decided(name, fact, overrides.get(name)) for name, fact in facts.items()}
        return cls(tuple(decided.items()))

    @property
    def names(self) -> tuple[str, ...]:
        """The parameters' names, in order."""
        return tuple(name for name, _ in self.parameters)

    @property
    def size(self) -> int:
        """Length of z."""
        return sum(parameter.size for _, parameter in self.parameters)

    @property
    def coordinates(self) -> list[str]:
        """The name of each entry of z."""
        return [label for name, p in self.parameters for label in p.coordinates(name)]

    def constrain(self, z: Array) -> dict[str, Array]:
        """The parameters that z ``(size,)`` stands for, by name; differentiable."""
        values, at = {}, 0
        for name, parameter in self.parameters:
            values[name] = parameter.constrain(z[at : at + parameter.size])
            at += parameter.size
        return values

    def unconstrain(self, values: Mapping[str, float | np.ndarray]) -> np.ndarray:
        """The z ``(size,)`` of parameters given by name; those left out keep their initial value.

        Raises:
            ValueError: for an unknown name, and for a value outside its constraint.
        """
        for name in values:
            if name not in self.names:
                raise unknown("parameter", name, self.names)
        parts: list[np.ndarray] = []
        for name, parameter in self.parameters:
            try:
                value = values.get(name)
                given = None if value is None else parameter.unconstrain(np.asarray(value, float))
                parts.append(parameter.start() if given is None else given)
            except ValueError as error:
                raise ValueError(f"{name} {error}") from None
        return np.concatenate(parts)

    def complete(self, values: Mapping[str, Any], whose: str) -> dict[str, np.ndarray]:
        """Parameters given by name, in order, exactly as they are.

        Args:
            values: by name.
            whose: what has them, for the message.

        Raises:
            ValueError: for unknown or missing names, or values outside their constraints.
        """
        self.unconstrain(values)
        missing = [name for name in self.names if name not in values]
        if missing:
            raise ValueError(f"{whose} has no value for {', '.join(missing)}: give them all")
        return {name: np.asarray(values[name], float) for name in self.names}

    def start(self) -> np.ndarray:
        """The z of the initial values, ``(size,)``."""
        return self.unconstrain({})

    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """The lowest and highest z, ``(size,)`` each."""
        boxes = [parameter.box() for _, parameter in self.parameters]
        return np.concatenate([low for low, _ in boxes]), np.concatenate([h for _, h in boxes])

    def limited(self) -> np.ndarray:
        """Which entries of z have limits that belong to the problem, ``(size,)`` of bool."""
        kinds = [np.full(parameter.size, parameter.limited) for _, parameter in self.parameters]
        return np.concatenate(kinds)

    def thresholds(self) -> np.ndarray:
        """Which entries of z are thresholds, ``(size,)`` of bool: gradients do not see them."""
        kinds = [
            np.full(p.size, isinstance(p, Positive) and p.threshold) for _, p in self.parameters
        ]
        return np.concatenate(kinds)

    def form(self) -> "Space":
        """The space as programs need it, without its box and its start, which follow from data."""
        return Space(tuple((name, parameter.form()) for name, parameter in self.parameters))

    def widened(self, factor: float) -> "Space":
        """The same parameters in a wider box: positive ones up and down by a factor.

        Limits of the problem itself (bounded and limited parameters) do not change.
        """
        wider = (
            (name, replace(p, low=p.low / factor, high=p.high * factor))
            if isinstance(p, Positive)
            else (name, p)
            for name, p in self.parameters
        )
        return Space(tuple(wider))

    def starts(self, count: int, seed: int) -> np.ndarray:
        """Starting points, ``(count, size)``: the initial values, then random points of the box."""
        low, high = self.box()
        random = np.random.default_rng(seed).uniform(low, high, (max(count - 1, 0), self.size))
        return np.vstack([self.start(), random])[:count]


def _decided(name: str, fact: Param, own: Any) -> Parameter:
    """One parameter as it was decided, or as the facts suggest it."""
    if own is None:
        return _suggested(name, fact)
    if not is_dataclass(own):
        value = own if isinstance(own, tuple) else float(own)
        return Fixed(value, fact.unit, meaning=fact.meaning)
    known: Any = own  # every kind of parameter is a frozen dataclass
    kept: Parameter = replace(
        known, unit=known.unit or fact.unit, meaning=known.meaning or fact.meaning
    )
    return kept


def _suggested(name: str, fact: Param) -> Parameter:
    if fact.low is None or fact.high is None:
        return Fixed(fact.typical, fact.unit, meaning=fact.meaning)
    kind = Positive if fact.low > 0 else Bounded
    try:
        begin = float(np.asarray(fact.typical))
        return kind(begin, fact.low, fact.high, fact.unit, meaning=fact.meaning)
    except (TypeError, ValueError) as error:
        raise ValueError(f"the facts of {name} suggest no parameter: {error}") from None
