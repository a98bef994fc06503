"""The states of a model document: dynamics, process noise, and initial values."""

from collections.abc import Mapping, Sequence
from typing import Any

from tuner.model.algebra import made
from tuner.model.covariance import Rows
from tuner.model.description import Time
from tuner.model.entries import Entries
from tuner.model.expression import ONE, ZERO, Node
from tuner.model.findings import brief
from tuner.model.measurements import weighted

_OWN: dict[str, Time] = {"A": "continuous", "F": "discrete"}


def moves(
    entries: Entries, model: Mapping[str, Any], states: Sequence[str], inputs: Sequence[str]
) -> tuple[Time, tuple[Node, ...] | None]:
    """The kind of time, and f: given as such, or by A or F with B."""
    findings = entries.findings
    given = [key for key in ("A", "F", "f") if key in model]
    if len(given) != 1:
        fault = "has " + " and ".join(given) if given else "does not say how the states move"
        findings.add(
            ("model",), f"{fault}; give one of A (continuous), F (discrete) or f (expressions)"
        )
        return "discrete", None
    (key,) = given
    time = _time(entries, model, key)
    path, more = ("model", key), steps(time)
    if key == "f":
        if "B" in model:
            findings.add(("model", "B"), "goes with A or F; write inputs into f")
        scope = entries.scope("parameter", "state", "input", *more)
        return time, entries.vector(path, model["f"], states, scope)
    scope = entries.scope("parameter", "input", *more)
    rows = entries.matrix(path, model[key], len(states), len(states), scope)
    found = tuple(weighted(row, states) for row in rows)
    if "B" not in model:
        return time, found
    if not inputs:
        findings.add(("model", "B"), "has no inputs to weigh; name them in inputs")
        return time, found
    B = entries.matrix(("model", "B"), model["B"], len(states), len(inputs), scope)
    pushes = (weighted(row, inputs) for row in B)
    return time, tuple(made("+", one, other) for one, other in zip(found, pushes, strict=True))


def _time(entries: Entries, model: Mapping[str, Any], key: str) -> Time:
    time = model.get("time", _OWN.get(key))
    add = entries.findings.add
    if time is None:
        way = "say time = 'continuous' or time = 'discrete'"
        add(("model", "f"), f"is the rate of the states, or their next values; {way}")
    elif time not in ("continuous", "discrete"):
        add(("model", "time"), f"is {brief(time)}; give 'continuous' or 'discrete'")
    elif _OWN.get(key, time) != time:
        add(("model", "time"), f"is {time!r}, and {key} is {_OWN[key]}")
    return "discrete" if time == "discrete" else "continuous"


def steps(time: Time) -> tuple[str, ...]:
    """The further names in a model's entries: a continuous model has no sample time."""
    return ("dt",) if time == "discrete" else ()


def noise(
    entries: Entries, model: Mapping[str, Any], time: Time, states: Sequence[str]
) -> tuple[Rows, Rows | None]:
    """G and Q; None where Q is missing."""
    size = range(len(states))
    scope = entries.scope("parameter", "state", "input", *steps(time))
    G: Rows = tuple(tuple(ONE if i == j else ZERO for j in size) for i in size)
    entering: Sequence[str] = states
    if "G" in model:
        G = entries.matrix(("model", "G"), model["G"], len(states), None, scope)
        entering = [f"w{j + 1}" for j in range(len(G[0]))]
    if "Q" not in model:
        what = "spectral density" if time == "continuous" else "covariance a sample"
        entries.findings.add(("model",), f"has no Q, the {what} of the process noise")
        return G, None
    return G, entries.covariance(("model", "Q"), model["Q"], entering, scope, rest=0.0).rows


def start(
    entries: Entries, model: Mapping[str, Any], states: Sequence[str]
) -> tuple[tuple[Node, ...], Rows, tuple[int, ...]]:
    """x0, P0 with 0 for unknown states, and the unknown states: those with inf in P0."""
    scope = entries.scope("parameter")
    x0 = entries.vector(("model", "x0"), model.get("x0", {}), states, scope, rest=0.0)
    given, unknowns = _without_infinite(model.get("P0", float("inf")), states)
    P0 = entries.covariance(("model", "P0"), given, states, scope)
    return x0, P0.rows, unknowns


def _without_infinite(given: Any, states: Sequence[str]) -> tuple[Any, tuple[int, ...]]:
    """A covariance with 0 in place of inf on its diagonal, and the places of these."""
    if _infinite(given):
        return 0.0, tuple(range(len(states)))
    if isinstance(given, Mapping):
        found = {name: 0.0 if _infinite(value) else value for name, value in given.items()}
        return found, tuple(i for i, name in enumerate(states) if _infinite(given.get(name)))
    if not isinstance(given, list):
        return given, ()
    whole = any(isinstance(row, list) for row in given)
    rows = [list(row) if isinstance(row, list) else row for row in given]
    unknowns = []
    for i, row in enumerate(rows):
        if whole and isinstance(row, list) and i < len(row) and _infinite(row[i]):
            row[i] = 0.0
            unknowns.append(i)
        elif not whole and _infinite(row):
            rows[i] = 0.0
            unknowns.append(i)
    return rows, tuple(unknowns)


def _infinite(value: Any) -> bool:
    return value == "inf" or (isinstance(value, float) and value == float("inf"))
