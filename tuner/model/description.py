"""The content of a model document: a model with its noise, as expressions."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

from tuner.model.algebra import affine, made, names_in, total
from tuner.model.covariance import Covariance, Rows
from tuner.model.expression import ZERO, Node
from tuner.model.parameters import Parameter
from tuner.model.quantities import Quantity

Method: TypeAlias = Literal["kalman", "extended", "iterated", "unscented"]
METHODS: tuple[Method, ...] = ("kalman", "extended", "iterated", "unscented")
Time: TypeAlias = Literal["continuous", "discrete"]


@dataclass(frozen=True)
class Model:
    """A model with its noise: x' = f(x, u) + G w, z = h(x, u) + v.

    Attributes:
        name: of the model.
        title: a sentence about it.
        method: which filter it gets.
        iterations: linearisations of a measurement by an iterated filter.
        time: whether f is the rate of the state or its next value.
        parameters: that may be tuned.
        inputs: known signals.
        states: estimated quantities.
        groups: measured channels.
        f: n expressions.
        G: where the noise enters, n rows.
        Q: of the noise: spectral density, or covariance a sample.
        h: m expressions.
        R: of the measurements, ``(m, m)``.
        x0: where the states begin.
        P0: covariance of the start, n rows; 0 for unknown states.
        diffuse: indices of states that are unknown at the start.
        unobserved: states that may be shown by no measurement.
    """

    name: str
    title: str
    method: Method
    iterations: int
    time: Time
    parameters: tuple[Parameter, ...]
    inputs: tuple[Quantity, ...]
    states: tuple[Quantity, ...]
    groups: tuple[Quantity, ...]
    f: tuple[Node, ...]
    G: Rows
    Q: Rows
    h: tuple[Node, ...]
    R: Covariance
    x0: tuple[Node, ...]
    P0: Rows
    diffuse: tuple[int, ...]
    unobserved: tuple[str, ...]

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of the states."""
        return tuple(state.name for state in self.states)

    @cached_property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs in expressions."""
        return tuple(symbol for each in self.inputs for symbol in each.symbols)

    @cached_property
    def angles(self) -> tuple[bool, ...]:
        """Which of the m measured numbers are angles."""
        return tuple(group.angle for group in self.groups for _ in group.symbols)

    @cached_property
    def moved(self) -> tuple[Rows, tuple[Node, ...]] | None:
        """f as A x + c, n rows and n; None where it is not linear in the states."""
        return coefficients(self.f, self.state_names)

    @cached_property
    def seen(self) -> tuple[Rows, tuple[Node, ...]] | None:
        """h as H x + e, m rows and m; None where it is not linear in the states."""
        return coefficients(self.h, self.state_names)

    @cached_property
    def noise(self) -> Rows:
        """G Q G', n rows: what enters in a second, or in a sample."""
        spread = product(self.G, self.Q)
        return product(spread, tuple(zip(*self.G, strict=True)))

    @cached_property
    def linear(self) -> bool:
        """Whether the Kalman filter is exact for it."""
        noisy = any(self.holds(node, self.state_names) for row in self.noise for node in row)
        return self.moved is not None and self.seen is not None and not noisy

    @cached_property
    def driving(self) -> frozenset[str]:
        """The inputs that stay until their next sample; the others belong to a measurement."""
        nodes = (*self.f, *self.h, *(node for row in (*self.G, *self.Q) for node in row))
        return frozenset().union(*map(names_in, nodes)) & frozenset(self.input_names)

    @cached_property
    def steady(self) -> bool:
        """Whether f is linear in the states and one step of some length is like another."""
        if self.moved is None:
            return False
        nodes = [node for row in (*self.moved[0], *self.noise) for node in row]
        other = (*self.state_names, *self.input_names)
        return not any(self.holds(node, other) for node in nodes)

    @cached_property
    def kept(self) -> bool:
        """Whether a step is worked out once for all: it costs much, and does not change."""
        return self.steady and self.time == "continuous"

    @cached_property
    def steadily_seen(self) -> bool:
        """Whether h is linear in the states with coefficients that no input changes."""
        if self.seen is None:
            return False
        return not any(self.holds(node, self.input_names) for row in self.seen[0] for node in row)

    @cached_property
    def stepped(self) -> bool:
        """Whether a discrete model says how it depends on the sample time."""
        nodes = (*self.f, *(node for row in (*self.G, *self.Q) for node in row))
        return any(self.holds(node, ("dt",)) for node in nodes)

    @staticmethod
    def holds(node: Node, names: Sequence[str]) -> bool:
        """Whether an expression holds one of some names."""
        return bool(names_in(node) & frozenset(names))


def coefficients(
    nodes: Sequence[Node], names: Sequence[str]
) -> tuple[Rows, tuple[Node, ...]] | None:
    """Expressions as a matrix of coefficients of some names and what is left of each."""
    found = [affine(node, names) for node in nodes]
    parts = [each for each in found if each is not None]
    if len(parts) < len(found):
        return None
    rows = tuple(tuple(part[0].get(name, ZERO) for name in names) for part in parts)
    return rows, tuple(part[1] for part in parts)


def product(one: Rows, other: Rows) -> Rows:
    """The product of two matrices of expressions."""
    columns = tuple(zip(*other, strict=True))
    return tuple(
        tuple(
            total(made("*", a, b) for a, b in zip(row, column, strict=True)) for column in columns
        )
        for row in one
    )
