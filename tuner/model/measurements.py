"""The measurements of a model document: channels, h, and R."""

from collections.abc import Mapping, Sequence
from typing import Any

from tuner.model.algebra import made, total
from tuner.model.covariance import Covariance
from tuner.model.entries import Entries
from tuner.model.expression import ZERO, Name, Node
from tuner.model.quantities import Quantity, named, quantity

_GROUP = ("unit", "meaning", "axes", "angle", "C", "H", "h", "R")
_SHOWN = ("h", "H", "C")


def groups(
    entries: Entries, document: Mapping[str, Any], inputs: Sequence[Quantity]
) -> tuple[Quantity, ...]:
    """The measured channels."""
    findings, taken = entries.findings, {each.name for each in inputs}
    tables = named(findings, document, "measurements")
    if not tables and not len(findings):
        findings.add(("measurements",), "is missing; name the measurements, as in z = {}")
    found = []
    for name, table in tables.items():
        path = ("measurements", name)
        findings.keys(path, table, _GROUP)
        if name in taken:
            findings.add(path, "is the name of an input as well")
        found.append(quantity(findings, path, table))
    return tuple(found)


def shows(
    entries: Entries,
    document: Mapping[str, Any],
    model: Mapping[str, Any],
    measured: Sequence[Quantity],
    states: Sequence[str],
) -> tuple[Node, ...] | None:
    """The m expressions h, of each group's own h, H or C, or of the model's; None where unsaid."""
    tables = _tables(document)
    own = any(key in table for table in tables.values() for key in _SHOWN)
    if not own:
        symbols = _symbols(measured)
        return _shown(entries, ("model",), model, symbols, symbols, states)
    if any(key in model for key in _SHOWN):
        entries.findings.add(("model",), "has h, H or C, and measurements have their own as well")
        return None
    found: list[Node] = []
    for group in measured:
        path, table = ("measurements", group.name), tables.get(group.name, {})
        names = group.axes or (group.name,)
        part = _shown(entries, path, table, group.symbols, names, states)
        found += part or (ZERO,) * len(group.symbols)
    return tuple(found)


def _shown(
    entries: Entries,
    path: tuple[str, ...],
    table: Mapping[str, Any],
    symbols: Sequence[str],
    names: Sequence[str],
    states: Sequence[str],
) -> tuple[Node, ...] | None:
    given = [key for key in _SHOWN if key in table]
    if len(given) != 1:
        fault = "has " + " and ".join(given) if given else "does not say what it shows"
        entries.findings.add(path, f"{fault}; give one of h (expressions), or H or C (a matrix)")
        return None
    (key,) = given
    if key == "h":
        scope = entries.scope("parameter", "state", "input")
        return entries.vector((*path, "h"), table["h"], names, scope)
    scope = entries.scope("parameter", "input")
    rows = entries.matrix((*path, key), table[key], len(symbols), len(states), scope)
    return tuple(weighted(row, states) for row in rows)


def spread(
    entries: Entries,
    document: Mapping[str, Any],
    model: Mapping[str, Any],
    measured: Sequence[Quantity],
) -> Covariance | None:
    """R, of each group's own, or of the model's; None where it is nowhere."""
    findings, tables = entries.findings, _tables(document)
    own = any("R" in table for table in tables.values())
    if own and "R" in model:
        findings.add(("model", "R"), "stands here, and measurements have their own R")
        return None
    if not own:
        if "R" in model:
            return _covariance(entries, ("model", "R"), model["R"], _symbols(measured))
        findings.add(("model",), "has no R, the variance of what is measured")
        return None
    parts: list[Covariance] = []
    for group in measured:
        path, table = ("measurements", group.name), tables.get(group.name, {})
        if "R" in table:
            names = group.axes or (group.name,)
            parts.append(_covariance(entries, (*path, "R"), table["R"], names))
        else:
            findings.add(path, "has no R, the variance of what is measured")
    return _block_diagonal(parts)


def _covariance(
    entries: Entries, path: tuple[str, ...], value: Any, names: Sequence[str]
) -> Covariance:
    """R as given; a measurement without noise is an error."""
    before = len(entries.findings)
    scope = entries.scope("parameter", "input", "dt")
    R = entries.covariance(path, value, names, scope)
    none = any(row[i] == ZERO for i, row in enumerate(R.rows))
    if none and len(entries.findings) == before:
        entries.findings.add(path, "has the variance 0; every measurement has some noise")
    return R


def weighted(row: Sequence[Node], names: Sequence[str]) -> Node:
    """A row of a matrix times named quantities."""
    return total(made("*", node, Name(name)) for node, name in zip(row, names, strict=True))


def _block_diagonal(parts: Sequence[Covariance]) -> Covariance:
    """The block diagonal covariance of groups with independent noise."""
    if not any(part.full for part in parts):
        return Covariance.diagonal([node for part in parts for node in part.variances])
    size = sum(len(part.variances) for part in parts)
    rows: list[tuple[Node, ...]] = []
    for part in parts:
        before = len(rows)
        after = size - before - len(part.variances)
        rows += [(ZERO,) * before + row + (ZERO,) * after for row in part.rows]
    return Covariance(tuple(rows), True)


def _tables(document: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    given = document.get("measurements", {})
    named_ = given.items() if isinstance(given, Mapping) else ()
    return {name: table for name, table in named_ if isinstance(table, Mapping)}


def _symbols(measured: Sequence[Quantity]) -> tuple[str, ...]:
    return tuple(symbol for group in measured for symbol in group.symbols)
