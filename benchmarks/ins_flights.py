"""An error-state INS on recorded flights: ``python -m benchmarks.ins_flights FOLDER``.

The folder holds the flights of the study uav (docs/uav.md). The INS gets what the study's filter
gets, inertial samples and GPS positions, and begins with an unknown heading. Its noise is tuned by
the likelihood of its innovations on the study's flight, and judged on the others beside typical
values and the study's own filter, tuned on the same flight.
"""

import argparse
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from rich.console import Console
from rich.table import Table

from filters import ErrorStateIns, InsSample, assembled, parameter_facts, run
from filters.ins_motion import Motion, moved
from objectives import Data, InnovationLikelihood
from studies.uav.flights import Flight, flight, over_ticks
from studies.uav.judging import Field, by_update
from studies.uav.prediction import predicted, starts
from studies.uav.problems import problem
from studies.uav.recordings import GRAVITY, Delays, Units, read
from studies.uav.settings import ANGLES, Settings
from tuner.certificate.solution import Solution
from tuner.problem.problem import Problem
from tuner.problem.space import Space
from tuner.solvers import Gradient

AHEAD = 3
"""Positions are predicted so many seconds ahead."""
FINER = 2
"""Ticks of the INS in one of the study's."""
FREE = ("q_gyr", "q_acc", "q_gyr_bias", "q_acc_bias", "R_gps")
COUNTED = slice(0, 2)
"""Of the innovations: level GPS positions. Heights are taken loosely and not counted, for one
receiver has smooth ones, and others' jump by tens of metres."""
KNOWN = {"gravity": GRAVITY, "heading0": 1.8}
"""Deviation of an unknown heading, that of a uniform direction: pi / sqrt 3."""


@dataclass(frozen=True, eq=False)
class Flown:
    """A flight as both filters take it.

    Attributes:
        study: as the study has it.
        t: times of the INS's ticks, s, ``(N,)``.
        sample: its inputs; axes north, east, down.
        counted: positions whose innovations count, ``(N, 12)``; NaN for all others.
    """

    study: Flight
    t: np.ndarray
    sample: InsSample
    counted: np.ndarray


class Judged(NamedTuple):
    """Mean horizontal error of predictions, m, and mean of innovation^2 / variance."""

    error: float
    nis: float


@dataclass(frozen=True)
class Coasting:
    """Navigation without aiding, for :func:`filters.run`: from a motion, by rates and forces."""

    dt: float

    def init(self, params: Motion) -> Motion:
        return params

    def step(
        self, params: Motion, state: Motion, inputs: tuple[Array, Array]
    ) -> tuple[Motion, Array]:
        down = jnp.array([0.0, 0.0, -GRAVITY])
        ahead, _ = moved(state, *inputs, down, jnp.asarray(self.dt))
        return ahead, ahead.position


def flown(folder: str, name: str) -> Flown:
    """One flight; a fix goes to the tick that is nearest to when it was true."""
    asked = Settings()
    recording = read(folder, name, Units(), Delays(asked.velocity_delay, asked.position_delay))
    study = flight(recording, 1 / asked.ticks_per_second, asked.slowest, GRAVITY)
    channels, dt = recording.record.channels, study.dt / FINER
    acc, gyr, fixes = (channels[each] for each in ("acc", "gyr", "position"))
    true = fixes.times - recording.delays.position
    begin = max(acc.times[0], true[0])
    count = FINER * round((study.t[-1] - begin) / study.dt)
    edges = begin + dt * np.arange(count + 1)
    gps = np.full((count, 3), np.nan)
    at = np.round((true - edges[1]) / dt).astype(int)
    within = (at >= 0) & (at < count)
    gps[at[within]] = fixes.values[within]
    counted = np.full((count, 12), np.nan)
    counted[:, COUNTED] = gps[:, COUNTED]
    counted[at[within][0]] = np.nan  # the first fix begins the position
    parts = over_ticks(gyr.times, gyr.values, edges), over_ticks(acc.times, acc.values, edges), gps
    return Flown(study, edges[1:], InsSample(*(jnp.asarray(part) for part in parts)), counted)


def posed(tuned: Flown) -> Problem:
    """The INS's noise by the likelihood of its innovations."""
    filter = ErrorStateIns(tuned.study.dt / FINER, "ned")
    fixed = {
        name: KNOWN.get(name, fact.typical)
        for name, fact in parameter_facts(filter).items()
        if name not in FREE
    }
    space = Space.of_filter(filter, **fixed)
    steady = space.unconstrain({"q_gyr": 1e-7, "q_gyr_bias": 1e-8, "q_acc": 0.1, "R_gps": 0.1})
    return Problem(
        name="ins",
        space=space,
        known_starts=(steady,),
        filter=filter,
        build=None,
        objective=InnovationLikelihood(),
        data=Data(tuned.sample, jnp.asarray(tuned.counted)),
        source=tuned.study.source,
    )


def tune(problem: Problem, starts: int) -> Solution:
    """L-BFGS-B, as far as the study searches: from typical values, then from the known start."""
    solver = Gradient("l-bfgs-b", seed=0, starts=starts, gradient=1e-4, iterations=40)
    return solver(problem)


def judged(known: Flown, values: Mapping[str, Any]) -> Judged:
    """The errors of the INS on a flight; a glitch of the GPS and 5 s around it do not count."""
    filter = ErrorStateIns(known.study.dt / FINER, "ned")
    ran = _run(filter, assembled(filter, values), known.sample)
    motion, innovation, variance = jax.tree.map(np.asarray, ran)
    near = [np.abs(known.t - at) <= 5 for at in known.study.jumps]
    keep = ~np.isnan(known.counted) & ~np.any([*near, 0 * known.t > 0], axis=0)[:, None]
    nis = float((innovation[keep] ** 2 / variance[keep]).mean())
    found, ticks = starts(known.study), round(AHEAD / filter.dt)
    study = found[~_glitched(known.study, found)] + known.study.every
    at = np.round((known.study.t[study] - known.t[0]) / filter.dt).astype(int)
    ahead = at[:, None] + 1 + np.arange(ticks)
    begun = jax.tree.map(lambda leaf: jnp.asarray(leaf[at]), motion)
    carried = (jnp.asarray(known.sample[i])[ahead] for i in range(2))
    position = np.asarray(_coast(Coasting(filter.dt), begun, *carried))[:, -1]
    apart = position - known.study.position[study + AHEAD * known.study.every]
    return Judged(float(np.hypot(apart[:, 0], apart[:, 1]).mean()), nis)


def _glitched(study: Flight, found: np.ndarray) -> np.ndarray:
    ticks = found[:, None] + 1 + np.arange(6 * study.every)
    return np.asarray(study.glitch[ticks].any(axis=1))


@jax.jit(static_argnums=0)
def _run(filter: ErrorStateIns, params: Any, sample: InsSample) -> tuple[Motion, Array, Array]:
    out = run(filter, params, sample)[1]
    return Motion(*out[:5]), out.innovation, out.variance


@jax.jit(static_argnums=0)
def _coast(filter: Coasting, begun: Motion, gyr: Array, acc: Array) -> Array:
    return jax.vmap(lambda at, *u: run(filter, at, u)[1])(begun, gyr, acc)


def by_study(tuned: Flown, others: list[Flown]) -> dict[str, Judged]:
    """The study's filter, constant law, tuned as in the study."""
    solution = tune(problem(tuned.study, "constant", ANGLES), starts=2)
    values = {name: float(p.value) for name, p in solution.parameters.items()}
    field = Field(tuned.study, tuple(each.study for each in others), ANGLES)
    found = {}
    for each in field.flights:
        outcome = field.outcome(each, "constant", values)
        ahead = predicted(each, outcome)
        error = ahead.horizontal[~ahead.glitch, AHEAD - 1].mean()
        found[each.name] = Judged(float(error), float(by_update(outcome.nis, ~each.glitch).mean()))
    return found


def _add_means(table: Table, rows: list[tuple[Judged, ...]]) -> None:
    """Over the flights that were not tuned on: the mean error, and by what factor NIS is off 1."""
    found = np.array(rows)
    means = found[..., 0].mean(axis=0)
    factors = np.exp(np.abs(np.log(found[..., 1])).mean(axis=0))
    table.add_section()
    table.add_row("all but the first", f"{AHEAD} s ahead, m", *(f"{mean:.2f}" for mean in means))
    table.add_row("", "NIS, factor off 1", *(f"{factor:.2f}" for factor in factors))


def main(arguments: list[str] | None = None) -> int:
    """Tune, judge, and print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.ins_flights", description=__doc__)
    parser.add_argument("folder", help="folder of the flights: zips, or folders of text files")
    folder, said = parser.parse_args(arguments).folder, Console(width=120)
    asked = Settings()
    tuned, *others = (flown(folder, name) for name in (asked.tuned, *asked.judged))
    ours = posed(tuned)
    solution = tune(ours, starts=2)
    values = {name: float(p.value) for name, p in solution.parameters.items()}
    typical = {name: float(v) for name, v in ours.parameters(ours.space.start()).items()}
    study = by_study(tuned, others)
    table = Table("flight", "what", "start", "tuned", "study uav")
    rows = {
        each.study.name: (judged(each, typical), judged(each, values), study[each.study.name])
        for each in (tuned, *others)
    }
    for name, three in rows.items():
        table.add_row(name, f"{AHEAD} s ahead, m", *(f"{found.error:.2f}" for found in three))
        table.add_row("", "NIS", *(f"{found.nis:.2f}" for found in three))
    _add_means(table, [rows[each.study.name] for each in others])
    said.print(table)
    numbers = ", ".join(f"{name} = {values[name]:.3g}" for name in FREE)
    said.print(f"tuned on {tuned.study.name} ({solution.status.value}): {numbers}", markup=False)
    return 0


if __name__ == "__main__":
    sys.exit(main())
