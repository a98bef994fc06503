"""The observability of every state."""

from collections.abc import Mapping, Sequence

import numpy as np

from tuner.model.algebra import names_in
from tuner.model.covariance import Rows
from tuner.model.description import Model
from tuner.model.evaluate import Values
from tuner.model.findings import Findings

_NEGLIGIBLE = 1e-6
"""Components of a direction below it count as 0."""


def check_observable(model: Model, findings: Findings) -> None:
    """Add an error for unobservable states.

    Of a nonlinear model that is whether a state enters, by way of others, what is measured at all;
    of a linear one that does not change it is the rank test as well, at two sets of parameters.
    """
    silent = _unmeasured(model)
    if silent:
        _tell(silent, len(silent), findings)
        return
    found = [_unobservable(model, shift) for shift in (0.0, 0.3)]
    names, count = min(found, key=lambda each: each[1])
    if count and not set(names) <= set(model.unobserved):
        _tell(names, count, findings)


def _tell(names: Sequence[str], count: int, findings: Findings) -> None:
    if count == len(names):
        fault = f"{_and(names)} {'shows' if count == 1 else 'show'} in no measurement"
    else:
        fault = f"{_and(names)} cannot be told apart by what is measured"
    shown = ", ".join(f'"{name}"' for name in names)
    findings.add(
        ("states", names[0]),
        f"{fault}; measure more, leave out what is not needed, or, where their start is all that "
        f"there is to know, say unobserved = [{shown}]",
    )


def _and(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _unmeasured(model: Model) -> list[str]:
    """The states that enter no measurement, not even through others."""
    names = model.state_names
    enters = dict(zip(names, map(names_in, model.f), strict=True))
    heard = frozenset().union(*map(names_in, model.h)) & frozenset(names)
    while True:
        more = heard.union(*(enters[name] for name in heard)) & frozenset(names)
        if more == heard:
            break
        heard = more
    return [name for name in names if name not in heard and name not in model.unobserved]


def _unobservable(model: Model, shift: float) -> tuple[list[str], int]:
    """The states with components in the unobservable subspace, and its dimension."""
    if model.moved is None or model.seen is None:
        return [], 0
    A, C = model.moved[0], model.seen[0]
    inputs = frozenset(model.input_names)
    if any(names_in(node) & inputs for row in (*A, *C) for node in row):
        return [], 0
    from objectives.linear_systems.model import LinearSystem
    from objectives.linear_systems.subspaces import unobservable

    values = {
        each.name: each.typical * (1 + shift / (2 + i)) + shift * (each.typical == 0)
        for i, each in enumerate(model.parameters)
    }
    with np.errstate(all="ignore"):
        rates, shown = (_numbers(rows, values) for rows in (A, C))
    if not (np.isfinite(rates).all() and np.isfinite(shown).all()):
        return [], 0
    n, m = len(rates), len(shown)
    dt = 1.0 if model.time == "discrete" else None
    system = LinearSystem(rates, shown, np.zeros((n, n)), np.eye(m), dt=dt)
    basis = unobservable(system).basis
    part = np.linalg.norm(basis, axis=1) if basis.size else np.zeros(n)
    names = [name for name, size in zip(model.state_names, part, strict=True) if size > _NEGLIGIBLE]
    return names, basis.shape[1]


def _numbers(rows: Rows, values: Mapping[str, float]) -> np.ndarray:
    typical = {name: np.float64(value) for name, value in values.items()}
    found: np.ndarray = Values(typical | {"dt": np.float64(1.0)}, np, np.float64).matrix(rows)
    return found
