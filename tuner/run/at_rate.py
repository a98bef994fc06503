"""A tuned filter at another sample rate: densities stay, what follows from them is found anew."""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from typing import Any

import numpy as np

from filters.declared import assembled, parameter_facts
from tuner.catalogue import names
from tuner.export.tuned import Quantity, Tuned
from tuner.names import unknown
from tuner.problem.exported import Trial, derived_of, once
from tuner.problem.random_inputs import random_inputs
from tuner.problem.steady_form import steady_form_of
from tuner.problem.steady_gains import system_of
from tuner.run.filter_choice import FilterChoice
from tuner.run.finding import Finding
from tuner.run.gate import care_of, with_noise
from tuner.run.noise_parameters import noise_parameters
from tuner.run.noise_table import gain_findings, noise_findings

_TRACKERS = {"alpha-beta": "constant-velocity", "alpha-beta-gamma": "constant-acceleration"}
_SAME = 1e-12


@dataclass(frozen=True)
class AtRate:
    """A tuned filter at another rate.

    Attributes:
        tuned: what is exported.
        findings: its noise and its gains, for people.
        notes: what was taken for granted, a sentence each.
        trials: what is written as C, forms by name.
    """

    tuned: Tuned
    findings: tuple[Finding, ...]
    notes: tuple[str, ...] = ()
    trials: Callable[[], Mapping[str, Trial]] = dict


def filter_at_rate(
    choice: FilterChoice,
    options: Mapping[str, Any],
    tuned: Tuned,
    rate_hz: float,
    densities: Collection[str] = (),
) -> AtRate:
    """A filter that was tuned at one rate, for another.

    Densities and time constants are the same at every rate; Q, K, L, alpha and beta follow from
    them. A measurement's variance is that of one measurement and stays, but for those that are said
    to be densities times the rate, as of a sensor that averages between its samples.

    Args:
        choice: the filter.
        options: fields of its class, and what a fit adds to any filter.
        tuned: its numbers at the rate that it was tuned at.
        rate_hz: the other rate.
        densities: parameters, variances of a sample, that grow with the rate.

    Raises:
        ValueError: for a filter whose numbers belong to its own rate, in one sentence.
    """
    cls, options = with_noise(choice.cls, options, tuned.dt or 1.0)
    _, options = care_of(cls, options)
    numbers = {quantity.name: quantity for quantity in tuned.quantities}
    values = {name: numbers[name].value for name in parameter_facts(cls) if name in numbers}
    units = {name: numbers[name].unit for name in values}
    filter = _made(cls, choice.name, options, 1 / rate_hz)
    before = replace(filter, dt=tuned.dt)
    _check(choice, cls, values, before)
    averaged = _averaged(before, values, units, densities)
    values |= {name: values[name] * tuned.dt * rate_hz for name in averaged}
    params = assembled(cls, values)
    before_and_derived = tuned.quantities + derived_of(before, assembled(cls, values))
    new = {each.name: each.value for each in derived_of(filter, params)}
    quantities = once(_renewed(before_and_derived, values, new))
    derived = [each for each in quantities if each.name.removesuffix("_derived") in new]
    findings = (*noise_findings(filter, values, units), *gain_findings(derived))
    notes = tuple(_notes(before, values, units, averaged, 1 / tuned.dt, rate_hz))
    new_tuned = replace(tuned, quantities=quantities, dt=1 / rate_hz)
    return AtRate(new_tuned, findings, notes, partial(_trials, filter, params))


def _trials(filter: Any, params: Any) -> dict[str, Trial]:
    """The filter, on invented samples: a fit's recording is of another rate."""
    return {"full": Trial(filter, params, random_inputs(filter))} | steady_form_of(filter, params)


def _made(cls: type[Any], name: str, options: Mapping[str, Any], dt: float) -> Any:
    if "dt" not in {each.name for each in fields(cls)}:
        raise ValueError(
            f"{name} has no sample time, so its numbers hold only at their own rate; "
            "give the model a dt, or tune at the other rate"
        )
    return cls(dt=dt, **options)


def _check(choice: FilterChoice, cls: type[Any], values: Mapping[str, Any], filter: Any) -> None:
    """Refuse a filter whose numbers are those of one sample time."""
    name, at = choice.name, f"samples at {1 / filter.dt:.6g} Hz"
    facts = parameter_facts(cls)
    held = [parameter for parameter in values if facts[parameter].per_sample]
    if held:
        way = "tune it on a record of that rate"
        if name in _TRACKERS:
            way = f"tune {_TRACKERS[name]}, whose density holds at every rate"
        raise ValueError(f"{' and '.join(held)} of {name} hold only for {at}; {way}")
    if hasattr(filter, "linear"):
        _check_density(name, at, values, filter)
    elif name not in names("tuner.filters"):
        raise ValueError(
            f"{name} has no method linear, so its numbers hold only for {at}; densities and time "
            "constants hold at every rate"
        )


def _check_density(name: str, at: str, values: Mapping[str, Any], filter: Any) -> None:
    """Refuse a process noise that does not know how long a sample is."""
    params, dt = assembled(filter, values), filter.dt
    W, longer = (
        system_of(each.linear(params), dt).W for each in (filter, replace(filter, dt=2 * dt))
    )
    if W.any() and np.allclose(W, longer, rtol=_SAME, atol=0):
        raise ValueError(
            f"the process noise of {name} does not depend on dt, so it holds only for {at}; "
            "give a density times dt, or a continuous model"
        )


def _averaged(
    filter: Any, values: Mapping[str, Any], units: Mapping[str, str], densities: Collection[str]
) -> list[str]:
    known = [
        each.name for each in noise_parameters(filter, values, units) if each.kind == "variance"
    ]
    for name in densities:
        if name not in known:
            raise unknown("variance of a sample", name, known)
    return [name for name in known if name in densities]


def _renewed(
    quantities: tuple[Quantity, ...], values: Mapping[str, Any], new: Mapping[str, Any]
) -> Iterator[Quantity]:
    """The findings with the numbers of the new rate, without those that have none there."""
    for quantity in quantities:
        name = quantity.name.removesuffix("_derived")
        if name in new and quantity.name not in values:
            yield replace(quantity, name=name, value=new[name])
        elif quantity.name in values:
            yield replace(quantity, value=values[quantity.name])


def _notes(
    filter: Any,
    values: Mapping[str, Any],
    units: Mapping[str, str],
    averaged: list[str],
    before: float,
    now: float,
) -> Iterator[str]:
    """The assumption about a measurement's variance, and its value under the other one."""
    for each in noise_parameters(filter, values, units):
        if each.kind != "variance" or np.isclose(before, now):
            continue
        if each.name in averaged:
            yield f"{each.name} is {each.square:.6g}: a density times the rate, as was asked for"
        else:
            other = each.square * now / before
            yield (
                f"{each.name} stays {each.square:.6g}, the variance of one measurement; if the "
                f"sensor averages between samples it grows with the rate, to {other:.6g}: "
                f"--density {each.name}"
            )
