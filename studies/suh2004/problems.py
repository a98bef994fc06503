"""The three filters by hand, and tuned with the same means."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import jax.numpy as jnp
from jax import Array

from filters import Lanes, TiltKalman, TiltNoise, TiltOutputs, TiltSample, assembled
from objectives import AngleErrors, Records, angle_errors
from studies.suh2004.data import Recordings
from studies.suh2004.paper import FILTERS, HEURISTIC
from tuner.problem.parameters import Bounded, Fixed, Parameter, Positive
from tuner.problem.problem import Problem, run_filter
from tuner.problem.space import Space

BY_HAND: dict[str, Any] = HEURISTIC | {"gravity": 1.0, "x0": (0.0,) * 5, "P0": 0.0}
"""The paper's parameters; accelerations are in g, and the start is known."""
HELD = BY_HAND | {
    "r3": Fixed(HEURISTIC["r3"], meaning="variance of the gyroscopes, held: the scale is free"),
    "gravity": Fixed(BY_HAND["gravity"], unit="g"),
}
Q1 = Positive(1.0, 1e-2, 1e4)
R_NOM = Positive(0.05, 1e-4, 1e3)
DELTA = Positive(0.005, 5e-4, 0.2, threshold=True)
FREE: dict[str, dict[str, Parameter]] = {
    "standard": {"q1": Q1, "r_nom": R_NOM},
    "simple": {"q1": Q1, "r_nom": R_NOM, "r_big": Positive(5.0, 1e-2, 1e6), "delta": DELTA},
    "two_step": {
        "q1": Q1,
        "r_nom": R_NOM,
        "alpha1": Bounded(0.4, 0.0, 1.0),
        "alpha2": Positive(10.0, 1e-1, 1e6),
        "delta": DELTA,
    },
}
"""What is tuned of each filter; what is held beside it is the paper's."""


@dataclass(frozen=True)
class TiltRmse:
    """Root mean square error of pitch and roll together, deg."""

    def __call__(self, outputs: TiltOutputs, truth: Array) -> Array:
        """Of one record, ``()``."""
        square = ((outputs.angles - truth) ** 2).sum(axis=1)
        return jnp.degrees(jnp.sqrt(square.mean()))


OBJECTIVE = Records(TiltRmse())


def noise(values: Mapping[str, Any]) -> TiltNoise:
    """The filter's parameters from those given by name, the paper's for the others."""
    made: TiltNoise = assembled(TiltKalman, BY_HAND | dict(values))
    return made


def outputs(filter: TiltKalman, inputs: TiltSample, parameters: TiltNoise) -> TiltOutputs:
    """A filter's outputs over a record."""
    found: TiltOutputs = run_filter(filter, parameters, inputs)
    return found


def errors(filter: TiltKalman, inputs: TiltSample) -> AngleErrors:
    """S and M of (12) with the paper's parameters, where the true attitude is zero."""
    angles = outputs(filter, inputs, noise({})).angles
    return angle_errors(angles, jnp.zeros_like(angles))


def posed(tuned_on: Recordings) -> dict[str, Problem]:
    """One problem for each filter."""
    _refuse_still(tuned_on.truth)
    return {name: _problem(name, tuned_on) for name in FREE}


def held_out(name: str, values: Mapping[str, Any], judged_on: Recordings) -> float:
    """A filter's error on other records, deg; what is not given is the paper's."""
    return _problem(name, judged_on).score(BY_HAND | dict(values))


def _problem(name: str, records: Recordings) -> Problem:
    return Problem(
        name=name,
        space=Space.of_filter(TiltKalman, **(HELD | FREE[name])),
        filter=Lanes(FILTERS[name], records.count),
        build=None,
        objective=OBJECTIVE,
        data=records.data,
    )


def _refuse_still(truth: Array) -> None:
    """Refuse data on which a filter that never follows the sensors is the best.

    Raises:
        ValueError: names the direction that such data cannot determine.
    """
    if not float(jnp.abs(truth - truth[0]).max()) > 0:
        raise ValueError(
            "the true attitude never moves in these data, so the error falls to zero as q1 goes "
            "to 0 (a filter that ignores its sensors), and q1 against r_nom, alpha2 and delta is "
            "not determined: tune on records with motion (tune_on = 'mixed')"
        )
