"""The paper's figures 5, 6, 8 and 9, and the trade-off behind its cost, as data."""

from collections.abc import Iterator
from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np

from filters import AnyFilter, KownackiNoise, run
from objectives import Folded, StepCost, StepResponse
from studies.kownacki2010 import problems
from studies.kownacki2010.data import Bench
from studies.kownacki2010.paper import ACC
from tuner.problem.problem import Problem
from tuner.problem.surface import grid
from tuner.run.figure import Chart, Figure, Line, Map, merged
from tuner.run.study import Solutions, best

POINTS = 1000  # samples of a curve: the resolution of a picture


def figures(benches: list[Bench], solutions: Solutions) -> Iterator[Figure]:
    """All figures of every sensor."""
    for bench in benches:
        ratio = best(bench.sensor.name, solutions).derived["q_over_r"]
        yield _sweeps(bench)
        yield _surface(bench, ratio)
        yield _responses(bench, ratio)
        yield _tradeoff(bench, ratio)


def own_figures(benches: list[Bench], solutions: Solutions) -> Iterator[Figure]:
    """The figures of a user's record: the step response at the optimum, and the trade-off."""
    for bench in benches:
        ratio = best(bench.sensor.name, solutions).derived["q_over_r"]
        yield _responses(bench, ratio, published=False)
        yield _tradeoff(bench, ratio, published=False)


def _sweeps(bench: Bench) -> Figure:
    """Figs 5 and 6: one of R, Q and P0 at an extreme, the others as in Table 1."""
    R, Q = bench.noise
    ones = np.ones((2, 2))
    sweeps = {
        "R = 1e-30, as good as 0": KownackiNoise(1e-30, Q, ones),
        "R = 1": KownackiNoise(1.0, Q, ones),
        "Q = 0": KownackiNoise(R, 0.0, ones),
        "Q = 1": KownackiNoise(R, 1.0, ones),
        "R, Q of the record": KownackiNoise(R, Q, ones),
        "the same, P0 = 1e-6": KownackiNoise(R, Q, 1e-6 * ones),
    }
    figure = "fig5_acc" if bench.sensor is ACC else "fig6_gyro"
    chart = _chart(bench, figure, "", sweeps)
    *answers, step = chart.lines
    distinct = merged(answers)
    title = f"{len(answers)} settings of R, Q and P0, {len(distinct)} different answers"
    return replace(chart, title=f"{title} ({bench.sensor.name})", lines=(*distinct, step))


def _responses(bench: Bench, ratio: float, *, published: bool = True) -> Figure:
    """Fig 9: the step response at Table 2's ratio and at the optimum of this record."""
    table, ones = bench.sensor.table2, np.ones((2, 2))
    chosen = {"Table 2": KownackiNoise(table.R, table.Q, ones)} if published else {}
    chosen[f"optimum, Q/R = {ratio:.4g}"] = KownackiNoise(bench.R, ratio * bench.R, ones)
    name = f"{'fig9' if published else 'step'}_{bench.sensor.name}"
    chart = _chart(bench, name, "", chosen, window=(0.48, 0.65))
    *answers, step = chart.lines
    times = ", ".join(_rise(line, step, line.label.partition(",")[0]) for line in answers)
    return replace(chart, title=f"90 % of the step is reached {times} ({bench.sensor.name})")


def _rise(answer: Line, step: Line, name: str) -> str:
    """When an answer reaches 90 % of the step after it, in words."""
    begun = answer.x[np.argmax(step.y > 0.5 * step.y[-1])]
    reached = answer.x[answer.y >= 0.9 * step.y[-1]]
    by = "at the optimum" if name == "optimum" else f"with {name}"
    return f"after {reached[0] - begun:.2g} s {by}" if len(reached) else f"later {by}"


def _chart(
    bench: Bench,
    name: str,
    title: str,
    chosen: dict[str, KownackiNoise],
    window: tuple[float, float] = (0.0, 1.0),
) -> Chart:
    """The filter's response to step and record, over a window of the record (from 0 to 1)."""
    time = np.arange(len(bench.record)) * bench.dt
    first, last = (share * (len(time) - 1) for share in window)
    shown = np.unique(np.linspace(first, last, POINTS).astype(int))
    answers = {
        label: np.asarray(_answer(bench.filter, p, bench.signals)) for label, p in chosen.items()
    }
    return Chart(
        name=name,
        title=f"{title} ({bench.sensor.name})",
        x_label="time, s",
        y_label=f"output, {bench.unit}",
        lines=(
            *(Line(label, time[shown], answer[shown]) for label, answer in answers.items()),
            Line("step", time[shown], bench.step[shown]),
        ),
    )


@jax.jit(static_argnums=0)
def _answer(filter: AnyFilter, params: KownackiNoise, signals: jax.Array) -> jax.Array:
    return jnp.sum(run(filter, params, signals)[1], axis=1)


def _surface(bench: Bench, ratio: float) -> Figure:
    """Fig 8: the cost over R and Q, on logarithmic axes, where its valley shows."""
    problem = problems.paper(bench)
    R = np.logspace(-13, 0, bench.settings.grid)
    Q = np.logspace(-13, 2, bench.settings.grid)
    published = bench.sensor.table2
    inside = (R * ratio >= Q[0]) & (R * ratio <= Q[-1])
    return Map(
        name=f"fig8_{bench.sensor.name}",
        title=f"Cost (10), reading {bench.settings.reading}, is lowest along a line of "
        f"constant Q/R = {ratio:.4g} ({bench.sensor.name})",
        x_label=f"R, ({bench.unit})^2",
        y_label=f"Q, ({bench.unit})^2/s^2",
        z_label="cost",
        x=R,
        y=Q,
        z=np.asarray(grid(problem, {"R": R, "Q": Q})),
        marks=(
            Line(f"Q/R = {ratio:.4g}", R[inside], (R * ratio)[inside]),
            Line("Table 2", np.array([published.R]), np.array([published.Q])),
            Line("Table 1", np.array([bench.sensor.table1.R]), np.array([bench.sensor.table1.Q])),
        ),
        log="xyz",
    )


def _tradeoff(bench: Bench, ratio: float, *, published: bool = True) -> Figure:
    """Inertia against noise over Q/R: every point is the best for some weight of the noise."""
    problem = problems.problem(bench)
    ratios = ratio * np.logspace(-3, 3, 61)
    inertia, noise = (np.asarray(part) for part in _parts(problem, bench.R * ratios))
    optima = [int(np.argmin(inertia + weight * noise)) for weight in (0.5, 1.0, 2.0)]
    words = ("half weight", "weight 1", "double weight")
    return Chart(
        name=f"tradeoff_{bench.sensor.name}",
        title=f"Less noise costs more inertia, whatever Q/R ({bench.sensor.name})",
        x_label=f"noise term, reading {bench.settings.reading}",
        y_label=f"inertia term, ({bench.unit})^2 s",
        lines=(
            Line("Q/R from a thousandth to a thousandfold", noise, inertia),
            *(
                Line(f"{word}: Q/R = {ratios[i]:.4g}", noise[[i]], inertia[[i]])
                for word, i in zip(words, optima, strict=True)
            ),
            *(_of_table_2(bench, problem) if published else ()),
        ),
        log="xy",
    )


def _of_table_2(bench: Bench, problem: Problem) -> tuple[Line]:
    ratio = bench.sensor.table2.Q / bench.sensor.table2.R
    there = _parts(problem, np.array([bench.R * ratio]))
    x, y = np.asarray(there.noise), np.asarray(there.inertia)
    return (Line(f"Table 2: Q/R = {ratio:.4g}", x, y),)


def _parts(problem: Problem, Q: np.ndarray) -> StepCost:
    """Both terms of (10) at each Q, one after another to save memory."""
    fixed = problem.parameters(problem.space.start())
    filter, objective = problem.filter, problem.objective
    if filter is None or not isinstance(objective, StepResponse):
        raise TypeError(f"{problem.name} is not judged by a step response")

    def both(q: jax.Array) -> StepCost:
        params = KownackiNoise(fixed["R"], q, fixed["P0"])
        (_, total), kept = run(Folded(filter, objective), params, problem.data)
        return objective.parts(total, kept)

    return StepCost(*jax.jit(lambda qs: jax.lax.map(both, qs))(jnp.asarray(Q)))
