"""Units across an equation: what may be added, compared and put into a sine.

Angles count as bare numbers here, as a rate times a radius is a speed. A quantity whose unit is not
given may have any, and so may a number with digits of its own (9.81 is most likely m/s^2); small
whole numbers and halves, as in ``2*x/3``, are bare.
"""

import re
from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import TypeAlias

from tuner.data.units import Unit
from tuner.model.expression import COMPARISONS, Call, Name, Node, Number

Dimension: TypeAlias = tuple[Fraction, ...]
"""Powers of kg, m, s, A, K and of the measurement's own unit."""
_BASES = ("kg", "m", "s", "A", "K", "unit")
BARE: Dimension = (Fraction(0),) * len(_BASES)
SECOND: Dimension = tuple(Fraction(base == "s") for base in _BASES)
_BARE_NUMBERS = frozenset((0.5, 1.0, 1.5, 2.0, 3.0, 4.0))
_OF_BARE = frozenset(
    ("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log")
)
_GROUP = re.compile(r"\(([^()]*)\)\^(-?\d+)")


def unit_of(text: str) -> Unit:
    """A unit as a model may write it: as a log's, with powers of brackets, ``(m/s)^2/Hz``.

    Raises:
        ValueError: where it is none, with the near ones.

    >>> unit_of("(m/s)^2").powers == unit_of("m^2/s^2").powers
    True
    """
    return Unit.of(_GROUP.sub(_spread, text))


def _spread(match: re.Match[str]) -> str:
    """(m/s^2)^3 as m^3/s^6."""
    power, parts = int(match[2]), match[1].split("/")
    terms: list[str] = []
    for place, part in enumerate(parts):
        for word in part.split():
            base, _, own = word.partition("^")
            terms.append(f"{base}^{int(own or 1) * power * (-1 if place else 1)}")
    return " ".join(terms)


def dimension_of(text: str) -> Dimension:
    """The powers of a unit; ``unit`` in it, that of the measurement, is a base of its own.

    Raises:
        ValueError: where it is none.

    >>> dimension_of("rad/s") == dimension_of("Hz"), dimension_of("unit") == dimension_of("m")
    (True, False)
    """
    in_metres, in_ampere = (unit_of(re.sub(r"\bunit\b", base, text)).powers for base in ("m", "A"))
    own = in_metres[1] - in_ampere[1]
    kg, m, s, ampere, kelvin = (Fraction(power) for power in in_metres[:5])
    return kg, m - own, s, ampere, kelvin, Fraction(own)


def times(one: Dimension, other: Dimension, power: Fraction | int = 1) -> Dimension:
    """One times the other to some power."""
    return tuple(a + power * b for a, b in zip(one, other, strict=True))


def power(one: Dimension, exponent: Fraction | int) -> Dimension:
    """One to some power."""
    return tuple(exponent * a for a in one)


def words(dimension: Dimension) -> str:
    """A dimension for people to read.

    >>> words(dimension_of("m/s^2")), words(BARE)
    ('m/s^2', 'no unit')
    """
    above = [_term(b, p) for b, p in zip(_BASES, dimension, strict=True) if p > 0]
    below = [_term(b, -p) for b, p in zip(_BASES, dimension, strict=True) if p < 0]
    return "/".join([" ".join(above) or "1", *below]) if above or below else "no unit"


def _term(base: str, power: Fraction) -> str:
    return base if power == 1 else f"{base}^{power}"


class Dimensions:
    """Finds the dimension of expressions, and what in them does not go together.

    Args:
        known: dimension of each name; None where its unit was not given.
        tell: is called with a sentence for each contradiction.
    """

    def __init__(self, known: Mapping[str, Dimension | None], tell: Callable[[str], None]) -> None:
        self.known, self.tell = known, tell

    def of(self, node: Node) -> Dimension | None:
        """The dimension of an expression as it was written; None where it may be any."""
        if isinstance(node, Number):
            return BARE if node.value in _BARE_NUMBERS else None
        if isinstance(node, Name):
            return self.known.get(node.name)
        parts = [self.of(each) for each in node.arguments]
        if node.function in ("+", "-", "min", "max", "hypot", *COMPARISONS):
            return self._alike(node, node.arguments, parts)
        if node.function == "where":
            return self._alike(node, node.arguments[1:], parts[1:])
        if node.function == "**":
            return self._power(node, parts)
        return self._one(node, parts)

    def _one(self, node: Call, parts: list[Dimension | None]) -> Dimension | None:
        """Of products and functions."""
        first = parts[0]
        if node.function in ("neg", "abs"):
            return first
        if node.function in ("*", "/"):
            second = parts[1]
            if first is None or second is None:
                return None
            return times(first, second, 1 if node.function == "*" else -1)
        if node.function == "sqrt":
            return None if first is None else power(first, Fraction(1, 2))
        if node.function == "atan2":
            self._alike(node, node.arguments, parts)
        elif node.function in _OF_BARE and first not in (None, BARE):
            assert first is not None
            self.tell(f"takes {node.function} of {shown(node.arguments[0])} in {words(first)}")
        return BARE

    def _alike(
        self, node: Call, arguments: tuple[Node, ...], parts: list[Dimension | None]
    ) -> Dimension | None:
        given = [
            (each, part)
            for each, part in zip(arguments, parts, strict=True)
            if part is not None and not isinstance(each, Number)
        ]
        if len(given) == 2 and given[0][1] != given[1][1]:
            (one, its), (other, others) = given
            what = {"+": "adds", "-": "subtracts"}.get(node.function, f"takes {node.function} of")
            self.tell(f"{what} {shown(one)} in {words(its)} and {shown(other)} in {words(others)}")
            return None
        return given[0][1] if given else None

    def _power(self, node: Call, parts: list[Dimension | None]) -> Dimension | None:
        base, exponent = parts[0], node.arguments[1]
        if isinstance(exponent, Call) and exponent.function == "neg":
            inner = exponent.arguments[0]
            exponent = Number(-inner.value) if isinstance(inner, Number) else exponent
        if base is None or base == BARE:
            return base
        if isinstance(exponent, Number):
            return power(base, Fraction(exponent.value).limit_denominator(12))
        return None


def shown(node: Node) -> str:
    """An expression in few words."""
    if isinstance(node, Number):
        return f"{node.value:g}"
    if isinstance(node, Name):
        return node.name
    if node.function in ("+", "-", "*", "/", "**", *COMPARISONS):
        left, right = (_bracketed(each) for each in node.arguments)
        text = f"{left}{node.function}{right}"
    elif node.function == "neg":
        text = f"-{_bracketed(node.arguments[0])}"
    else:
        text = f"{node.function}({', '.join(shown(each) for each in node.arguments)})"
    return text if len(text) <= 40 else f"{text[:37]}..."


def _bracketed(node: Node) -> str:
    inside = isinstance(node, Call) and node.function in ("+", "-", "neg", *COMPARISONS)
    return f"({shown(node)})" if inside else shown(node)
