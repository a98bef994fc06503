"""Expressions of C as the entries of an interpreter: an operation on texts is a text."""

import math
from typing import Any, NamedTuple

import numpy as np

from tuner.code.expression import converted, limited, operation
from tuner.code.literal import Precision, literal
from tuner.code.operations import LOGIC, Kind, in_numpy, kind_of


class Text(NamedTuple):
    """An operand.

    Attributes:
        text: a name, a number, a call, or in brackets.
        kind: of the operand.
        number: its value, where that is known.
    """

    text: str
    kind: Kind
    number: float | None = None


class Texts:
    """The algebra of operands.

    Args:
        precision: of real numbers.
    """

    def __init__(self, precision: Precision) -> None:
        self.precision = precision

    def constant(self, value: Any) -> Text:
        """A number as an operand."""
        kind = kind_of(value)
        text = literal(value, kind, self.precision)
        return Text(f"({text})" if text.startswith(("-", "(")) else text, kind, float(value))

    def apply(self, op: str, *entries: Text) -> Text:
        """One operation, without factors of 1 and terms of 0."""
        kinds: list[Kind] = [entry.kind for entry in entries]
        kind: Kind = "truth" if op in LOGIC else "real" if "real" in kinds else kinds[0]
        if kind == "real" and all(entry.number is not None for entry in entries):
            return self.constant(np.float64(in_numpy(op, *(entry.number for entry in entries))))
        found = self._simpler(op, entries, kind)
        if found is not None:
            return found
        text = operation(op, [entry.text for entry in entries], kinds, self.precision)
        return Text(text if _is_call(text) else f"({text})", kind)

    def _simpler(self, op: str, entries: tuple[Text, ...], kind: Kind) -> Text | None:
        """An equivalent with fewer operations; None where there is none."""
        if op == "ne" and entries[0] == entries[1] and entries[0].kind == "real":
            return self.apply("isnan", entries[0])
        for one, other in (entries, entries[::-1]) if len(entries) == 2 else ():
            if one.number is None:
                continue
            if (op, one.number) in (("add", 0), ("mul", 1)):
                return other
            if (op, one.number) == ("mul", 0):
                return one
            if op in ("max", "min") and kind == "real":
                return Text(f"({limited(op, other.text, one.text)})", kind)
        return self._by_number(op, entries[0], entries[-1].number) if kind == "real" else None

    def _by_number(self, op: str, entry: Text, number: float | None) -> Text | None:
        """An operation with a constant, simplified: less 0, or over a power of two."""
        if op == "sub" and number == 0:
            return entry
        if op == "div" and number and math.frexp(abs(number))[0] == 0.5:
            return self.apply("mul", entry, self.constant(np.float64(1 / number)))
        return None

    def choose(self, condition: Text, no: Text, yes: Text) -> Text:
        """One of two."""
        if condition.number is not None:
            return yes if condition.number else no
        asked = condition.text if condition.kind == "truth" else f"({condition.text} != 0)"
        return Text(f"({asked} ? {yes.text} : {no.text})", yes.kind)

    def convert(self, entry: Text, dtype: np.dtype) -> Text:
        """A conversion to another kind of number."""
        kind = kind_of(dtype)
        if kind == entry.kind:
            return entry
        if entry.number is not None:
            return self.constant(np.float64(entry.number).astype(dtype))
        if kind == "truth":
            zero = literal(0, entry.kind, self.precision)
            return Text(f"({entry.text} != {zero})", kind)
        return Text(f"({converted(entry.text, entry.kind, kind, self.precision)})", kind)


def _is_call(text: str) -> bool:
    head, _, rest = text.partition("(")
    if not head.isidentifier() or not rest.endswith(")"):
        return False
    depth = 1
    for k, letter in enumerate(rest):
        depth += {"(": 1, ")": -1}.get(letter, 0)
        if depth == 0:
            return k == len(rest) - 1
    return False
