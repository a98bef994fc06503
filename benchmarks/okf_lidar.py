"""Constant velocity on the lidar targets of the Optimized Kalman Filter, tuned and judged.

    python -m benchmarks.okf_lidar okf_simple_lidar.npz

Greenberg, Yannay and Mannor (Optimization or Architecture: How to Hack Kalman Filtering, NeurIPS
2023) examine a Kalman filter whose Q and R are optimised instead of estimated. Here: the
first 700 targets tune, the other 300 judge; a target's state begins at its first measurement, at
rest, with P0 = 1000 I. Beside the Q and R of the true noise: two factors on them by the error and
by the likelihood without truth, and full matrices by the error. An error leaves the common factor
of all variances open, so the filter is rescaled until the NIS of its innovations is 1.
"""

import argparse
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from jax import Array
from rich.console import Console
from rich.table import Table

from filters import Estimate, LinearKalman, LinearModel, Sample, Transition
from objectives import ChannelRmse, Data, InnovationLikelihood
from tuner.certificate.solution import Solution, TunedParameter
from tuner.certificate.table import range_in_words
from tuner.problem.parameters import Covariance, Fixed, Positive
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.run.variance_scaling import nees_of, nis_of, scale_variances
from tuner.solvers.gradient import Gradient

TRAINED, P0 = 700, 1000.0
F = np.array([[1.0, 0, 1, 0], [0, 1, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]])


class Targets(NamedTuple):
    """Targets side by side, from their first measurement on: NaN past the end of one.

    Attributes:
        z: measured positions, ``(N, k, 2)``.
        truth: positions and velocities, ``(N, k, 4)``.
    """

    z: np.ndarray
    truth: np.ndarray

    @property
    def samples(self) -> tuple[np.ndarray, np.ndarray]:
        """Inputs of the filter: no time passes before the first of them."""
        return self.z, np.arange(len(self.z)) > 0


class Tracked(NamedTuple):
    """Of k targets: states ``(k, 4)``, covariance ``(4, 4)``, innovations and variances."""

    x: Array
    P: Array
    innovation: Array
    variance: Array


@dataclass(frozen=True)
class Tracks:
    """:class:`filters.LinearKalman` on k targets that pass through the same gains.

    None misses a measurement before its end, so one covariance serves all of them.
    """

    count: int

    def init(self, params: LinearModel) -> Estimate:
        """Every target at its first measurement, at rest."""
        return Estimate(jnp.zeros((4, self.count)), params.P0)

    def step(
        self, params: LinearModel, state: Estimate, inputs: tuple[Array, Array]
    ) -> tuple[Estimate, Tracked]:
        """One sample of all targets, and whether time went by before it.

        What is past a target's end, and the measurement that it begins with, predict nothing: they
        do not count.
        """
        z, passed = inputs
        seen = ~jnp.isnan(z)
        step = params.transition
        step = step._replace(F=jnp.where(passed, step.F, jnp.eye(4)), Q=passed * step.Q)
        sample = Sample(jnp.where(seen, z, 0.0).T, None, step)
        estimate, out = LinearKalman().step(params, state, sample)
        variance = jnp.broadcast_to(out.variance, (self.count, 2))
        variance = jnp.where(seen & passed, variance, 0.0)
        P = jnp.broadcast_to(out.P, (self.count, 4, 4))
        return Estimate(estimate.x, estimate.P), Tracked(
            out.x.T, P, jnp.where(seen, out.innovation.T, 0.0), variance
        )


def targets(file: Path) -> tuple[Targets, Targets]:
    """Those that tune, and those that judge."""
    known = np.load(file)
    lengths = known["lengths"]
    ends = np.cumsum(lengths)
    N, k = int(lengths.max()), len(lengths)
    z, truth = np.full((N, k, 2), np.nan), np.full((N, k, 4), np.nan)
    for i, (end, length) in enumerate(zip(ends, lengths, strict=True)):
        z[:length, i] = known["measurements"][end - length : end]
        truth[:length, i] = known["states"][end - length : end]
    # A constant velocity does not depend on the place: all begin at 0 with the first measurement.
    truth[..., :2] -= z[:1]
    z = z - z[:1]
    return Targets(z[:, :TRAINED], truth[:, :TRAINED]), Targets(z[:, TRAINED:], truth[:, TRAINED:])


def true_noise(known: Targets) -> tuple[np.ndarray, np.ndarray]:
    """Covariances of the truth's steps and of the measurements' errors: Q and R as estimated."""
    steps = (known.truth[1:] - known.truth[:-1] @ F.T).reshape(-1, 4)
    errors = (known.z - known.truth[..., :2]).reshape(-1, 2)
    Q, R = (np.cov(each[~np.isnan(each).any(axis=1)].T) for each in (steps, errors))
    return Q, R


def model(values: dict[str, Array]) -> LinearModel:
    """The constant velocity, with Q and R themselves or as factors on others."""
    Q, R = (values[n] * values.get(f"{n}_factor", jnp.ones(())) for n in ("Q", "R"))
    transition = Transition(jnp.asarray(F), jnp.eye(4), Q)
    start = values["P0"] * jnp.eye(4)
    return LinearModel(transition, jnp.eye(2, 4), R, start, jnp.zeros(4))


def posed(known: Targets, *, full: bool, truth: bool) -> Problem:
    """Two factors on Q and R, or both matrices; by the error, or by the likelihood."""
    Q, R = true_noise(known)
    kept: dict[str, Any] = {"P0": Fixed(P0, "m^2", nominal=True)}
    if full:
        # That of the truth has rank 2: a turn moves place and speed alike.
        kept["Q"] = Covariance(_nested(Q + np.eye(4)), 1e-3, 1e3)
        kept["R"] = Covariance(_nested(R), 1e-3, 1e3)
    else:
        kept["Q"], kept["R"] = Fixed(_nested(Q)), Fixed(_nested(R))
        kept |= {f"{n}_factor": Positive(1.0, 1e-6, 1e6) for n in ("Q", "R")}
    if truth and not full:  # the same filters: the error depends on ratios only
        kept |= {"R_factor": Fixed(1.0, nominal=True), "P0": Positive(P0, 1.0, 1e9, "m^2")}
    error = ChannelRmse("x", parts=2)
    return Problem(
        name=f"okf_{'matrices' if full else 'factors'}_{'error' if truth else 'likelihood'}",
        space=Space(tuple(kept.items())),
        filter=Tracks(known.z.shape[1]),
        build=model,
        objective=error if truth else InnovationLikelihood(),
        data=Data(known.samples, of_position(known) if truth else 0 * known.z),
    )


def of_position(known: Targets) -> np.ndarray:
    """The truth of the positions alone."""
    truth = known.truth.copy()
    truth[..., 2:] = np.nan
    return truth


def _nested(matrix: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(map(tuple, matrix.tolist()))


class Outcome(NamedTuple):
    """On targets that were not tuned on: mean square error, m^2; NIS; NEES of the two positions."""

    mse: float
    nis: float
    nees: float


def outcome(known: Targets, problem: Problem, values: dict[str, Any]) -> Outcome:
    """The errors of parameters on some targets."""
    judge = replace(
        problem,
        filter=Tracks(known.z.shape[1]),
        objective=ChannelRmse("x", parts=2),
        data=Data(known.samples, of_position(known)),
    )
    nees = nees_of(judge, values)
    assert nees is not None
    return Outcome(judge.score(values) ** 2, nis_of(judge, values), 2 * nees)


def values_of(solution: Solution) -> dict[str, np.ndarray]:
    """Parameters by name."""
    return {name: parameter.value for name, parameter in solution.parameters.items()}


def results(file: Path) -> dict[str, tuple[Outcome, Solution | None]]:
    """The errors of each way of tuning on the held-out targets."""
    tuned_on, judge = targets(file)
    factors = posed(tuned_on, full=False, truth=True)
    found: dict[str, tuple[Outcome, Solution | None]] = {}
    begun = factors.parameters(factors.space.start())
    found["true noise"] = outcome(judge, factors, begun), None
    solver = Gradient("l-bfgs-b", seed=0, starts=1)
    for name, full, truth in (
        ("two factors, likelihood", False, False),
        ("two factors, error", False, True),
        ("full matrices, error", True, True),
    ):
        problem = posed(tuned_on, full=full, truth=truth)
        solution = solver(problem)
        found[name] = outcome(judge, problem, values_of(solution)), solution
        if truth:
            scaled, _ = scale_variances(problem, solution)
            found[f"{name}, rescaled"] = outcome(judge, problem, values_of(scaled)), scaled
    return found


def main(arguments: list[str] | None = None) -> int:
    """Tune, judge, and print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.okf_lidar",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, help="lengths, states and measurements, an NPZ file")
    file, said = parser.parse_args(arguments).file, Console(width=120)
    if not file.exists():
        said.print(f"skipped: there is no {file}", markup=False)
        return 0
    begun = time.perf_counter()
    found = results(file)
    table = Table("tuned by", "test MSE, m^2", "NIS", "NEES (2)", "status")
    for name, (out, solution) in found.items():
        status = "" if solution is None else solution.status.value
        table.add_row(name, f"{out.mse:.3f}", f"{out.nis:.3g}", f"{out.nees:.3g}", status)
    said.print(table)
    for name, (_, solution) in found.items():
        if solution is not None:
            said.print(f"{name}: {told(solution)}", markup=False)
    said.print(f"in {time.perf_counter() - begun:.1f} s")
    return 0


def spread(parameter: TunedParameter) -> str:
    """Its interval; of a matrix the standard deviation of each entry."""
    if parameter.interval is not None:
        return f" {range_in_words(parameter.interval, parameter.interval_kind)}"
    if parameter.deviation is None:
        return ""
    numbers = np.array2string(parameter.deviation, precision=2, separator=", ")
    return f" +- {numbers}".replace("\n", "")


def told(solution: Solution) -> str:
    """Numbers with their intervals; matrices as they are."""
    words = []
    for name, parameter in solution.parameters.items():
        if name in ("Q", "R") and f"{name}_factor" in solution.parameters:
            continue
        numbers = np.array2string(parameter.value, precision=4, separator=", ").replace("\n", "")
        words.append(f"{name} = {numbers}{spread(parameter)}")
    return "; ".join(words)


if __name__ == "__main__":
    sys.exit(main())
