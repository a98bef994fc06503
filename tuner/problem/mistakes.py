"""The message for an evaluation that failed: where in the user's code, what, the way out."""

import re
import textwrap
import traceback
from collections.abc import Callable
from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jax import errors

import filters
import objectives
from tuner.names import unknown

_FOREIGN = tuple(str(Path(str(module.__file__)).parent) for module in (jax, np))
_OURS = tuple(
    str(Path(str(place)).parent) for place in (filters.__file__, objectives.__file__, __file__)
)


def refusal(what: str, error: Exception) -> ValueError:
    """The error for code that cannot be evaluated, as one sentence.

    Args:
        what: what was evaluated, such as "Robot.step".
        error: what it raised.
    """
    frames = traceback.extract_tb(error.__traceback__)
    frame, ours = _frame(frames), frames[-1].filename.startswith(_OURS)
    code = "" if frame is None else (frame.line or "")
    place = ""
    if frame is not None:
        place = f" ({Path(frame.filename).name} line {frame.lineno}{code and ': '}{_short(code)})"
    if ours and isinstance(error, ValueError):  # one of our own sentences
        return ValueError(f"{what}{place if _is_own(frame) else ''}: {error}")
    return ValueError(f"{what}{place}: {_reason(error, code)}")


def _is_own(frame: traceback.FrameSummary | None) -> bool:
    """Whether a line is the user's."""
    return frame is not None and not frame.filename.startswith((*_OURS, *_FOREIGN))


def _frame(frames: traceback.StackSummary) -> traceback.FrameSummary | None:
    """The last line of the user's code; without one, of ours."""
    known = [f for f in frames if not f.filename.startswith(_FOREIGN)]
    own = [f for f in known if not f.filename.startswith(_OURS)]
    inside = [f for f in known if f.filename.startswith(_OURS[:2])]
    found = own or inside
    return found[-1] if found else None


def _short(code: str) -> str:
    return textwrap.shorten(code, 70, placeholder=" ...")


def _reason(error: Exception, code: str) -> str:
    for kind, reason in _REASONS.items():
        if isinstance(error, kind):
            found = reason(error, code)
            if found:
                return found
    first = str(error).strip().partition("\n")[0] or type(error).__name__
    return f"{textwrap.shorten(first, 200, placeholder=' ...').rstrip('.')}; mend that line"


def _bool(error: Exception, code: str) -> str:
    return (
        "Python's if, while, and, or, not, min and max cannot branch on a traced value; write "
        "jnp.where(condition, a, b), &, | and ~"
    )


def _array(error: Exception, code: str) -> str:
    call = re.search(r"\b(?:np|numpy)\.(?:linalg\.)?(\w+)", code)
    if call is None:
        return (
            "a traced value cannot be made an array or a number of NumPy; take jax.numpy, and "
            "leave conversions out"
        )
    if hasattr(np, call[1]) and isinstance(getattr(np, call[1]), type):
        return f"{call[0]}(...) makes a number of a traced value; leave it out"
    return f"{call[0]} is NumPy's and takes no traced value; write jnp.{call[0].partition('.')[2]}"


def _number(error: Exception, code: str) -> str:
    call = re.search(r"\b(float|int|complex|(?:np|math)\.\w+)\(", code)
    if call is None:
        return (
            "a traced value cannot be made a number of Python; leave the conversion out, or make "
            "what it depends on a field of the class"
        )
    if call[1].startswith("math."):
        return f"{call[1]} takes no traced value; write jnp.{call[1].removeprefix('math.')}"
    return f"{call[1]}(...) makes a number of a traced value; leave it out"


def _index(error: Exception, code: str) -> str:
    return (
        "a traced value is no index, size or count of Python; make it a field of the class, or "
        "take jnp.take and jnp.where"
    )


def _mask(error: Exception, code: str) -> str:
    return "an array cannot be cut by a traced mask; write jnp.where(mask, a, b)"


def _leaked(error: Exception, code: str) -> str:
    return (
        "a traced value of another evaluation is used, which was kept in a global or on an "
        "object; return it in the state"
    )


def _type(error: Exception, code: str) -> str:
    text = str(error)
    if "item assignment" in text or "item deletion" in text:
        return "an Array is not assigned to in place; write x = x.at[i].set(value)"
    if "not a valid JAX type" in text or "is not a valid JAX array type" in text:
        found = re.search(r"of type '?<?(?:class )?'?([\w.]+)", text)
        what = "something" if found is None else found[1].rpartition(".")[2]
        return f"{what} is neither an Array nor a tuple of them; make it a NamedTuple of Arrays"
    return ""


def _attribute(error: Exception, code: str) -> str:
    name, thing = getattr(error, "name", None), getattr(error, "obj", None)
    if name is None or thing is None:
        return ""
    if isinstance(thing, jax.core.Tracer | jax.Array):
        return (
            f"an Array of shape {thing.shape} has no field {name!r}; give the declared tuple, as "
            "in Data(Sample(...), truth), or leave the field out"
        )
    if isinstance(thing, tuple):
        return str(unknown(f"field of {type(thing).__name__}", name, getattr(thing, "_fields", ())))
    if isinstance(thing, dict):
        return f"a dict has no field {name!r}; write [{name!r}], or return a NamedTuple"
    if hasattr(thing, "step"):
        own = type(thing).__name__
        return f"{own} has no {name}; give the class a field {name}, as in {name}: float"
    return ""


def _frozen(error: Exception, code: str) -> str:
    return "a filter cannot be assigned to; what changes from sample to sample belongs to the state"


def _key(error: Exception, code: str) -> str:
    return f"there is no parameter {error}; the space has others, and build takes their names"


def _shape(error: Exception, code: str) -> str:
    first = str(error).strip().partition("\n")[0].rstrip(".")
    if "shape" not in first and "dimension" not in first and "axis" not in first:
        return ""
    return f"{textwrap.shorten(first, 200, placeholder=' ...')}; compare the shapes in that line"


_REASONS: dict[type[Exception], Callable[[Exception, str], str]] = {
    errors.TracerBoolConversionError: _bool,
    errors.TracerIntegerConversionError: _index,
    errors.NonConcreteBooleanIndexError: _mask,
    errors.TracerArrayConversionError: _array,
    errors.ConcretizationTypeError: _number,
    errors.UnexpectedTracerError: _leaked,
    FrozenInstanceError: _frozen,
    AttributeError: _attribute,
    KeyError: _key,
    TypeError: lambda error, code: _type(error, code) or _shape(error, code),
    ValueError: _shape,
}


def described(tree: Any) -> str:
    """The structure of a value, in words.

    >>> described((jax.ShapeDtypeStruct((3,), float), jax.ShapeDtypeStruct((), float)))
    'a tuple of 2'
    """
    if hasattr(tree, "_fields"):
        return f"{type(tree).__name__}({', '.join(tree._fields)})"
    if isinstance(tree, tuple | list):
        return f"a {type(tree).__name__} of {len(tree)}"
    if isinstance(tree, dict):
        return f"a dict of {', '.join(map(str, tree))}"
    if hasattr(tree, "shape"):
        return f"one Array {tree.shape}"
    return "None" if tree is None else type(tree).__name__
