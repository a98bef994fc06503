"""The named quantities of a model document: inputs, states, and their common entries."""

import keyword
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tuner.model.dimension import Dimension, dimension_of, unit_of
from tuner.model.expression import CONSTANTS, FUNCTIONS
from tuner.model.findings import Findings, brief
from tuner.model.lines import Path

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,59}")
"""Names of models, which become those of classes and files."""
MOST = 60
"""The most quantities of a kind: a filter cannot run a larger model in a sample."""
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_TAKEN = frozenset((*FUNCTIONS, *CONSTANTS, "dt", "t", "unit", "inf", "nan"))
_OUTPUTS = frozenset(("innovation", "variance", "P", "count", "index"))
"""Outputs of a filter beside its states, and attributes of every tuple."""


@dataclass(frozen=True)
class Quantity:
    """An input or a state; an input of several axes has one name in expressions for each."""

    name: str
    unit: str | None
    meaning: str
    axes: tuple[str, ...] = ()
    angle: bool = False

    @property
    def symbols(self) -> tuple[str, ...]:
        """Its names in expressions."""
        return tuple(f"{self.name}_{axis}" for axis in self.axes) or (self.name,)


def named(findings: Findings, document: Mapping[str, Any], part: str) -> dict[str, Any]:
    """The tables of one kind of quantity by name; a list of names stands for empty ones."""
    given = document.get(part, {})
    if isinstance(given, list) and all(isinstance(each, str) for each in given):
        given = {name: {} for name in given} if len({*given}) == len(given) else given
    if not isinstance(given, Mapping):
        findings.add((part,), f"is {brief(given)}; give a table, or a list of different names")
        return {}
    if len(given) > MOST:
        findings.add((part,), f"has {len(given)} names, and {MOST} is the most")
        return {}
    found = {}
    for name, table in given.items():
        if wrong := _no_name(name):
            findings.add((part, name), wrong)
        found[name] = findings.table((part, name), table)
    return found


def _no_name(name: str) -> str:
    if not _NAME.fullmatch(name) or keyword.iskeyword(name):
        return f"{brief(name)} is not a name; take letters, digits and _, beginning with a letter"
    if name in _TAKEN:
        return f"{name!r} has a meaning of its own in expressions; take another name"
    return ""


def inputs(findings: Findings, document: Mapping[str, Any]) -> tuple[Quantity, ...]:
    """The known inputs."""
    found = []
    for name, table in named(findings, document, "inputs").items():
        findings.keys(("inputs", name), table, ("unit", "meaning", "axes"))
        found.append(quantity(findings, ("inputs", name), table))
    return tuple(found)


def states(findings: Findings, document: Mapping[str, Any]) -> tuple[Quantity, ...]:
    """The states, in their order."""
    tables = named(findings, document, "states")
    if not tables and not len(findings):
        findings.add(("states",), "is missing; name the estimated states, as in states = ['level']")
    found = []
    for name, table in tables.items():
        path = ("states", name)
        findings.keys(path, table, ("unit", "meaning", "angle"))
        if name in _OUTPUTS:
            findings.add(path, f"{name!r} is an output of every filter; take another name")
        found.append(quantity(findings, path, table))
    return tuple(found)


def quantity(findings: Findings, path: Path, table: Mapping[str, Any]) -> Quantity:
    """An input, a state or a measurement, in SI."""
    si, factor = unit_in_si(findings, path, table)
    if factor != 1.0:
        findings.add(
            path,
            f"is in {unit_text(table)}, and a model computes in SI, to which a log is converted; "
            f"give {si or 'no unit'}",
        )
    angle = flag(findings, path, table)
    meaning = text(findings, path, table, "meaning")
    return Quantity(str(path[-1]), si, meaning, axes_of(findings, path, table), angle)


def flag(findings: Findings, path: Path, table: Mapping[str, Any]) -> bool:
    """Whether a quantity is an angle, whose errors lie within half a turn."""
    value = table.get("angle", False)
    if not isinstance(value, bool):
        findings.add((*path, "angle"), f"is {brief(value)}; give true or false")
        return False
    if value and table.get("unit", "rad") not in ("rad", "deg"):
        findings.add((*path, "angle"), f"is true, and the unit is {unit_text(table)}, not rad")
    return bool(value)


def axes_of(findings: Findings, path: Path, table: Mapping[str, Any]) -> tuple[str, ...]:
    """Names of the parts of a vector."""
    axes = table.get("axes", [])
    if (
        not isinstance(axes, list)
        or len(axes) > MOST
        or not all(isinstance(axis, str) and _NAME.fullmatch(axis) for axis in axes)
        or len({*axes}) < len(axes)
    ):
        findings.add((*path, "axes"), f"is {brief(axes)}; give names, as in axes = ['x', 'y']")
        return ()
    return tuple(axes)


def text(findings: Findings, path: Path, table: Mapping[str, Any], key: str) -> str:
    """A short text; "" where there is none."""
    value = table.get(key, "")
    if not isinstance(value, str) or len(value) > 500:
        findings.add((*path, key), f"is {brief(value)}; give a short text in quotes")
        return ""
    return " ".join(value.split())


def number(findings: Findings, path: Path, value: Any, factor: float = 1.0) -> float:
    """A finite number; 1 where it is not one."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        findings.add(path, f"is {brief(value)}; give a number")
        return 1.0
    try:
        found = float(value) * factor
    except OverflowError:
        found = math.inf
    if not math.isfinite(found):
        findings.add(path, f"is {brief(value)}; give a finite number")
        return 1.0
    return found


def unit_text(table: Mapping[str, Any]) -> str:
    """The unit as it was written."""
    return brief(table.get("unit"))


def unit_in_si(
    findings: Findings, path: Path, table: Mapping[str, Any]
) -> tuple[str | None, float]:
    """The unit in SI, None where none is given, and the factor to it."""
    if "unit" not in table:
        return None, 1.0
    written = table["unit"]
    if not isinstance(written, str) or len(written) > 60:
        findings.add((*path, "unit"), f"is {brief(written)}; give a unit in quotes, as in 'm/s'")
        return None, 1.0
    if re.search(r"\bunit\b", written):
        return _own(findings, path, written), 1.0
    try:
        unit = unit_of(written)
        dimension_of(written)
    except ValueError as error:
        findings.add((*path, "unit"), str(error))
        return None, 1.0
    if unit.offset:
        return written, 1.0  # a temperature in degrees: its steps are those of the kelvin
    return (written if unit.factor == 1.0 else unit.si), unit.factor


def _own(findings: Findings, path: Path, written: str) -> str | None:
    try:
        dimension_of(written)
    except ValueError as error:
        findings.add((*path, "unit"), str(error))
        return None
    return written


def dimension(unit: str | None) -> Dimension | None:
    """The dimension of a unit; None where none was given."""
    return None if unit is None else dimension_of(unit)
