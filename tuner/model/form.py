"""Linear models for the rank test, the start of a search, and derived quantities."""

from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Channel, Measured, Transition
from filters.linear import LinearForm
from filters.small_linalg import matmul
from objectives.in_numpy import in_numpy
from tuner.model.algebra import names_in, separated
from tuner.model.covariance import Rows
from tuner.model.description import Model, coefficients
from tuner.model.evaluate import Values
from tuner.model.exact import Step
from tuner.model.expression import ONE, Name, Node
from tuner.model.filter import values
from tuner.model.linear import one_step


def linear_parts(model: Model) -> dict[str, Any]:
    """The methods ``linear`` and ``measured`` of a time-invariant model."""
    parts: dict[str, Any] = {}
    if model.steady and model.steadily_seen and (form := _Form.of(model)):
        parts["linear"] = lambda self, params: form.linear(params, self.dt)
        parts["measured"] = lambda self, inputs: form.measured(inputs)
    if model.steady:
        parts["derived"] = _derived(model)
        parts["derive"] = _derive
    return parts


def _derived(model: Model) -> dict[str, Channel]:
    n, m = len(model.f), len(model.h)
    found = {"Q": Channel("", f"covariance that enters in a sample, ({n}, {n})")}
    if _settles(model):
        found["K"] = Channel("", f"steady gain on a measurement, ({n}, {m})")
    return found


def _settles(model: Model) -> bool:
    """Whether a steady gain is possible: nothing depends on a record."""
    noises = (node for row in model.R.rows for node in row)
    known = not any(model.holds(node, model.input_names) for node in noises)
    return known and model.steadily_seen


def _derive(self: Any, params: Any) -> dict[str, Any]:
    """The covariance a sample, and the steady gain; NaN where there is none. Of one state plain."""
    model: Model = self.model
    step, *seen = in_numpy(_Matrices(model, self.dt), params)
    found: dict[str, Any] = {"Q": step.Q}
    if seen:
        found["K"] = _steady(step, seen[0], seen[1], self.dt)
    plain = len(model.f) == len(model.h) == 1
    return {name: value[0, 0] if plain else value for name, value in found.items()}


@dataclass(frozen=True)
class _Matrices:
    """The step of a model for its parameters; H and R too, where a steady gain is possible."""

    model: Model
    dt: float

    def __call__(self, params: Any) -> tuple[Any, ...]:
        """Step, H and R."""
        at = values(params, dt=self.dt)
        step = one_step(self.model, at, self.dt)
        if not _settles(self.model):
            return (step,)
        assert self.model.seen is not None
        return step, at.matrix(self.model.seen[0]), at.matrix(self.model.R.rows)


def _steady(step: Step, H: Array, R: Array, dt: float) -> np.ndarray:
    from objectives.linear_systems.model import LinearSystem
    from objectives.linear_systems.steady import steady_kalman

    try:
        return steady_kalman(LinearSystem(step.F, H, step.Q, R, dt=dt)).gain
    except ValueError:
        return np.full(H.T.shape, np.nan)


class _Form:
    """A model as z = H x + v with a known input and deviations, both from the record."""

    def __init__(
        self, model: Model, pushes: tuple[Node, ...], B: Rows | None, sigma: tuple[Node, ...] | None
    ) -> None:
        self.model, self.pushes, self.B, self.sigma = model, pushes, B, sigma

    @classmethod
    def of(cls, model: Model) -> "_Form | None":
        """The form; None where inputs, H or R do not follow from the record alone."""
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
        """F, the input's effect, Q, H and R."""
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
        """The measurements, the input's effect before each, and their deviations, of a record."""
        model = self.model
        assert model.seen is not None
        columns = {
            symbol: column
            for each in model.inputs
            for symbol, column in zip(each.symbols, _columns(each, inputs), strict=True)
        }
        held = {n: _filled_forward(v) if n in model.driving else v for n, v in columns.items()}
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
    """Factors of each variance that the record gives; () for none, None where it is no factor."""
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


def _filled_forward(column: np.ndarray) -> np.ndarray:
    """A column with each missing value replaced by the last one; 0 before the first."""
    last = np.maximum.accumulate(np.where(np.isnan(column), -1, np.arange(len(column))))
    return np.where(last < 0, 0.0, column[last])
