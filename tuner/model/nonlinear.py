"""The extended, iterated and unscented filters of a nonlinear model."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
from jax import Array

from filters import ExtendedKalman, ExtendedModel, ExtendedSample, UnscentedKalman
from filters.small_linalg import matmul
from tuner.model.description import Model
from tuner.model.evaluate import Values
from tuner.model.exact import Step
from tuner.model.expression import ZERO
from tuner.model.filter import ModelFilter, ModelState, held_of, inputs_now, noisy, start, values
from tuner.model.linear import driving_names, one_step


class Known(NamedTuple):
    """Known quantities in the equations of a sample.

    Attributes:
        params: the filter's parameters.
        dt: sample time, s.
        step: of linear dynamics that are the same at all times, or None.
    """

    params: Any
    dt: Any
    step: Step | None


class Given(NamedTuple):
    """Inputs by name: those that drove the states until this sample, and those of this sample."""

    before: dict[str, Array]
    now: dict[str, Array]


@dataclass(frozen=True)
class Equations:
    """f, h and the noise of a model, in the form that nonlinear filters take.

    A continuous f is integrated over a sample in two steps of Runge and Kutta's method of order 4.
    The noise that enters meanwhile is carried to the end of the step by the Jacobians of these two,
    and its integral taken by Simpson's rule, which is of order 4 as well and of positive weights:
    the covariance has no negative direction. Where f is linear both are exact.
    """

    model: Model

    def move(self, known: Known, x: Array, u: Given) -> Array:
        """The state one sample later, ``(n,)``."""
        model, at = self.model, self._at(known, x, u.before)
        if model.time == "discrete":
            return at.vector(model.f)  # type: ignore[no-any-return]
        if model.moved is not None:
            return self._linear(known, x, u)
        return self._half_step(known, self._half_step(known, x, u), u)

    def disturb(self, known: Known, x: Array, u: Given) -> Array:
        """Covariance of the process noise of the step, ``(n, n)``."""
        model = self.model
        if model.time == "discrete":
            return self._density(known, x, u)
        if model.moved is not None and not self._state_dependent_noise:
            Q: Array = self._step(known, u).Q
            return Q
        middle = self._half_step(known, x, u)
        first, second = (jax.jacfwd(self._half_step, 1)(known, at, u) for at in (x, middle))
        end = self._half_step(known, middle, u)
        whole = matmul(second, first)
        begun, between, ended = (self._density(known, at, u) for at in (x, middle, end))
        carried = _around(whole, begun) + 4 * _around(second, between) + ended
        integral: Array = known.dt / 6 * carried
        return integral

    def measure(self, known: Known, x: Array, u: Given) -> Array:
        """The predicted measurement, ``(m,)``."""
        return self._at(known, x, u.now).vector(self.model.h)  # type: ignore[no-any-return]

    @property
    def _state_dependent_noise(self) -> bool:
        """Whether the process noise depends on the states."""
        nodes = (node for row in self.model.noise for node in row)
        return any(self.model.holds(node, self.model.state_names) for node in nodes)

    def _at(self, known: Known, x: Array, inputs: dict[str, Array]) -> Values:
        states = {name: x[i] for i, name in enumerate(self.model.state_names)}
        return values(known.params, dt=known.dt, **states, **inputs)

    def _density(self, known: Known, x: Array, u: Given) -> Array:
        found: Array = self._at(known, x, u.before).matrix(self.model.noise)
        return found

    def _step(self, known: Known, u: Given) -> Step:
        if known.step is not None:
            return known.step
        return one_step(self.model, values(known.params, dt=known.dt, **u.before), known.dt)

    def _linear(self, known: Known, x: Array, u: Given) -> Array:
        assert self.model.moved is not None
        step = self._step(known, u)
        ahead = matmul(step.F, x)
        if all(node == ZERO for node in self.model.moved[1]):
            return ahead
        at = values(known.params, dt=known.dt, **u.before)
        return ahead + matmul(step.push, at.vector(self.model.moved[1]))

    def _half_step(self, known: Known, x: Array, u: Given) -> Array:
        """The state half a sample later, by Runge and Kutta."""
        h = known.dt / 2

        def rate(at: Array) -> Array:
            return self._at(known, at, u.before).vector(self.model.f)  # type: ignore[no-any-return]

        k1 = rate(x)
        k2 = rate(x + h / 2 * k1)
        k3 = rate(x + h / 2 * k2)
        k4 = rate(x + h * k3)
        end: Array = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        return end


def _around(F: Array, Q: Array) -> Array:
    return matmul(matmul(F, Q), F.T)


class NonlinearFilter(ModelFilter):
    """A filter that linearises its model, or follows sigma points through it."""

    def init(self, params: Any) -> ModelState:
        """The start, and the step where dynamics are linear and the same at all times."""
        model, at = self.model, values(params, dt=self.dt)
        none = jnp.zeros((), at.dtype)
        step = one_step(model, at, self.dt) if model.kept and self.static else None
        return ModelState(start(model, params), (none,) * len(model.driving), step)

    def step(self, params: Any, state: ModelState, inputs: Any) -> tuple[ModelState, Any]:
        """Predict to this sample's time and take its measurements."""
        self.check_dt()
        model = self.model
        now = inputs_now(model, state.held, inputs)
        R, z = noisy(model, values(params, dt=self.dt, **now.inputs), now)
        before = dict(zip(driving_names(model), state.held, strict=True))
        known = Known(params, self.dt, state.step if model.kept and self.static else None)
        sample = ExtendedSample(z, Given(before, now.inputs))
        extended = ExtendedModel(known, R, state.estimate.x, state.estimate.P)
        found, outputs = atom(model).step(extended, state.estimate, sample)
        moved = ModelState(found, held_of(model, now.inputs), state.step)
        return moved, self.output_of(found, outputs.innovation, outputs.variance)


def atom(model: Model) -> Any:
    """The filter that the model's method names."""
    equations = Equations(model)
    functions = equations.move, equations.disturb, equations.measure
    angles = model.angles if any(model.angles) else ()
    if model.method == "unscented":
        turning = tuple(state.angle for state in model.states)
        return UnscentedKalman(*functions, angles=angles, turning=turning if any(turning) else ())
    often = model.iterations if model.method == "iterated" else 1
    return ExtendedKalman(*functions, model.diffuse, often, angles)
