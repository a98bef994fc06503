"""Values that are in use, on a recording that they were not tuned on."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from filters.declared import bare, parameter_facts
from tuner.data.record import Record
from tuner.diagnostics import Diagnostics
from tuner.problem.parameters import Fixed
from tuner.run.filter_choice import Model, choose_filter
from tuner.run.fit import pose_on
from tuner.run.fit_problem import Posed
from tuner.run.innovation_diagnostics import diagnose_innovations
from tuner.run.judgement import shown
from tuner.run.search_space import Wishes


@dataclass(frozen=True, eq=False)
class Check:
    """The verdict of a recording on values in use.

    Attributes:
        posed: the problem and its data.
        values: all parameters, by name.
        value: the objective; of a likelihood in nats a number.
        error: the same as people read it: of a likelihood the equivalent deviation.
        diagnostics: what the innovations say; None for a filter without any.
    """

    posed: Posed
    values: Mapping[str, np.ndarray]
    value: float
    error: float
    diagnostics: Diagnostics | None


def check(
    filter: Model,
    record: Record | Iterable[Record],
    values: Mapping[str, Any],
    *,
    options: Mapping[str, Any] | None = None,
    objective: str | None = None,
) -> Check:
    """Try values in use on a recording, or on several.

    With a truth the value is the filter's error, without one the likelihood of its innovations.

    Args:
        filter: as of :func:`tuner.fit`.
        record: recordings in SI (:func:`tuner.read_record`, :meth:`tuner.Record.of`).
        values: parameters by name; one that is never tuned (a start, a constant) is typical where
            it is left out.
        options: fields of the filter's class.
        objective: of ``tuner list objectives``.

    Raises:
        ValueError: for a parameter that has no value, or that the filter does not know, and for a
            filter that says nothing of how good it is: without innovations and without a truth.

    >>> rng = np.random.default_rng(1)
    >>> level = np.cumsum(0.1 * rng.standard_normal(400))
    >>> record = Record.of({"z": level + rng.standard_normal(400)}, rate_hz=1.0)
    >>> found = check("local-level", record, {"q": 1.0, "R": 100.0})
    >>> 0.008 < found.diagnostics.factor < 0.012, found.diagnostics["size"].verdict
    (True, 'failed')
    """
    choice = choose_filter(filter)
    records = (record,) if isinstance(record, Record) else tuple(record)
    held = {n: _plain(v) for n, v in values.items()}
    wishes = Wishes(fix=held, options=options or {}, objective=objective, held=True)
    posed = pose_on(choice.name, choice.cls, records, wishes)
    return checked(posed)


def checked(posed: Posed) -> Check:
    """Try the values that a problem holds.

    Raises:
        ValueError: where one is still to be tuned.
    """
    space = posed.problem.space
    open_ = [name for name, kind in space.parameters if not isinstance(kind, Fixed)]
    if open_:
        facts = parameter_facts(bare(posed.problem.filter))
        text = ", ".join(f"{name} ({facts[name].meaning})" for name in open_)
        raise ValueError(
            f"{posed.problem.name} has no value in use for {text}; give it with "
            + " ".join(f"--set {name}=..." for name in open_)
        )
    values = posed.problem.parameters(space.start())
    value = posed.problem.score(values)
    read = shown(posed.problem, value)
    return Check(posed, values, value, read, diagnose_innovations(posed, values))


def _plain(value: Any) -> Any:
    """A number, or nested tuples of them, which a space can hold."""
    array = np.asarray(value, float)
    return float(array) if array.ndim == 0 else tuple(_plain(part) for part in array)
