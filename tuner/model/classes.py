"""From a model to the class of its filter, with the facts that every filter declares."""

from dataclasses import make_dataclass
from functools import cache
from typing import Annotated, Any, NamedTuple, cast

from jax import Array

from filters import Channel, Param
from tuner.model.description import Model
from tuner.model.filter import ModelFilter
from tuner.model.form import linear_parts
from tuner.model.linear import LinearFilter
from tuner.model.nonlinear import NonlinearFilter
from tuner.model.parameters import Parameter
from tuner.model.quantities import Quantity
from tuner.names import counted


def _reduced(self: Any) -> tuple[Any, ...]:
    """The pickled form of a generated class: another process generates it again."""
    return _again, (self.model, self.dt)


def _again(model: Model, dt: float) -> Any:
    return class_of(model)(dt)


@cache
def class_of(model: Model) -> type[Any]:
    """The filter class of a model; the same one every time."""
    if model.method == "kalman":
        kind: type[ModelFilter] = LinearFilter
        more = linear_parts(model)
    else:
        kind, more = NonlinearFilter, {}
    name = "".join(part.capitalize() for part in model.name.replace("-", "_").split("_"))
    name = name if name.isidentifier() else "Model"
    named = cast("Any", NamedTuple)
    given = {
        "model": model,
        "params": named(f"{name}Parameters", [_param(each) for each in model.parameters]),
        "inputs": named(f"{name}Sample", [_channel(each) for each in _channels(model)]),
        "outputs": named(f"{name}Outputs", _outputs(model)),
        "states": {each.name: _state(each) for each in model.states},
        "__doc__": model.title
        or f"The {model.method} filter of a model of {counted(len(model.f), 'state')}.",
        "__module__": __name__,
        "__reduce__": _reduced,
        "made_by": (class_of, model),
        **more,
    }
    return make_dataclass(name, [("dt", float)], bases=(kind,), frozen=True, namespace=given)


def _param(each: Parameter) -> tuple[str, Any]:
    fact = Param(
        each.unit or "", each.meaning, each.typical, each.low, each.high, each.smaller, each.larger
    )
    return each.name, Annotated[Array, fact]


def _channels(model: Model) -> list[Quantity]:
    return [*model.inputs, *model.groups]


def _channel(each: Quantity) -> tuple[str, Any]:
    """A channel's name and facts; without a unit any will do."""
    unit = "unit" if each.unit is None else each.unit
    return each.name, Annotated[Array, Channel(unit, each.meaning or each.name, each.axes)]


def _state(each: Quantity) -> Channel:
    kind: Any = "angle" if each.angle else "number"
    return Channel(each.unit or "", each.meaning or f"estimated {each.name}", (), kind)


def _outputs(model: Model) -> list[tuple[str, Any]]:
    symbols = tuple(symbol for group in model.groups for symbol in group.symbols)
    units = {"unit" if group.unit is None else group.unit for group in model.groups}
    unit = units.pop() if len(units) == 1 else ""
    square = "" if not unit else f"{unit}^2" if unit.isalpha() else f"({unit})^2"
    details = {
        "innovation": Channel(unit, "measured less predicted; 0 where missing", symbols, "detail"),
        "variance": Channel(
            square, "of the innovation; 0 where it does not count", symbols, "detail"
        ),
        "P": Channel("", "covariance of the states", model.state_names, "detail"),
    }
    states = {each.name: _state(each) for each in model.states}
    return [(name, Annotated[Array, fact]) for name, fact in (states | details).items()]
