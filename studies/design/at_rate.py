"""A design at another sample rate of the same continuous model."""

from collections.abc import Collection
from dataclasses import replace
from functools import partial

from studies.design.findings import findings
from studies.design.problems import pose
from studies.design.settings import Settings
from tuner import observers
from tuner.export.tuned import Tuned
from tuner.names import unknown
from tuner.run.at_rate import AtRate

_SAME = 1e-9


def at_rate(settings: Settings, tuned: Tuned, rate_hz: float, densities: Collection[str]) -> AtRate:
    """The observer of least variance at a rate.

    R is the covariance of one measurement and stays, where the design has a ``sample_time``, but
    with the density R it grows with the rate; of a continuous design it is a density as it is.

    Raises:
        ValueError: for a discrete model, and for requirements that need a search.
    """
    if settings.dt is not None:
        raise ValueError(
            f"this design's A, G and Q belong to samples of {settings.dt:g} s; for another rate "
            "give the continuous model, with sample_time in place of dt"
        )
    if settings.bound is not None or settings.settles_s is not None:
        raise ValueError(
            "a design with a bound or a settling time is another search at another rate; run it "
            f"with --set sample_time={1 / rate_hz:.9g}"
        )
    for name in densities:
        if name != "R":
            raise unknown("variance of a sample", name, ["R"])
    T, factor = settings.sample_time, 1.0
    if T is None or densities:
        factor = rate_hz * (T or 1.0)
    R = [[factor * entry for entry in row] for row in settings.R]
    posed = pose(
        Settings.model_validate(settings.model_dump() | {"R": R, "sample_time": 1 / rate_hz}),
        tuned.provenance.seed,
    )
    problem = posed.problem
    solution = observers.riccati(posed.designed.part)(problem)
    found = findings(posed, {(problem.name, "riccati"): solution})
    quantities = problem.quantities(solution)
    new = replace(tuned, quantities=quantities, convention="discrete", dt=1 / rate_hz)
    trials = partial(problem.on_machine, solution)
    return AtRate(new, tuple(found), _notes(settings, factor, rate_hz), trials)


def _notes(settings: Settings, factor: float, rate_hz: float) -> tuple[str, ...]:
    """How R was interpreted, and its value in the other interpretation."""
    if factor != 1:
        return (f"R is {factor:.6g} times what was given: a density times the rate",)
    other = rate_hz * (settings.sample_time or 1.0)
    if abs(other - 1) < _SAME:
        return ()
    return (
        "R stays, the covariance of one measurement; if the sensor averages between samples it "
        f"grows with the rate, to {other:.6g} times of it: --density R",
    )
