"""Which of a filter's parameters are noises: by their units, or by what they do in its model."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple

import numpy as np

from filters.declared import Param, assembled, parameter_facts
from objectives.in_numpy import in_numpy
from tuner.data.unit_text import Powers, powers_of, raised

_SAME = 1e-9
Kind = Literal["density", "variance", "a sample", ""]


class NoiseParameter(NamedTuple):
    """A parameter that says how large a noise is.

    Attributes:
        name: of the parameter.
        square: its value, or the square of it where it is a root.
        powers: of the names in the square's unit; none where it has no unit.
        kind: ``density``: of what moves the state; ``variance``: of a measurement; ``a sample``:
            the variance of what moves the state in one sample.
        fact: what the filter declares of it.
    """

    name: str
    square: float
    powers: Powers
    kind: Kind
    fact: Param


def noise_parameters(
    filter: Any, values: Mapping[str, Any], units: Mapping[str, str]
) -> Iterator[NoiseParameter]:
    """The parameters that are noises.

    A variance's unit is a square, a density's a square in a number of seconds that is odd, and its
    root is known by the half. What is no density by its unit is known by the covariances of the
    filter's linear model, where it has one: by that to which they are proportional. What is not
    searched (starts, constants) does not count.

    Args:
        filter: the filter, for its sample time.
        values: of the parameters, by name.
        units: of the values.
    """
    for name, fact in parameter_facts(filter).items():
        powers = powers_of(units.get(name, fact.unit))
        if fact.low is None or name not in values or np.ndim(values[name]):
            continue
        value = float(values[name])
        if powers is None or not value > 0:
            continue
        root = powers.get("s", 0.0) % 1 == 0.5
        square = raised(powers, 2.0) if root else powers
        kind = _by_unit(square)
        if kind != "density" and hasattr(filter, "linear"):
            kind = _by_model(filter, values, name)
        if kind:
            kind = "a sample" if fact.per_sample else kind
            yield NoiseParameter(name, value**2 if root else value, square, kind, fact)


def _by_unit(square: Powers) -> Kind:
    others = [power for name, power in square.items() if name != "s"]
    if not others or any(power % 2 for power in others):
        return ""
    return "density" if square.get("s", 0.0) % 2 == 1 else "variance"


def _by_model(filter: Any, values: Mapping[str, Any], name: str) -> Kind:
    """Which covariances of the model a parameter scales."""
    found = [_covariances(filter, {**values, name: k * values[name]}) for k in (1, 2, 3)]
    (W, R), (W2, R2), (W3, R3) = found
    moves = [not np.array_equal(a, b) for a, b in ((W, W2), (R, R2))]
    straight = all(
        np.allclose(c - b, b - a, rtol=_SAME, atol=0) for a, b, c in ((W, W2, W3), (R, R2, R3))
    )
    if not straight or sum(moves) != 1:
        return ""
    if moves[1]:
        return "variance"
    longer = replace(filter, dt=2 * filter.dt)
    more = _covariances(longer, {**values, name: 2 * values[name]})[0]
    share = more - _covariances(longer, values)[0]
    return "a sample" if np.allclose(share, W2 - W, rtol=_SAME, atol=0) else "density"


@dataclass(frozen=True)
class _Linear:
    """The linear model of a filter at values by name."""

    filter: Any

    def __call__(self, values: Mapping[str, Any]) -> Any:
        """The model."""
        return self.filter.linear(assembled(self.filter, values))


def _covariances(filter: Any, values: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    form = in_numpy(_Linear(filter), dict(values))
    G = np.asarray(form.transition.G)
    return G @ np.asarray(form.transition.Q) @ G.T, np.asarray(form.R)
