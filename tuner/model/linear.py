"""The Kalman filter of a linear model."""

from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import linearised
from filters.angles import difference
from filters.diffuse import AnyEstimate, advance
from filters.small_linalg import matmul
from tuner.model.covariance import Rows
from tuner.model.description import Model
from tuner.model.evaluate import Values
from tuner.model.exact import Step, exact
from tuner.model.expression import ZERO
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
    """The power of a matrix that is 0 by its pattern of zeros; None where none is."""
    entries = np.array([[node != ZERO for node in row] for row in A])
    power = entries
    for k in range(1, len(A) + 1):
        if not power.any():
            return k
        power = power.astype(int) @ entries > 0
    return None


def one_step(model: Model, at: Values, dt: Any) -> Step:
    """One step: exact for a continuous model, as stated for a discrete one."""
    assert model.moved is not None
    A, _ = model.moved
    matrix, noise = at.matrix(A), at.matrix(model.noise)
    if model.time == "discrete":
        return Step(matrix, jnp.eye(len(A), dtype=at.dtype), noise)
    return exact(matrix, noise, dt, nilpotent(A))


class LinearFilter(ModelFilter):
    """The Kalman filter of a linear model; measurements are taken one after another."""

    def init(self, params: Any) -> ModelState:
        """The start, and the step where it is time-invariant."""
        model, at = self.model, values(params, dt=self.dt)
        none = jnp.zeros((), at.dtype)
        held = (none,) * len(model.driving)
        step = one_step(model, at, self.dt) if model.kept and self.static else None
        return ModelState(start(model, params), held, step)

    def step(self, params: Any, state: ModelState, inputs: Any) -> tuple[ModelState, Any]:
        """Predict to this sample's time and update with its measurements."""
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
        # A stored step stays as it is, so that the state has one structure.
        moved = ModelState(found, held_of(model, now.inputs), state.step)
        return moved, self.output_of(found, innovation, variance)


def driving_names(model: Model) -> list[str]:
    """The inputs that are held, in their order."""
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
    predicted = matmul(H, ahead.x)
    if any(model.angles):
        z = predicted + difference(z, predicted, model.angles)
    found, outputs = linearised(ahead, H, R, z, predicted)
    return found, outputs.innovation, outputs.variance
