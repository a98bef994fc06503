"""The gains as problems: (15) alone, both gains, within limits of the damping, and aided."""

from dataclasses import dataclass

import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Batched, PiComplementary, PiGains, shared
from filters.pi_complementary import Aid
from objectives import AngleRmse, ComplementaryLoop, Data
from studies.you_lee.cases import Bench, Case, Flown, gains
from studies.you_lee.settings import Settings, Start
from tuner.certificate.solution import Solution
from tuner.problem.parameters import Limited, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space

AIDS: dict[str, Aid] = {
    "damped": "airspeed",
    "free": "airspeed",
    "limited": "airspeed",
    "velocity": "velocity",
}
"""The filter that each problem tunes."""


@dataclass(frozen=True, eq=False)
class Build:
    """From parameters by name to those of k filters side by side."""

    settings: Settings
    flight: Flown
    start: Start
    count: int

    def __call__(self, values: dict[str, Array]) -> PiGains:
        """The same for every run."""
        made: PiGains = shared(
            gains(self.settings, self.flight, self.start, with_gains(values)), self.count
        )
        return made


def with_gains(values: dict[str, Array]) -> dict[str, Array]:
    """Parameters in which tau, or omega and zeta, have become K1 and K2."""
    rest = {name: value for name, value in values.items() if name not in ("tau", "omega", "zeta")}
    if "tau" in values:
        return rest | ComplementaryLoop.critical(values["tau"])._asdict()
    if "omega" in values:
        omega, zeta = values["omega"], values["zeta"]
        return rest | {"K1": 2 * zeta * omega, "K2": omega / (2 * zeta)}
    return rest


def loop(values: dict[str, Array]) -> ComplementaryLoop:
    """The two gains."""
    known = with_gains(values)
    return ComplementaryLoop(known["K1"], known["K2"])


def derived(values: dict[str, Array]) -> dict[str, Array]:
    """What the gains stand for."""
    found = loop(values)
    return {
        "K1": jnp.asarray(found.K1),
        "K2": jnp.asarray(found.K2),
        "damping": found.damping,
        "natural_frequency": found.natural_frequency,
    }


def spaces(settings: Settings) -> dict[str, Space]:
    """What is tuned in each problem.

    R_k stays: it shares a scale with Q_k and P0. P0 stays: where Q_k is free, it is soon forgotten.
    The limits of the damping are the problem's own.
    """
    published = ComplementaryLoop(jnp.asarray(settings.K1), jnp.asarray(settings.K2))
    omega = float(published.natural_frequency)
    both: dict[str, Parameter] = {
        "K1": Positive(settings.K1, min(1e-3, settings.K1), max(2.0, settings.K1), "1/s"),
        "K2": Positive(settings.K2, min(1e-4, settings.K2), max(2.0, settings.K2), "1/s"),
    }
    aided = both | {"Q_k": Positive(1e-3, 1e-9, 1e3, "(ft/s)^2")}
    found = {
        "damped": Space.of(tau=Positive(1 / omega, min(1.0, 1 / omega), max(1e3, 1 / omega), "s")),
        "free": Space.of(**both),
        "velocity": Space.of(**aided),
    }
    low, high = settings.zeta_low, settings.zeta_high
    if low is None and high is None:
        return found
    if low is None:
        low = 0.1 if high is None else min(0.1, high / 10)
    high = max(10.0, 10 * low) if high is None else high
    zeta = Limited(float(np.clip(published.damping, low, high)), low, high)
    tuned = Positive(omega, min(1e-3, omega), max(1.0, omega), "rad/s")
    return found | {"limited": Space.of(omega=tuned, zeta=zeta)}


def problems(bench: Bench) -> dict[str, Problem]:
    """All of them on the same runs: root mean square of roll and pitch, the turn included."""
    settings = bench.settings
    inputs, truth = bench.train()
    flight = bench.flights[settings.trajectory]
    build = Build(settings, flight, settings.start, settings.train)
    return {
        name: Problem(
            name=name,
            space=space,
            filter=Batched(PiComplementary(settings.dt, AIDS[name])),
            build=build,
            objective=AngleRmse(),
            data=Data(inputs, truth),
            derive=derived,
        )
        for name, space in spaces(settings).items()
    }


def tuned_case(settings: Settings, solution: Solution) -> Case:
    """The filter that was tuned, as a case for the Monte Carlo runs."""
    values = {name: jnp.asarray(p.value) for name, p in solution.parameters.items()}
    known = tuple((name, float(value)) for name, value in with_gains(values).items())
    return Case(settings.trajectory, AIDS[solution.problem], settings.start, known)
