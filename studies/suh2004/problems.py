"""The three filters by hand, and tuned with the same means."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from filters import Lanes, TiltKalman, TiltNoise, TiltOutputs, TiltSample, assembled
from objectives import AngleErrors, Records, angle_errors
from studies.suh2004.data import Recordings
from studies.suh2004.paper import FILTERS, HEURISTIC
from tuner.problem.other_records import mean_on
from tuner.problem.parameters import Bounded, Fixed, Parameter, Positive
from tuner.problem.problem import Problem
from tuner.problem.programs import run_filter
from tuner.problem.space import Space

BY_HAND: dict[str, Any] = HEURISTIC | {"gravity": 1.0, "x0": (0.0,) * 5, "P0": 0.0}
"""The paper's parameters; accelerations are in g, and the start is known."""
HELD = BY_HAND | {
    "r3": Fixed(HEURISTIC["r3"], meaning="variance of the gyroscopes, held: the scale is free"),
    "q1": Fixed(1e4, meaning="process noise of the rates, held: larger ones change nothing"),
    "delta": Fixed(HEURISTIC["delta"], meaning="a disturbance is detected above it, held"),
    "gravity": Fixed(BY_HAND["gravity"], unit="g"),
}
"""Held parameters of all three filters.

The error falls with q1 as far as it may go, where rates are what the gyroscopes say. delta is the
paper's: three records do not determine it (docs/suh2004.md), and for any delta that is held the
others have one optimum.
"""
R_NOM = Positive(1.0, 1e-2, 1e3)
LARGE = Positive(1e3, 1e1, 1e6)
"""Additional variance of a disturbance, in the scale of q1."""
FREE: dict[str, dict[str, Parameter]] = {
    "standard": {"r_nom": R_NOM},
    "simple": {"r_nom": R_NOM, "r_big": LARGE},
    "two_step": {"r_nom": R_NOM, "alpha1": Bounded(0.4, 0.0, 1.0), "alpha2": LARGE},
}
"""Tuned parameters of each filter; those held beside them are the paper's, but for q1."""
STARTS: dict[str, tuple[dict[str, float], ...]] = {
    "standard": ({"r_nom": 0.1}, {"r_nom": 10.0}, {"r_nom": 100.0}),
    "simple": (
        {"r_nom": 0.1, "r_big": 1e2},
        {"r_nom": 10.0, "r_big": 1e2},
        {"r_nom": 10.0, "r_big": 1e4},
    ),
    "two_step": (
        {"r_nom": 0.1, "alpha1": 0.1, "alpha2": 1e4},
        {"r_nom": 10.0, "alpha1": 0.1, "alpha2": 1e3},
        {"r_nom": 10.0, "alpha1": 0.8, "alpha2": 1e2},
    ),
}
"""Further starts of a search, over two decades about the first one.

In the corners of the whole box there is nothing to learn: with a long memory of large variances the
two-step filter diverges, and without any it is the standard one, from which no slope leads back.
"""


@dataclass(frozen=True)
class TiltRmse:
    """Root mean square error of pitch and roll together, deg."""

    def __call__(self, outputs: TiltOutputs, truth: Array) -> Array:
        """The error of one record, ``()``."""
        square = ((outputs.angles - truth) ** 2).sum(axis=1)
        return jnp.degrees(jnp.sqrt(square.mean()))


OBJECTIVE = Records(TiltRmse())


def noise(values: Mapping[str, Any]) -> TiltNoise:
    """The filter's parameters from those given by name, the paper's for the others."""
    made: TiltNoise = assembled(TiltKalman, BY_HAND | dict(values))
    return made


def outputs(
    filter: TiltKalman,
    inputs: TiltSample,
    parameters: TiltNoise,
    beside: Recordings | None = None,
) -> TiltOutputs:
    """A filter's outputs over a record, run in the shape of others to share their compilation.

    It is filled up with its last sample, and runs in all lanes alike.

    Args:
        filter: the filter.
        inputs: of one record.
        parameters: the filter's.
        beside: the records whose shape it takes, where they are as long; None: its own.
    """
    samples = len(inputs.gyr)
    count, length = (1, samples) if beside is None else (beside.count, len(beside.truth))
    missing = max(length - samples, 0)

    def lanes(leaf: Array) -> np.ndarray:
        one = np.asarray(leaf)
        longer = np.concatenate([one, np.repeat(one[-1:], missing, axis=0)])
        return np.repeat(longer[:, None], count, axis=1)

    found = run_filter(Lanes(filter, count), parameters, jax.tree.map(lanes, inputs))
    first: TiltOutputs = jax.tree.map(lambda leaf: np.asarray(leaf)[:samples, 0], found)
    return first


def errors(filter: TiltKalman, inputs: TiltSample, beside: Recordings | None = None) -> AngleErrors:
    """S and M of (12) with the paper's parameters, where the true attitude is zero.

    Args:
        filter: the filter.
        inputs: of one record.
        beside: see :func:`outputs`.
    """
    angles = outputs(filter, inputs, noise({}), beside).angles
    found: AngleErrors = _angle_errors(angles, np.zeros_like(angles))
    return found


_angle_errors = jax.jit(angle_errors)


def posed(tuned_on: Recordings) -> dict[str, Problem]:
    """One problem for each filter."""
    _refuse_still(tuned_on.truth)
    return {name: _problem(name, tuned_on) for name in FREE}


def held_out(problem: Problem, values: Mapping[str, Any], judged_on: Recordings) -> float:
    """A filter's error on other records, deg; parameters not given are the paper's."""
    return mean_on(problem, BY_HAND | dict(values), judged_on.data)


def _problem(name: str, records: Recordings) -> Problem:
    space = Space.of_filter(TiltKalman, **(HELD | FREE[name]))
    return Problem(
        name=name,
        space=space,
        known_starts=tuple(space.unconstrain(values) for values in STARTS[name]),
        filter=Lanes(FILTERS[name], records.count),
        build=None,
        objective=OBJECTIVE,
        data=records.data,
    )


def _refuse_still(truth: Array) -> None:
    """Refuse data on which a filter that ignores its sensors is the best.

    Raises:
        ValueError: names the direction that such data cannot determine.
    """
    if not float(np.abs(np.asarray(truth) - np.asarray(truth)[0]).max()) > 0:
        raise ValueError(
            "the attitude in these data never moves, so a filter without sensors (q1 = 0) is "
            "best; tune on records with motion: tune_on = 'mixed'"
        )
