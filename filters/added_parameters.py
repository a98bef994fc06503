"""Classes of filters made of other classes: the same filter with more parameters."""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, field, fields, make_dataclass
from typing import Annotated, Any, ClassVar, NamedTuple, cast, get_type_hints

from filters.declared import Param, channel_facts


class WithParameters:
    """Base of the classes that :func:`with_parameters` makes; their fields are those of the filter.

    Attributes:
        base: class of the filter inside.
        recipe: the function that makes the class from a filter's, and its other arguments.
    """

    base: ClassVar[type[Any]]
    recipe: ClassVar[tuple[Callable[..., type[Any]], tuple[Any, ...]]]

    def __post_init__(self) -> None:
        self.inner()  # whose making checks the fields

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by the function that made the class, which another process calls again."""
        return _again, (*self.recipe, self.base, self._fields())

    def inner(self) -> Any:
        """The filter inside."""
        return self.base(**self._fields())

    def given(self, channels: frozenset[str]) -> Any:
        """This filter for the channels that are there."""
        inner = self.inner()
        return self.of(inner.given(channels)) if hasattr(inner, "given") else self

    @classmethod
    def of(cls, inner: Any) -> Any:
        """This filter around another one of its base."""
        return cls(**{each.name: getattr(inner, each.name) for each in fields(inner)})

    @classmethod
    def within(cls, params: Any) -> Any:
        """The parameters of the filter inside."""
        own = cls.base.params
        return own(**{name: getattr(params, name) for name in own._fields})

    def derive(self, params: Any) -> dict[str, Any]:
        """The variance per sample of the filter inside; its other derived numbers do not hold."""
        if not hasattr(self.base, "derive"):
            return {}
        return {n: v for n, v in self.inner().derive(self.within(params)).items() if n == "Q"}

    def _fields(self) -> dict[str, Any]:
        made: Any = self
        return {each.name: getattr(self, each.name) for each in fields(made)}


def with_parameters(
    base: type[Any],
    kind: type[WithParameters],
    facts: Mapping[str, tuple[Any, Param]],
    recipe: tuple[Callable[..., type[Any]], tuple[Any, ...]],
) -> type[Any]:
    """The class of a filter with more parameters.

    Args:
        base: the filter's class, which declares its facts.
        kind: the class with ``init`` and ``step``.
        facts: of the parameters that are added to its own or replace some, each with its type.
        recipe: the function that makes this class from ``base`` and more arguments, and these.
    """
    hints = get_type_hints(base.params, include_extras=True)
    hints |= {name: Annotated[hint, fact] for name, (hint, fact) in facts.items()}
    derived = {n: fact for n, fact in getattr(base, "derived", {}).items() if n == "Q"}
    given = {
        "base": base,
        "recipe": recipe,
        "params": cast("Any", NamedTuple)(f"{base.params.__name__}And", list(hints.items())),
        "inputs": base.inputs,
        "outputs": base.outputs,
        "states": base.states,
        "derived": derived,
        "__doc__": kind.__doc__,
    }
    own = [(f.name, f.type, field() if f.default is MISSING else f.default) for f in fields(base)]
    name = f"{kind.__name__.lstrip('_')}{base.__name__}"
    return make_dataclass(name, own, bases=(kind,), frozen=True, namespace=given)


def require_channel(base: type[Any], part: str, why: str) -> None:
    """Refuse a filter that lacks the input that an addition needs.

    Raises:
        ValueError: where its inputs have no channel of that name.
    """
    if part not in channel_facts(base, "inputs"):
        raise ValueError(
            f"{base.__name__} takes no deviation of each measurement ({part}), so {why}; take "
            "local-level, constant-velocity or constant-acceleration"
        )


def _again(make: Callable[..., type[Any]], more: tuple[Any, ...], base: type[Any], own: Any) -> Any:
    return make(base, *more)(**own)
