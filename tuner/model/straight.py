"""The Kalman filter of a linear model."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Measured, Transition, linearised
from filters.angles import difference
from filters.declared import Channel
from filters.diffuse import AnyEstimate, advance
from filters.linear import LinearForm
from filters.small_linalg import matmul
from tuner.model.algebra import names_in, separated
from tuner.model.description import Model, coefficients
from tuner.model.entries import Rows
from tuner.model.evaluate import Values
from tuner.model.exact import Step, exact
from tuner.model.expression import ONE, ZERO, Name, Node
from tuner.model.filter import (
    ModelFilter,
    ModelState,
    held_of,
    inputs_now,
    noisy,
    start,
    values,
)


def nilpotent(A: Rows) -> int | None:
    """The power of a matrix that is 0 whatever its entries are, by their places; None: none is."""
    entries = np.array([[node != ZERO for node in row] for row in A])
    power = entries
    for k in range(1, len(A) + 1):
        if not power.any():
            return k
        power = power.astype(int) @ entries > 0
    return None


def one_step(model: Model, at: Values, dt: Any) -> Step:
    """What one sample time does: exactly of a continuous model, of a discrete one as it says."""
    assert model.moved is not None
    A, _ = model.moved
    matrix, noise = at.matrix(A), at.matrix(model.noise)
    if model.time == "discrete":
        return Step(matrix, jnp.eye(len(A), dtype=at.dtype), noise)
    return exact(matrix, noise, dt, nilpotent(A))


class Straight(ModelFilter):
    """The Kalman filter of a linear model; measurements are taken one after another."""

    def init(self, params: Any) -> ModelState:
        """The start, and the step where it is the same at all times."""
        model, at = self.model, values(params, dt=self.dt)
        none = jnp.zeros((), at.dtype)
        held = (none,) * len(model.driving)
        step = one_step(model, at, self.dt) if model.kept and self.static else None
        return ModelState(start(model, params), held, step)

    def step(self, params: Any, state: ModelState, inputs: Any) -> tuple[ModelState, Any]:
        """Predict to this sample's time and take its measurements."""
        self.check_dt()
        model = self.model
        before = dict(zip(driving_names(model), state.held, strict=True))
        at = values(params, dt=self.dt, **before)
        known = state.step if model.kept and self.static else one_step(model, at, self.dt)
        assert known is not None
        ahead = advance(state.estimate, known.F, known.Q)
        assert model.moved is not None
        if any(node != ZERO for node in model.moved[1]):
            ahead = ahead._replace(x=ahead.x + matmul(known.push, at.vector(model.moved[1])))
        now = inputs_now(model, state.held, inputs)
        there = values(params, dt=self.dt, **now.inputs)
        R, z = noisy(model, there, now)
        found, innovation, variance = taken(model, there, ahead, R, z)
        # A step that is kept is kept as it came, so that the state has one form.
        moved = ModelState(found, held_of(model, now.inputs), state.step)
        return moved, self.said(found, innovation, variance)


def driving_names(model: Model) -> list[str]:
    """The inputs that stay, in their order."""
    return [name for name in model.input_names if name in model.driving]


def taken(
    model: Model, at: Values, ahead: AnyEstimate, R: Array, z: Array
) -> tuple[AnyEstimate, Array, Array]:
    """The estimate after the measurements, their innovations and variances."""
    assert model.seen is not None
    rows, rest = model.seen
    H = at.matrix(rows)
    offset = at.vector(rest)
    z = z - offset
    foretold = matmul(H, ahead.x)
    if any(model.angles):
        z = foretold + difference(z, foretold, model.angles)
    found, outputs = linearised(ahead, H, R, z, foretold)
    return found, outputs.innovation, outputs.variance


# --- what the rank test and the start of a search need --------------------------------------------


def linear_parts(model: Model) -> dict[str, Any]:
    """The methods ``linear`` and ``measured`` of a model that is the same at all times."""
    parts: dict[str, Any] = {}
    if model.steady and model.steadily_seen and (form := _Form.of(model)):
        parts["linear"] = lambda self, params: form.linear(params, self.dt)
        parts["measured"] = lambda self, inputs: form.measured(inputs)
    if model.steady:
        parts["derived"] = {"Q": Channel("", "covariance that enters in a sample")}
        parts["derive"] = lambda self, params: {
            "Q": one_step(model, values(params, dt=self.dt), self.dt).Q
        }
    return parts


class _Form:
    """A model as z = H x + v with a known push and deviations, of numbers known from the record."""

    def __init__(
        self, model: Model, pushes: tuple[Node, ...], B: Rows | None, sigma: tuple[Node, ...] | None
    ) -> None:
        self.model, self.pushes, self.B, self.sigma = model, pushes, B, sigma

    @classmethod
    def of(cls, model: Model) -> "_Form | None":
        """None where the record alone does not tell what is pushed, shown or how noisy it is."""
        assert model.moved is not None
        assert model.seen is not None
        inputs, known = model.input_names, frozenset((*model.input_names, "dt"))
        c, e = model.moved[1], model.seen[1]
        if any(names_in(node) - known for node in e):
            return None
        B: Rows | None = None
        pushes = c
        if any(names_in(node) - known for node in c):
            found = coefficients(c, inputs)
            if found is None:
                return None
            B = tuple((*row, rest) for row, rest in zip(*found, strict=True))
            if any(names_in(node) & set(inputs) for row in B for node in row):
                return None
            pushes = (*map(Name, inputs), ONE)
        sigma = _deviations(model)
        return None if sigma is None else cls(model, pushes, B, sigma or None)

    def linear(self, params: Any, dt: Any) -> LinearForm:
        """F, what pushes, Q, H and R."""
        model, at = self.model, values(params, dt=dt)
        assert model.seen is not None
        step = one_step(model, at, dt)
        push = step.push if self.B is None else matmul(step.push, at.matrix(self.B))
        R = self._variances(at)
        move = Transition(step.F, jnp.eye(len(step.F)), step.Q, push)
        return LinearForm(move, at.matrix(model.seen[0]), R)

    def _variances(self, at: Values) -> Array:
        model = self.model
        if self.sigma is None:
            found: Array = at.matrix(model.R.rows) if model.R.full else at.vector(model.R.variances)
            return found
        factors = [separated(node, model.input_names) for node in model.R.variances]
        own: Array = at.vector([each[0] for each in factors if each is not None])
        return own

    def measured(self, inputs: Any) -> Measured:
        """The measurements, what pushed before each, and their deviations, of a whole record."""
        model = self.model
        assert model.seen is not None
        columns = {
            symbol: column
            for each in model.inputs
            for symbol, column in zip(each.symbols, _columns(each, inputs), strict=True)
        }
        held = {n: _held(v) if n in model.driving else v for n, v in columns.items()}
        z = np.stack([c for g in model.groups for c in _columns(g, inputs)], axis=1)
        z = z - self._worked_out(model.seen[1], held, len(z))
        before = {name: np.concatenate([np.zeros(1), v[:-1]]) for name, v in held.items()}
        u = self._worked_out(self.pushes, before, len(z))
        if self.sigma is None:
            return Measured(z, u)
        with np.errstate(invalid="ignore"):
            squares = self._worked_out(self.sigma, held, len(z))
            seen = squares > 0
            return Measured(z, u, np.sqrt(np.where(seen, squares, 1.0)) * np.where(seen, 1.0, 0.0))

    def _worked_out(self, nodes: tuple[Node, ...], given: Any, count: int) -> np.ndarray:
        at = Values(given, np, np.float64)
        columns = [np.broadcast_to(at(node), (count,)) for node in nodes]
        return np.stack(columns, axis=1).astype(float)


def _deviations(model: Model) -> tuple[Node, ...] | None:
    """What of each variance the record tells; () for nothing, None where it is no factor."""
    inputs = model.input_names
    if not any(names_in(node) & set(inputs) for row in model.R.rows for node in row):
        return ()
    if model.R.full:
        return None
    factors = [separated(node, inputs) for node in model.R.variances]
    if any(each is None for each in factors):
        return None
    return tuple(each[1] for each in factors if each is not None)


def _columns(each: Any, inputs: Any) -> list[np.ndarray]:
    value = np.asarray(getattr(inputs, each.name), float)
    return [value[:, i] for i in range(len(each.axes))] if each.axes else [value]


def _held(column: np.ndarray) -> np.ndarray:
    """The last value where one is missing; 0 before the first."""
    last = np.maximum.accumulate(np.where(np.isnan(column), -1, np.arange(len(column))))
    return np.where(last < 0, 0.0, column[last])
