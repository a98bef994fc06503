"""The model of a document, checked as a whole."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from tuner.model import dynamics, measurements, quantities
from tuner.model.algebra import affine
from tuner.model.description import METHODS, Method, Model
from tuner.model.entries import Entries
from tuner.model.expression import ExpressionError
from tuner.model.findings import Findings, brief
from tuner.model.lines import Lines
from tuner.model.observable import check_observable
from tuner.model.parameters import Parameter, read_parameters
from tuner.model.quantities import Quantity
from tuner.model.size import check_size
from tuner.model.units import check_units
from tuner.names import unknown

_TOP = (
    "name", "title", "method", "iterations", "unobserved", "parameters", "inputs", "states",
    "measurements", "model",
)  # fmt: skip
_MODEL = ("time", "A", "F", "B", "f", "G", "Q", "C", "H", "h", "R", "x0", "P0")


def described(document: Mapping[str, Any], lines: Lines, name: str) -> Model:
    """The model of a document.

    Args:
        document: as TOML is read.
        lines: of its entries.
        name: of the file, for errors.

    Raises:
        ValueError: with all mistakes in it.
    """
    check_size(document, name)
    findings = Findings(lines)
    try:
        return _checked(document, findings, name)
    except ExpressionError as error:  # where products of entries are not finite
        raise ValueError(f"{name}: the model {error}") from None


def _checked(document: Mapping[str, Any], findings: Findings, name: str) -> Model:
    model, entries = _read(document, findings)
    if model is not None:
        check_units(model, entries, findings)
    findings.check(name)
    if model is None:
        raise ValueError(f"{name} does not describe a model; tuner init writes one to begin with")
    check_observable(model, findings)
    findings.check(name)
    return model


_ARTICLE = {
    "parameter": "a parameter", "state": "a state", "input": "an input", "dt": "the sample time",
}  # fmt: skip


def _read(document: Mapping[str, Any], findings: Findings) -> tuple[Model | None, Entries]:
    """The model, None where it is incomplete, and its entries as they were written."""
    findings.keys((), document, _TOP)
    table = findings.table(("model",), document.get("model", {}))
    findings.keys(("model",), table, _MODEL)
    parameters = read_parameters(findings, document)
    inputs = quantities.inputs(findings, document)
    states = quantities.states(findings, document)
    entries = Entries(findings, _kinds(findings, parameters, inputs, states))
    names = [state.name for state in states]
    symbols = [symbol for each in inputs for symbol in each.symbols]
    groups = measurements.groups(entries, document, inputs)
    if not names or not groups:
        return None, entries
    time, f = dynamics.moves(entries, table, names, symbols)
    h = measurements.shows(entries, document, table, groups, names)
    G, Q = dynamics.noise(entries, table, time, names)
    R = measurements.spread(entries, document, table, groups)
    x0, P0, diffuse = dynamics.start(entries, table, names)
    iterations, unobserved = _iterations(findings, document), _unobserved(findings, document, names)
    name, title = (quantities.text(findings, (), document, key) for key in ("name", "title"))
    if name and not quantities.NAME.fullmatch(name):
        fault = "is not a name for a model; take letters, digits, - and _, beginning with a letter"
        findings.add(("name",), f"{brief(name)} {fault}")
    method = document.get("method")
    if method is not None and method not in METHODS:
        findings.add(("method",), _no_method(method))
        method = None
    if f is None or h is None or Q is None or R is None:
        return None, entries
    model = Model(
        name, title, "extended", iterations, time, parameters, inputs, states, groups,
        f, G, Q, h, R, x0, P0, diffuse, unobserved,
    )  # fmt: skip
    if not len(findings):  # an incomplete model is not checked further
        model = replace(model, method=_method(findings, model, method, "P0" in table))
    return model, entries


def _kinds(
    findings: Findings,
    parameters: Sequence[Parameter],
    inputs: Sequence[Quantity],
    states: Sequence[Quantity],
) -> dict[str, str]:
    """The kind of each name; one with two kinds is noted."""
    found = {"dt": "dt"}
    named: list[tuple[str, str, tuple[str, ...]]] = [
        ("parameter", each.name, (each.name,)) for each in parameters
    ]
    named += [("input", each.name, each.symbols) for each in inputs]
    named += [("state", each.name, each.symbols) for each in states]
    for kind, name, symbols in named:
        for symbol in symbols:
            if symbol in found:
                findings.add((f"{kind}s", name), f"{symbol!r} is {_ARTICLE[found[symbol]]} as well")
            found[symbol] = kind
    return found


def _method(findings: Findings, model: Model, given: Method | None, begun: bool) -> Method:
    """The given method; else Kalman's for a linear model, and the extended one for others."""
    chosen: Method = given or ("kalman" if model.linear else "extended")
    if chosen == "kalman" and not model.linear:
        findings.add(
            ("method",), f"kalman needs a linear model, and {_nonlinearity(model)}; take extended"
        )
    if chosen == "unscented" and model.diffuse:
        fault = "is missing or inf, and sigma points need a known start"
        findings.add(("model", "P0"), fault)
    elif not model.linear and not begun:
        findings.add(
            ("model",),
            "has no P0, the variances of the start, on which a nonlinear filter depends; give inf "
            "for states of which nothing is known",
        )
    return chosen


def _nonlinearity(model: Model) -> str:
    """The nonlinear equation, in words."""
    names = model.state_names
    symbols = [symbol for group in model.groups for symbol in group.symbols]
    for nodes, of in ((model.f, names), (model.h, symbols)):
        for node, name in zip(nodes, of, strict=True):
            if affine(node, names) is None:
                return f"that of {name} is not"
    return "its noise depends on the states"


def _no_method(given: Any) -> str:
    if isinstance(given, str):
        return str(unknown("method", given, METHODS))
    return f"is {brief(given)}; give {', '.join(METHODS)}"


def _iterations(findings: Findings, document: Mapping[str, Any]) -> int:
    value = document.get("iterations", 5)
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 50:
        findings.add(("iterations",), f"is {brief(value)}; give a number from 1 to 50")
        return 5
    if "iterations" in document and document.get("method") != "iterated":
        findings.add(("iterations",), "goes with method = 'iterated'")
    return value


def _unobserved(
    findings: Findings, document: Mapping[str, Any], names: Sequence[str]
) -> tuple[str, ...]:
    value = document.get("unobserved", [])
    if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
        findings.add(("unobserved",), f"is {brief(value)}; give a list of states")
        return ()
    for name in value:
        if name not in names:
            findings.add(("unobserved",), str(unknown("state", name, names)))
    return tuple(value)
