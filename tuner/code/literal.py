"""Numbers as C literals."""

from typing import Any, Literal, TypeAlias

import numpy as np

from tuner.code.operations import Kind

Precision: TypeAlias = Literal["double", "float"]


def literal(value: Any, kind: Kind, precision: Precision) -> str:
    """The shortest text that denotes the number exactly.

    >>> literal(0.1, "real", "float"), literal(-2.0, "real", "double"), literal(3, "whole", "float")
    ('0.1f', '-2.0', '3')
    """
    if kind == "truth":
        return "true" if value else "false"
    if kind == "whole":
        return str(int(value))
    number = np.float32(value) if precision == "float" else np.float64(value)
    if np.isnan(number):
        return f"({precision})NAN"
    if np.isinf(number):
        return f"({precision}){'-' if number < 0 else ''}INFINITY"
    return f"{number!s}f" if precision == "float" else repr(float(number))


def type_of(kind: Kind, precision: Precision) -> str:
    """The type's name in C."""
    return {"real": precision, "truth": "bool", "whole": "int"}[kind]
