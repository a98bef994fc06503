"""A Kalman filter for the user's own model, as a class that declares its facts."""

from collections.abc import Callable, Mapping
from dataclasses import make_dataclass
from typing import Annotated, Any, ClassVar, NamedTuple, TypeAlias, cast

import jax.numpy as jnp
from jax import Array

from filters.declared import Channel, Param
from filters.linear import LinearForm, LinearKalman, Measured
from filters.small_linalg import matmul
from filters.validate import check_setup

Build: TypeAlias = Callable[[dict[str, Array], Any], Any]
"""From parameters by name and the sample time, s, to a filter's own, such as a LinearModel."""
DETAILS = ("innovation", "variance", "P")


class HeldState(NamedTuple):
    """State of a filter with known inputs.

    Attributes:
        inner: the filter's own state.
        known: the last value of each known input, ``(q,)``; 0 before the first.
    """

    inner: Any
    known: Array


class Parametrised:
    """Common part of the classes that :func:`parametrised` makes.

    Attributes:
        filter: the filter inside.
        model: makes its parameters from values by name and the sample time.
        dt: sample time, s.
    """

    filter: ClassVar[Any]
    model: ClassVar[Any]
    known: ClassVar[tuple[str, ...]]
    measures: ClassVar[tuple[str, ...]]
    outputs: ClassVar[type[Any]]
    dt: float

    def __post_init__(self) -> None:
        check_setup(self)

    def made(self, params: Any) -> Any:
        """The parameters of the filter inside."""
        return self.model(params._asdict(), self.dt)

    def init(self, params: Any) -> HeldState:
        """The start of the filter inside."""
        none = jnp.zeros(len(self.known), jnp.result_type(*params))
        return HeldState(self.filter.init(self.made(params)), none)

    def step(self, params: Any, state: HeldState, inputs: Any) -> tuple[HeldState, Any]:
        """Move on by the last known inputs, and take the measurements; NaN is missing."""
        z = _together(self.measures, inputs)
        kind: Any = type(self.filter).inputs
        sample = kind(z=z, u=state.known if self.known else None)
        inner, out = self.filter.step(self.made(params), state.inner, sample)
        known = state.known
        if self.known:
            given = _together(self.known, inputs)
            known = jnp.where(jnp.isnan(given), known, given)
        states = (out.x[i] for i in range(len(self.outputs._fields) - len(DETAILS)))
        return HeldState(inner, known), self.outputs(*states, out.innovation, out.variance, out.P)


def parametrised(
    filter: Any,
    build: Build,
    *,
    params: Mapping[str, Param],
    measured: Mapping[str, Channel],
    states: Mapping[str, Channel],
    known: Mapping[str, Channel] | None = None,
    name: str = "",
) -> type[Any]:
    """The class of a filter for the user's own model, which ``tuner.fit`` takes as any other.

    Known inputs stay until the next one comes, and move the state on from then.

    Args:
        filter: :class:`filters.LinearKalman`, :class:`filters.ExtendedKalman`, or another that
            takes samples of ``z`` and ``u`` and returns ``x``, ``P``, ``innovation``, ``variance``.
        build: from parameters by name and the sample time to what the filter takes.
        params: the parameters.
        measured: the channels that ``z`` is made of, in this order.
        states: the states in their order; each is an output of its name.
        known: the channels that ``u`` is made of, ``(q,)``.
        name: of the class; that of ``build`` if left out.

    Raises:
        ValueError: for a name that comes twice, and a filter without samples of that kind.

    >>> from filters import LinearModel, Transition, run
    >>> def level(v, dt):
    ...     one = jnp.eye(1)
    ...     move = Transition(one, one, v["q"] * dt * one)
    ...     return LinearModel(move, one, v["R"][None], one, jnp.zeros(1))
    >>> Level = parametrised(
    ...     LinearKalman(diffuse=(0,)),
    ...     level,
    ...     params={"q": Param("m^2/s", "density", 1.0), "R": Param("m^2", "variance", 1.0)},
    ...     measured={"height": Channel("m", "measured height")},
    ...     states={"place": Channel("m", "height")},
    ... )
    >>> noise = Level.params(q=jnp.array(0.5), R=jnp.array(1.0))
    >>> run(Level(dt=1.0), noise, Level.inputs(jnp.array([8.0, jnp.nan, 9.0])))[1].place
    Array([8.        , 8.        , 8.66666667], dtype=float64)
    """
    inputs = dict(known or {})
    _check(filter, measured, states, inputs)
    called = name or "".join(w.capitalize() for w in getattr(build, "__name__", "own").split("_"))
    if not called.isidentifier():
        raise ValueError(f"{called!r} is not a name of a class; give it with name=")
    named = cast("Any", NamedTuple)
    details = {
        "innovation": Channel(
            _unit(measured), "measured less predicted", _axes(measured), "detail"
        ),
        "variance": Channel(_square(measured), "of the innovation", _axes(measured), "detail"),
        "P": Channel("", "covariance of the states", tuple(states), "detail"),
    }
    given = {
        "filter": filter,
        "model": staticmethod(build),
        "known": tuple(inputs),
        "measures": tuple(measured),
        "params": named(f"{called}Parameters", _annotated(params)),
        "inputs": named(f"{called}Sample", _annotated({**measured, **inputs})),
        "outputs": named(f"{called}Outputs", _annotated({**states, **details})),
        "states": dict(states),
        "__doc__": getattr(build, "__doc__", None) or f"{type(filter).__name__} of {called}.",
        **(_linear_parts() if isinstance(filter, LinearKalman) else {}),
    }
    if isinstance(filter, LinearKalman) and inputs:
        del given["linear"], given["measured"]  # known inputs move it as well
    return make_dataclass(
        called, [("dt", float)], bases=(Parametrised,), frozen=True, namespace=given
    )


def _linear_parts() -> dict[str, Any]:
    """Methods that a linear model adds: its matrices, and the variance per sample."""

    def linear(self: Any, params: Any) -> LinearForm:
        """The model, for a step of dt."""
        model = self.made(params)
        return LinearForm(model.transition, model.H, model.R)

    def measured(self: Any, inputs: Any) -> Measured:
        """The measurements of a whole record."""
        return Measured(_together(self.measures, inputs, lead=1))

    def derive(self: Any, params: Any) -> dict[str, Array]:
        """The covariance that enters in a sample."""
        move = self.made(params).transition
        return {"Q": matmul(matmul(move.G, move.Q), move.G.T)}

    derived = {"Q": Channel("", "covariance that enters in a sample")}
    return {"linear": linear, "measured": measured, "derive": derive, "derived": derived}


def _check(
    filter: Any,
    measured: Mapping[str, Channel],
    states: Mapping[str, Channel],
    known: Mapping[str, Channel],
) -> None:
    sample = getattr(type(filter), "inputs", None)
    if not {"z", "u"} <= set(getattr(sample, "_fields", ())):
        raise ValueError(
            f"{type(filter).__name__} takes no samples of z and u; give LinearKalman() or "
            "ExtendedKalman(...)"
        )
    twice = set(measured) & set(known) | set(states) & set(DETAILS)
    if twice:
        raise ValueError(f"the name {sorted(twice)[0]} comes twice; rename one")
    if not measured or not states:
        raise ValueError("there is nothing measured, or no state; name one of each at least")


def _together(names: tuple[str, ...], inputs: Any, lead: int = 0) -> Array:
    """Channels side by side, ``(..., m)``, after so many axes."""
    parts = [jnp.asarray(getattr(inputs, name)) for name in names]
    return jnp.concatenate([p if p.ndim > lead else p[..., None] for p in parts], axis=-1)


def _annotated(facts: Mapping[str, Any]) -> list[tuple[str, Any]]:
    return [(name, Annotated[Array, fact]) for name, fact in facts.items()]


def _axes(measured: Mapping[str, Channel]) -> tuple[str, ...]:
    """Names of the measurements."""
    return tuple(n for name, fact in measured.items() for n in (fact.axes or (name,)))


def _unit(measured: Mapping[str, Channel]) -> str:
    units = {fact.unit for fact in measured.values()}
    return units.pop() if len(units) == 1 else ""


def _square(measured: Mapping[str, Channel]) -> str:
    unit = _unit(measured)
    return unit and (f"{unit}^2" if unit.isalpha() else f"({unit})^2")
