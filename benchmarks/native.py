"""``python -m benchmarks.native``: gradients by compiled C against XLA's, in turns."""

import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import jax.numpy as jnp
import numpy as np
from jax import Array
from rich.console import Console

from benchmarks.by_c import native
from benchmarks.extended import DELTA, DT, NOISE, record
from benchmarks.gradients import extended
from benchmarks.table import Row, duration, markdown, show
from benchmarks.timing import interleave
from benchmarks.work import Work
from filters import LinearKalman, LinearModel, Sample, TiltKalman, TiltNoise, Transition
from objectives import Data, InnovationLikelihood, Reading
from tuner import Positive, Problem, Space, values_and_gradients
from tuner.compiler import NoCodeError, compiler
from tuner.native.backwards import Backwards
from tuner.native.compiled import Native

PART = "Gradients by compiled C"
SAMPLES, ROUNDS, POINTS = 20_000, 9, 256
IN_A_TURN = 4
"""Calls in a turn: a search evaluates one point after another, with the record at hand."""
PENDULUMS = (5, 9, 15)
"""States of extended filters."""
AGREED = 1e-11
BUSY = "both ways are vector code, which other work on the machine stretches unequally"


@dataclass(frozen=True)
class Power:
    """The sum of squared angles."""

    def init(self) -> Array:
        return jnp.zeros(())

    def update(self, total: Array, output: Any, truth: Any) -> tuple[Array, None]:
        return total + (output.angles**2).sum(), None

    def value(self, total: Array, kept: None) -> Array:
        return total


def tilt(values: dict[str, Array]) -> TiltNoise:
    """The extended filter's parameters: six of them are tuned."""
    return TiltNoise(
        q1=values["q1"],
        r_nom=jnp.stack([values["r1"], values["r2"]]),
        r3=values["r3"],
        alpha1=values["alpha1"],
        alpha2=values["alpha2"],
        delta=jnp.asarray(DELTA),
        r_big=jnp.asarray(1.0),
        gravity=jnp.ones(()),
        x0=jnp.zeros(5),
        P0=jnp.asarray(1e-2),
    )


def _six(values: dict[str, Array]) -> tuple[Array, Array]:
    return (
        jnp.stack([values[f"q{k}"] for k in range(3)]),
        jnp.stack([values[f"r{k}"] for k in range(3)]),
    )


def axes(values: dict[str, Array]) -> LinearModel:
    """Constant acceleration on three axes: nine states, of which a third hang together."""
    q, r = _six(values)
    step = jnp.array([[1.0, 0.01, 5e-5], [0.0, 1.0, 0.01], [0.0, 0.0, 1.0]])
    push = jnp.kron(jnp.eye(3), jnp.array([[0.0], [0.0], [0.1]]))
    move = Transition(jnp.kron(jnp.eye(3), step), push, jnp.diag(q))
    return LinearModel(move, jnp.kron(jnp.eye(3), jnp.eye(1, 3)), r, jnp.eye(9), jnp.zeros(9))


_DENSE = 0.99 * np.linalg.qr(np.random.default_rng(3).normal(size=(9, 9)))[0]


def dense(values: dict[str, Array]) -> LinearModel:
    """Nine states that all hang together."""
    q, r = _six(values)
    move = Transition(jnp.asarray(_DENSE), jnp.eye(9, 3), jnp.diag(q))
    return LinearModel(move, jnp.asarray(_DENSE[:3]), r, jnp.eye(9), jnp.zeros(9))


def posed() -> dict[str, tuple[Problem, float | None]]:
    """A problem to differentiate, and the required speedup by C."""
    names = ("q1", "r1", "r2", "r3", "alpha1", "alpha2")
    six = {
        name: Positive(value, value / 1e3, value * 1e3)
        for name, value in zip(names, NOISE, strict=True)
    }
    sample = record()
    angles = Data(sample, np.zeros(len(sample[0])))
    noises = Space.of(**{f"{name}{k}": Positive(0.1, 1e-4, 1e2) for name in "qr" for k in range(3)})
    draw = np.random.default_rng(0)
    z = np.cumsum(0.01 * draw.normal(size=(SAMPLES, 3)), 0) + draw.normal(size=(SAMPLES, 3))
    z[draw.random(z.shape) < 0.05] = np.nan
    places, likely = Data(Sample(z), np.zeros(SAMPLES)), InnovationLikelihood()
    linear = partial(Problem, space=noises, filter=LinearKalman(), objective=likely, data=places)
    return {
        "gyroscope filter, R1, 2 parameters": (Work().problem(Reading.R1), 2.0),
        "extended filter, 5 states, 6 parameters": (
            Problem("tilt", Space.of(**six), TiltKalman(DT), tilt, Power(), angles),
            8.0,
        ),
        "LinearKalman, 3 x 3 states, 6 parameters": (linear(name="axes", build=axes), 8.0),
        "LinearKalman, 9 dense states, 6 parameters": (linear(name="dense", build=dense), None),
    }


def rows() -> list[Row]:
    """C against XLA for each; nothing but a word without a compiler."""
    try:
        compiler()
    except NoCodeError as error:
        return [Row(PART, "gradients by compiled C", note=str(error))]
    found = []
    for name, (problem, target) in posed().items():
        found += [*_gradient(name, problem, target), _compiling(name, problem)]
    for n in PENDULUMS:
        found += _over_a_value(n)
    return [*found, _together(Work().problem(Reading.R1))]


def _gradient(name: str, problem: Problem, target: float | None) -> list[Row]:
    """C against XLA's faster way, and against its way forwards."""
    z, forwards = problem.space.start(), replace(problem, way="forwards")
    with native("on"):
        gradient = problem.value_and_gradient(z)[1]
    right = problem.by_xla(z)
    apart = float(np.abs(gradient - right[1]).max() / np.abs(right[1]).max())
    calls: dict[str, Callable[[], object]] = {
        "C": lambda: problem.value_and_gradient(z),
        "XLA": lambda: problem.by_xla(z),
    }
    if not apart <= AGREED or not problem.route.choice.startswith("C, "):
        raise AssertionError(f"{name}: differs by {apart:.1g}; {problem.route.choice}")
    note = f"gradients differ by {apart:.0e} of the largest at most"
    found = [_row(name, calls, target, note, f", {problem.gradient_way}")]
    if problem.gradient_way != "forwards" and target is not None:
        calls["XLA"] = lambda: forwards.by_xla(z)
        found.append(_row(f"{name}, forwards", calls, target, note, ", forwards"))
    return [*found, _value(name, problem)]


def _value(name: str, problem: Problem) -> Row:
    """A value alone, as a simplex search needs it."""
    z = problem.space.start()
    with native("on"):
        value = problem.value(z)
    right = problem.value_by_xla(z)
    apart = abs(value - right) / abs(right)
    if not apart <= AGREED or not problem.route.values_by:
        raise AssertionError(f"{name}: values differ by {apart:.1g}; {problem.route.values_by}")
    calls = {"C": lambda: problem.value(z), "XLA": lambda: problem.value_by_xla(z)}
    return _row(f"{name}, value alone", calls, None, f"values differ by {apart:.0e} at most")


def pendulums(n: int) -> Problem:
    """An extended filter of n states, of which 12 parameters at most are tuned."""
    free = min(12, n + 2)
    filter, build, inputs = extended(n, free)
    names = [f"p{k}" for k in range(free)]
    space = Space.of(**{name: Positive(1.0, 1e-3, 1e3) for name in names})
    noises = lambda values: build(jnp.log(jnp.stack([values[k] for k in names])))  # noqa: E731
    data = Data(inputs, np.zeros(len(inputs.z)))
    return Problem("pendulums", space, filter, noises, InnovationLikelihood(), data)


def _over_a_value(n: int) -> list[Row]:
    """A gradient by C over a value by XLA, and over one by C."""
    problem = pendulums(n)
    z = problem.space.start()
    with native("on"):
        gradient = problem.value_and_gradient(z)[1]
        problem.value(z)
    apart = float(np.abs(gradient - problem.by_xla(z)[1]).max() / np.abs(gradient).max())
    if not apart <= AGREED or not problem.route.choice.startswith("C, "):
        raise AssertionError(f"{n} states: differs by {apart:.1g}; {problem.route.choice}")
    calls: dict[str, Callable[[], object]] = {
        "gradient": lambda: problem.value_and_gradient(z),
        "XLA": lambda: problem.value_by_xla(z),
        "C": lambda: problem.value(z),
    }
    times = interleave(calls, ROUNDS, dict.fromkeys(calls, IN_A_TURN))
    found = []
    for name in ("XLA", "C"):
        ratio = times.ratio("gradient", name)
        row = Row(
            part=PART,
            what=f"extended filter, {n} states, {len(z)} parameters: gradient over {name}'s value",
            ours=duration(times.median("gradient")),
            against=f"{name}, value: {duration(times.median(name))}",
            figure=ratio.median,
            best=ratio.best,
            target=2.0,
            note=f"gradients differ by {apart:.0e} of the largest at most",
            why=BUSY,
        )
        found.append(row)
    return found


def _together(problem: Problem) -> Row:
    """Many points at once, in as many threads as there are processors."""
    Z = problem.space.start() + np.random.default_rng(1).uniform(-2, 2, (POINTS, 2))
    twin = Work().problem(Reading.R1)
    with native("on"):
        found = values_and_gradients(problem, Z)[1]
    with native("off"):
        right = values_and_gradients(twin, Z)[1]
    apart = float(np.abs(found - right).max() / np.abs(right).max())

    def by_c() -> object:
        with native("on"):
            return values_and_gradients(problem, Z)

    calls: dict[str, Callable[[], object]] = {
        "C": by_c,
        "XLA": lambda: values_and_gradients(twin, Z),
    }
    name = f"gyroscope filter, R1, {POINTS} points at once"
    return _row(name, calls, 3.0, f"gradients differ by {apart:.0e} of the largest at most")


def _row(
    name: str,
    calls: dict[str, Callable[[], object]],
    target: float | None,
    note: str,
    way: str = "",
) -> Row:
    times = interleave(calls, ROUNDS, dict.fromkeys(calls, IN_A_TURN))
    ratio = times.ratio("XLA", "C")
    return Row(
        part=PART,
        what=name,
        ours=duration(times.median("C")),
        against=f"XLA{way}: {duration(times.median('XLA'))}",
        figure=ratio.median,
        best=ratio.best,
        target=target,
        sense="least",
        note=note,
        why=BUSY,
    )


def _compiling(name: str, problem: Problem) -> Row:
    """From the problem to a first gradient, with nothing kept from before."""
    static, z = problem.static, problem.space.start()
    with native("on"):
        problem.value_and_gradient(z)
    goes_back = problem.route.goes_back
    taken = []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as folder:
            begun = time.perf_counter()
            build = lambda z: static.built(z)  # noqa: E731, PLW0108  # so that nothing is cached
            given = static.filter, static.objective, build, len(z), problem.data, Path(folder)
            made = Backwards(*given) if goes_back else Native(*given)
            made.value_and_gradient(z, made.rows(problem.data), problem.data)
            taken.append(time.perf_counter() - begun)
    return Row(
        part=PART,
        what=f"until the first: {name}",
        figure=float(np.median(taken)),
        best=min(taken),
        unit="s",
        target=3.0,
        why=BUSY,
    )


if __name__ == "__main__":
    measured = rows()
    if "--md" in sys.argv:
        print(markdown(measured))
    else:
        show(measured, Console(width=160))
