"""The gains as problems: (15) alone, both gains, within limits of the damping, and aided."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Lanes, PiComplementary, PiGains, assembled
from filters.pi_complementary import Aid
from objectives import AngleRmse, ComplementaryLoop, Data
from studies.you_lee.cases import Bench, Case, known
from studies.you_lee.settings import Settings
from tuner.certificate.solution import Solution
from tuner.export.tuned import Quantity
from tuner.problem.exported import exported_of
from tuner.problem.parameters import Fixed, Limited, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

AIDS: dict[str, Aid] = {
    "damped": "airspeed",
    "free": "airspeed",
    "limited": "airspeed",
    "velocity": "velocity",
}
"""The filter that each problem tunes."""
HELD = {"angles0": "rad", "gravity": "ft/s^2"}
AIDED = {"R_k": "(ft/s)^2", "threshold": "rad/s", "x0": "ft/s", "P0": "(ft/s)^2"}
"""Parameters that are not tuned, of any filter and of the velocity filter, with their units."""


def with_gains(values: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters in which tau, or omega and zeta, have become K1 and K2."""
    rest = {name: value for name, value in values.items() if name not in ("tau", "omega", "zeta")}
    if "tau" in values:
        return rest | ComplementaryLoop.critical(values["tau"])._asdict()
    if "omega" in values:
        omega, zeta = values["omega"], values["zeta"]
        return rest | {"K1": 2 * zeta * omega, "K2": omega / (2 * zeta)}
    return rest


def build(values: dict[str, Array]) -> PiGains:
    """The filter's parameters from those of any problem."""
    made: PiGains = assembled(PiComplementary, with_gains(values))
    return made


def derived(values: dict[str, Array]) -> dict[str, Array]:
    """Gains, damping and natural frequency that follow from tuned parameters."""
    params = build(values)
    return {"K1": params.K1, "K2": params.K2, **_poles(params)}


def _poles(params: PiGains) -> dict[str, Array]:
    loop = ComplementaryLoop(params.K1, params.K2)
    return {"damping": loop.damping, "natural_frequency": loop.natural_frequency}


def poles(params: PiGains) -> tuple[Quantity, ...]:
    """Damping and natural frequency, exported beside the gains."""
    units = {"damping": "", "natural_frequency": "rad/s"}
    found = _poles(params)
    return tuple(
        Quantity(name, np.asarray(found[name]), unit, "of the filter's poles")
        for name, unit in units.items()
    )


def spaces(settings: Settings) -> dict[str, Space]:
    """The tuned parameters of each problem.

    R_k stays: it shares a scale with Q_k and P0. P0 stays: where Q_k is free, it is soon forgotten.
    The limits of the damping are the problem's own.
    """
    published = ComplementaryLoop(jnp.asarray(settings.K1), jnp.asarray(settings.K2))
    omega = float(published.natural_frequency)
    slow = Positive(
        1 / omega,
        min(1.0, 1 / omega),
        max(1e3, 1 / omega),
        unit="s",
        meaning="time constant of both poles",
    )
    K1 = Positive(settings.K1, min(1e-3, settings.K1), max(2.0, settings.K1))
    K2 = Positive(settings.K2, min(1e-4, settings.K2), max(2.0, settings.K2))
    found = {
        "damped": Space.of(tau=slow),
        "free": _of_filter(K1=K1, K2=K2),
        "velocity": _of_filter(K1=K1, K2=K2, Q_k=Positive(1e-3, 1e-9, 1e3, "(ft/s)^2")),
    }
    if settings.zeta_low is None and settings.zeta_high is None:
        return found
    return found | {"limited": _limited(settings, omega, float(published.damping))}


def _limited(settings: Settings, omega: float, damping: float) -> Space:
    """The space with limits of the damping, one of which may be open."""
    low, high = settings.zeta_low, settings.zeta_high
    if low is None:
        low = 0.1 if high is None else min(0.1, high / 10)
    high = max(10.0, 10 * low) if high is None else high
    return Space.of(
        omega=Positive(
            omega,
            min(1e-3, omega),
            max(1.0, omega),
            unit="rad/s",
            meaning="natural frequency of the poles",
        ),
        zeta=Limited(float(np.clip(damping, low, high)), low, high, meaning="damping of the poles"),
    )


def _of_filter(**own: Any) -> Space:
    """Some of the filter's parameters, as it declares them."""
    whole = dict(Space.of_filter(PiComplementary, **own).parameters)
    return Space(tuple((name, whole[name]) for name in own))


def posed(bench: Bench) -> dict[str, Problem]:
    """All problems on the same runs: root mean square of roll and pitch, the turn included."""
    return {name: _problem(bench, name, space) for name, space in spaces(bench.settings).items()}


def _problem(bench: Bench, name: str, tuned: Space) -> Problem:
    settings, aid = bench.settings, AIDS[name]
    flight = bench.flights[settings.trajectory]
    numbers = known(settings, flight, settings.start)
    units = HELD | AIDED if aid == "velocity" else HELD
    held = _of_filter(**{key: Fixed(numbers[key], unit) for key, unit in units.items()})
    filter = PiComplementary(settings.dt, aid)
    return Problem(
        name=name,
        space=Space(tuned.parameters + held.parameters),
        filter=Lanes(filter, settings.train),
        build=build,
        objective=AngleRmse(),
        data=Data(*bench.train),
        derive=derived,
        exported=replace(exported_of(filter), derived=poles),
    )


def tuned_case(settings: Settings, solution: Solution) -> Case:
    """The filter that was tuned, as a case for the Monte Carlo runs."""
    free = spaces(settings)[solution.problem].names
    values = with_gains({name: jnp.asarray(solution.parameters[name].value) for name in free})
    named = tuple((name, float(value)) for name, value in values.items())
    return Case(settings.trajectory, AIDS[solution.problem], settings.start, named)
