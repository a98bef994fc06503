"""Declarations of a filter: facts at the fields of its own tuples.

A filter class names its tuples: ``params``, ``inputs``, ``states`` and ``outputs``. Each is a
``NamedTuple`` whose fields are ``Annotated`` with a :class:`Param` or a :class:`Channel`; where the
filter takes or returns one plain array, it is a mapping of one name to its fact. Everything else
(spaces, starts, tables, meanings in exports, the command line) reads these facts.

They are facts and not decisions: what is free and within which limits stays in the space.
"""

import re
from collections.abc import Iterable, Mapping
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, TypeAlias, Union, get_args, get_origin, get_type_hints

import jax.numpy as jnp
from jax import Array

Kind: TypeAlias = Literal["number", "angle", "attitude", "detail"]
"""The error of a channel: a difference, a difference within half a turn, or the
angle between quaternions; a detail is not compared with a truth at all."""


Sensor: TypeAlias = Literal[
    "", "gyroscope", "gyroscope bias", "accelerometer", "accelerometer bias"
]
"""The sensor whose noise density a parameter is, or the density of whose bias's drift; in SI."""


class Param(NamedTuple):
    """A parameter of a filter.

    Attributes:
        unit: in SI, ``""`` for none; ``unit`` in it stands for that of the measurement.
        meaning: one short sentence.
        typical: a value to begin with; a matrix as nested tuples.
        low: where a search begins; None for no search, as for a start or a constant of nature.
        high: where it ends.
        smaller: what a smaller value does.
        larger: what a larger value does.
        shape: of the value that the filter takes; a single number fills it.
        channel: the optional input that it belongs to; without that it is idle and not tuned.
        sensor: whose noise density it is, or its root, so that it can be given as in data sheets.
        per_sample: whether it belongs to one sample time, and at another rate means something else.
    """

    unit: str
    meaning: str
    typical: float | tuple[Any, ...]
    low: float | None = None
    high: float | None = None
    smaller: str = ""
    larger: str = ""
    shape: tuple[int, ...] = ()
    channel: str = ""
    sensor: Sensor = ""
    per_sample: bool = False


class Channel(NamedTuple):
    """An input, a state or an output of a filter.

    Attributes:
        unit: in SI, ``""`` for none; ``unit`` in it stands for that of the measurement.
        meaning: one short sentence, with the frame where there is one.
        axes: names of its parts; none for a single number.
        kind: how its error is defined.
    """

    unit: str
    meaning: str
    axes: tuple[str, ...] = ()
    kind: Kind = "number"


Declared: TypeAlias = "type[Any] | Mapping[str, Any]"
"""A NamedTuple with annotated fields, or facts by name."""
PARTS = ("params", "inputs", "states", "outputs")


def parameter_facts(filter: Any) -> dict[str, Param]:
    """The facts of a filter's parameters, those of tuples inside its tuple included.

    Args:
        filter: a filter, or its class.

    Raises:
        ValueError: where it declares none.

    >>> from filters import Complementary
    >>> parameter_facts(Complementary)["tau"].unit
    's'
    """
    return dict(_facts(declaration(filter, "params"), Param))


def channel_facts(filter: Any, part: Literal["inputs", "states", "outputs"]) -> dict[str, Channel]:
    """The facts of a filter's inputs, states or outputs.

    Args:
        filter: a filter, or its class.
        part: which of them.

    Raises:
        ValueError: where it declares none.

    >>> from filters import Madgwick
    >>> channel_facts(Madgwick, "inputs")["gyr"].axes
    ('x', 'y', 'z')
    """
    facts = _facts(declaration(filter, part), Channel)
    own = getattr(bare(filter), "axes", None)  # of a filter that is made for some axes alone
    if isinstance(filter, type) or not isinstance(own, str):
        return facts
    kept = {name: tuple(axis for axis in fact.axes if axis in own) for name, fact in facts.items()}
    return {name: fact._replace(axes=kept[name]) for name, fact in facts.items()}


def components(name: str, unit: str, meaning: str, axes: Iterable[str]) -> dict[str, Channel]:
    """A vector among a filter's states, one by one: name_axis.

    >>> list(components("bias", "rad/s", "bias of the gyroscopes", "xyz"))
    ['bias_x', 'bias_y', 'bias_z']
    """
    return {f"{name}_{axis}": Channel(unit, f"{meaning}, {axis}") for axis in axes}


def optional(filter: Any) -> frozenset[str]:
    """The inputs that a filter can do without: those of its tuple that are None by default."""
    inputs = declaration(filter, "inputs")
    defaults = getattr(inputs, "_field_defaults", {})
    facts = _facts(inputs, Channel)
    return frozenset(name for name, value in defaults.items() if value is None and name in facts)


def optional_groups(filter: Any) -> tuple[frozenset[str], ...]:
    """The parameters of tuples inside a filter's tuple that may be None: given all, or none."""
    declared = declaration(filter, "params")
    if isinstance(declared, Mapping):
        return ()
    hints = get_type_hints(declared, include_extras=True).values()
    inner = (_tuple_in(hint) for hint in hints if NoneType in get_args(hint))
    return tuple(frozenset(_facts(each, Param)) for each in inner if each is not None)


def assembled(filter: Any, values: Mapping[str, Any]) -> Any:
    """The parameters that ``init`` and ``step`` take, from values by name.

    Args:
        filter: a filter, or its class.
        values: by the names of :func:`parameter_facts`; a single number fills the shape declared.
            Tuples inside the filter's tuple are None where none of their values is given.

    Raises:
        ValueError: for a missing value.
    """
    return _assembled(declaration(filter, "params"), values)


def values_of(filter: Any, params: Any) -> dict[str, Array]:
    """The parameters of a filter by the names it declares: the inverse of :func:`assembled`.

    >>> from filters import Complementary, ComplementaryGain
    >>> sorted(values_of(Complementary, ComplementaryGain(jnp.array(2.0), jnp.array(0.1))))
    ['angle0', 'tau']
    """
    declared = declaration(filter, "params")
    if isinstance(declared, Mapping):
        return dict.fromkeys(declared, params)
    return _values(declared, params)


def inputs_of(filter: Any, channels: Mapping[str, Any]) -> Any:
    """The inputs of ``step``, from channels by name, time first; None for those left out."""
    inputs = declaration(filter, "inputs")
    if isinstance(inputs, Mapping):
        (name,) = inputs
        return channels[name]
    return inputs(**{name: channels.get(name) for name in _facts(inputs, Channel)})


def output(filter: Any, outputs: Any, name: str) -> Array:
    """The output of a name, from the outputs of the filter."""
    if isinstance(declaration(filter, "outputs"), Mapping):
        alone: Array = outputs
        return alone
    part: Array = getattr(outputs, name)
    return part


def bare(filter: Any) -> Any:
    """The filter inside those that take its parameters as they are: Timed and Lanes."""
    while getattr(filter, "same_params", False) and not isinstance(filter, type):
        filter = filter.filter
    return filter


OWN = re.compile(r"\bunit\b(?=\^(\d+))?")
"""The placeholder for the measurement's own unit in a declared one."""


def in_unit(declared: str, own: str) -> str:
    """A declared unit for measurements of some unit; "" leaves it as it is.

    >>> in_unit("unit^2/s", "m"), in_unit("unit^2", "m/s"), in_unit("1/s", "Pa")
    ('m^2/s', '(m/s)^2', '1/s')
    """
    compound = not own.isalpha()
    return (
        OWN.sub(lambda m: f"({own})" if compound and m[1] else own, declared) if own else declared
    )


def declaration(filter: Any, part: str) -> Declared:
    """The tuple or mapping that a filter declares for one of its parts.

    Raises:
        ValueError: where it declares none, or nothing about it.
    """
    filter = bare(filter)
    cls = filter if isinstance(filter, type) else type(filter)
    declared = getattr(filter, part, None)
    kind = Param if part == "params" else Channel
    if declared is None or not _facts(declared, kind):
        raise ValueError(
            f"{cls.__name__} declares no {part}; give the class an attribute {part}: a NamedTuple "
            f"whose fields are Annotated with a filters.{kind.__name__}"
        )
    found: Declared = declared
    return found


def _facts(declared: Declared, kind: type[Any]) -> dict[str, Any]:
    """Facts by name; of a tuple inside the tuple, its own."""
    if isinstance(declared, Mapping):
        return dict(declared)
    found: dict[str, Any] = {}
    for name, hint in get_type_hints(declared, include_extras=True).items():
        inner = _tuple_in(hint)
        if inner is not None:
            found |= _facts(inner, kind)
        for fact in getattr(hint, "__metadata__", ()):
            if isinstance(fact, kind):
                found[name] = fact
    return found


def _tuple_in(hint: Any) -> Any:
    """The NamedTuple that a hint is, or may be; None where it is something else."""
    ways = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    tuples = [way for way in ways if isinstance(way, type) and hasattr(way, "_fields")]
    return tuples[0] if tuples else None


def _assembled(declared: Declared, values: Mapping[str, Any]) -> Any:
    if isinstance(declared, Mapping):
        (name,) = declared
        return _filled(declared[name], values[name])
    made: dict[str, Any] = {}
    for name, hint in get_type_hints(declared, include_extras=True).items():
        inner = _tuple_in(hint)
        if inner is None:
            fact = next(f for f in hint.__metadata__ if isinstance(f, Param))
            if name not in values:
                raise ValueError(f"{declared.__name__} needs {name} ({fact.meaning})")
            made[name] = _filled(fact, values[name])
            continue
        may_be_none = NoneType in get_args(hint)
        given = not may_be_none or bool(_facts(inner, Param).keys() & values.keys())
        made[name] = _assembled(inner, values) if given else None
    return declared(**made)


def _values(declared: type[Any], params: Any) -> dict[str, Array]:
    found: dict[str, Array] = {}
    for name, hint in get_type_hints(declared, include_extras=True).items():
        inner, value = _tuple_in(hint), getattr(params, name)
        if value is not None:
            found |= _values(inner, value) if inner is not None else {name: value}
    return found


def _filled(fact: Param, value: Any) -> Array:
    array = jnp.asarray(value, float) if not isinstance(value, Array) else value
    return jnp.broadcast_to(array, fact.shape) if fact.shape and not array.ndim else array
