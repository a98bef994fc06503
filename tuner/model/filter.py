"""The filter of a model: a class that declares its facts as those of the catalogue."""

from typing import Any, ClassVar, NamedTuple

import jax.numpy as jnp
from jax import Array

from filters.diffuse import AnyEstimate, begin
from filters.validate import check_setup
from tuner.model.algebra import names_in
from tuner.model.description import Model
from tuner.model.evaluate import Values
from tuner.model.exact import Step
from tuner.model.quantities import Quantity


class ModelState(NamedTuple):
    """The state of a model's filter.

    Attributes:
        estimate: of the states, with its covariance.
        held: the last value of each input that drives the states, ``()`` each; 0 before the first.
        step: of a linear model that is the same at all times; None of any other.
    """

    estimate: AnyEstimate
    held: tuple[Array, ...]
    step: Step | None


class Now(NamedTuple):
    """A sample's inputs by name, and its measurements.

    Attributes:
        inputs: the last value of each.
        absent: whether an input that belongs to a measurement is missing.
        z: measured numbers, ``(m,)``; NaN is missing.
    """

    inputs: dict[str, Array]
    absent: dict[str, Array]
    z: Array


def inputs_now(model: Model, held: tuple[Array, ...], inputs: Any) -> Now:
    """The inputs of a sample, with the last value where one is missing."""
    given, absent = {}, {}
    driving = [name for name in model.input_names if name in model.driving]
    last = dict(zip(driving, held, strict=True))
    for each in model.inputs:
        for symbol, value in zip(each.symbols, _parts(each, inputs), strict=True):
            missing = jnp.isnan(value)
            if symbol in last:
                given[symbol] = jnp.where(missing, last[symbol], value)
            else:
                given[symbol], absent[symbol] = jnp.where(missing, 1.0, value), missing
    z = [part for group in model.groups for part in _parts(group, inputs)]
    return Now(given, absent, jnp.stack(z))


def _parts(each: Quantity, inputs: Any) -> list[Array]:
    value = jnp.asarray(getattr(inputs, each.name))
    return [value[i] for i in range(len(each.axes))] if each.axes else [value]


def held_of(model: Model, inputs: dict[str, Array]) -> tuple[Array, ...]:
    """The inputs that are held until the next sample."""
    return tuple(inputs[name] for name in model.input_names if name in model.driving)


def values(params: Any, library: Any = jnp, **more: Any) -> Values:
    """Values for the symbols in expressions: parameters, and inputs or states by name."""
    given = params._asdict()
    return Values(given | more, library, jnp.result_type(*given.values()))


def start(model: Model, params: Any) -> AnyEstimate:
    """The estimate at the start, x0 and P0; states without either are unknown."""
    at = values(params)
    return begin(at.vector(model.x0), at.matrix(model.P0), model.diffuse)


def noisy(model: Model, at: Values, now: Now) -> tuple[Array, Array]:
    """R, ``(m,)`` or ``(m, m)``, and z without measurements of unknown variance."""
    R = _spread(model, at)
    held = [names_in(node) & frozenset(model.input_names) for node in model.R.variances]
    if not any(held):
        return R, now.z
    none = jnp.zeros((), bool)
    absent = [any_of([now.absent.get(name, none) for name in sorted(names)]) for names in held]
    variances = jnp.diagonal(R) if R.ndim == 2 else R
    seen = (variances > 0) & ~jnp.stack(absent)
    z = jnp.where(seen, now.z, jnp.nan)
    if R.ndim == 1:
        return jnp.where(seen, R, 1.0), z
    return jnp.where(seen[:, None] & seen, R, jnp.eye(len(R), dtype=R.dtype)), z


def any_of(flags: list[Array]) -> Array:
    """Whether any of the flags is set, ``()``."""
    return jnp.stack([jnp.zeros((), bool), *flags]).any()


def _spread(model: Model, at: Values) -> Array:
    found: Array = at.matrix(model.R.rows) if model.R.full else at.vector(model.R.variances)
    return found


class ModelFilter:
    """The common base of the classes of models.

    Attributes:
        model: what it is the filter of.
        dt: sample time, s.
    """

    model: ClassVar[Model]
    outputs: ClassVar[type[Any]]
    dt: float

    def __post_init__(self) -> None:
        check_setup(self)

    @property
    def static(self) -> bool:
        """Whether the sample time is a number, known before anything runs."""
        return isinstance(self.dt, int | float)

    def check_dt(self) -> None:
        """Refuse varying sample times of a model that does not depend on them.

        Raises:
            ValueError: with the remedy.
        """
        if self.static or self.model.time == "continuous" or self.model.stepped:
            return
        raise ValueError(
            f"{type(self).__name__} is a discrete model without dt, for steps of one length only; "
            "write its entries with dt, make it continuous, or give --rate HZ"
        )

    def output_of(self, estimate: AnyEstimate, innovation: Array, variance: Array) -> Any:
        """The outputs."""
        x = estimate.x
        return self.outputs(*(x[i] for i in range(len(x))), innovation, variance, estimate.P)
