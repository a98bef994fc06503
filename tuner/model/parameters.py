"""The parameters of a model document: tuned ones with their ranges, and fixed ones."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tuner.model.findings import Findings
from tuner.model.lines import Path
from tuner.model.quantities import named, number, text, unit_in_si

WIDE = 1e6
"""Factor from a start to the default ends of its search."""


@dataclass(frozen=True)
class Parameter:
    """A parameter, tuned, or fixed where it has no range; in SI."""

    name: str
    unit: str | None
    meaning: str
    typical: float
    low: float | None
    high: float | None
    smaller: str
    larger: str


def read_parameters(findings: Findings, document: Mapping[str, Any]) -> tuple[Parameter, ...]:
    """The parameters, their numbers in SI."""
    tables = named(findings, document, "parameters")
    if not tables and not len(findings):
        findings.add(("parameters",), "is missing; name the parameters to be tuned, as in q = {}")
    return tuple(_parameter(findings, name, table) for name, table in tables.items())


_OF_PARAMETER = ("start", "low", "high", "fixed", "unit", "meaning", "smaller", "larger")


def _parameter(findings: Findings, name: str, table: Mapping[str, Any]) -> Parameter:
    path: Path = ("parameters", name)
    findings.keys(path, table, _OF_PARAMETER)
    si, factor = unit_in_si(findings, path, table)
    numbers = {
        key: number(findings, (*path, key), table[key], factor)
        for key in ("start", "low", "high", "fixed")
        if key in table
    }
    typical, low, high = _range(findings, path, numbers)
    texts = (text(findings, path, table, key) for key in ("meaning", "smaller", "larger"))
    meaning, smaller, larger = texts
    return Parameter(name, si, meaning or name, typical, low, high, smaller, larger)


def _range(
    findings: Findings, path: Path, given: Mapping[str, float]
) -> tuple[float, float | None, float | None]:
    """The start and the ends of a search; by default positive, of any size."""
    if "fixed" in given:
        if len(given) > 1:
            findings.add(path, "is fixed, and has a start or a range as well; give one of them")
        return given["fixed"], None, None
    start, low, high = (given.get(key) for key in ("start", "low", "high"))
    if (low is None) != (high is None):
        findings.add(path, "has one end of its search; give both, low and high")
        return start or 1.0, None, None
    if low is None or high is None:
        if start is not None and start <= 0:
            findings.add(path, f"begins at {start:g}; give low and high for what may be negative")
            return start, None, None
        start = 1.0 if start is None else start
        return start, start / WIDE, start * WIDE
    if start is None:
        start = math.sqrt(low) * math.sqrt(high) if 0 < low < high else (low + high) / 2
    if not low < start < high:
        findings.add(path, f"begins at {start:g}, which is not between {low:g} and {high:g}")
    return start, low, high
