"""The same filter on the same data in other libraries, its output checked."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np

from benchmarks.baseline import Baseline, Weights
from benchmarks.loops import exact
from benchmarks.octave import Search, search
from benchmarks.peers import PEERS
from benchmarks.single import compiled, passes
from benchmarks.table import Row, duration, number
from benchmarks.timing import Call, Times, interleave
from benchmarks.work import DT, STEP, Q, R, Work
from objectives import Reading

PART = "Other implementations of the same filter"
OURS = "gyroscope filter"
EVALUATIONS = 60
OCTAVE = "Octave fminsearch, a cost"


def rows(work: Work, limit: Baseline | None) -> list[Row]:
    """The time of each peer over ours, and the difference of its output from C's."""
    calls = {OURS: passes(work)[OURS]}
    missing = []
    for name, (prepare, target) in PEERS.items():
        try:
            calls[name] = prepare(work.signal, R, Q)
        except ImportError as error:
            note = f"not installed ({error.name}); `pip install filter-tuner[bench]`"
            missing.append(Row(PART, name, target=target, sense="least", note=note))
    expected = _expected(work, limit)
    differ = {name: _difference(call, expected) for name, call in calls.items()}
    if limit is not None:
        calls["C"] = lambda: limit.forward(work.signal, R, Q)
    times = interleave(calls, 5, {OURS: 20, "C": 20})
    found = [_row(name, times, differ[name]) for name in PEERS if name in calls]
    return [*found, *missing, _octave(work)]


def _row(name: str, times: Times, difference: float) -> Row:
    ratio = times.ratio(name, OURS)
    note = f"output differs by {difference:.1g} of the step at most"
    why = ""
    if "C" in times.seconds:
        ceiling = times.ratio(name, "C").median
        note += f"; C is {number(ceiling)} x as fast"
        why = f"C itself is {number(ceiling)} x as fast on this machine"
    return Row(
        part=PART,
        what=name,
        ours=duration(times.median(OURS)),
        against=duration(times.median(name)),
        figure=ratio.median,
        best=ratio.best,
        target=PEERS[name][1],
        sense="least",
        note=note,
        why=why,
    )


def _expected(work: Work, limit: Baseline | None) -> np.ndarray:
    return exact(work.signal, R, Q, DT) if limit is None else limit.forward(work.signal, R, Q)


def _difference(call: Call, expected: np.ndarray) -> float:
    return float(np.abs(np.asarray(call()) - expected).max() / STEP)


def _octave(work: Work) -> Row:
    """On a tenth of the record, as Octave takes a second per evaluation of the whole."""
    short = Work(work.samples // 10, work.repetitions)
    problem = short.problem(Reading.R1)
    truth = problem.data.truth
    weights = Weights(*map(np.asarray, (truth.step, truth.lag_weight, truth.power_weight)))
    found = search(short.signal, weights, EVALUATIONS)
    if found is None:
        return Row(PART, OCTAVE, target=500.0, sense="least", note="Octave is not installed")
    point = jnp.log(jnp.array([R, Q]))
    cost = partial(compiled(problem)["cost"], point, problem.data)
    ours = interleave({"cost": cost}, 15).median("cost")
    return _octave_row(found, float(jax.block_until_ready(cost())), ours, short.samples)


def _octave_row(found: Search, cost: float, ours: float, samples: int) -> Row:
    differs = abs(found.cost / cost - 1)
    return Row(
        part=PART,
        what=OCTAVE,
        ours=duration(ours),
        against=duration(found.seconds),
        figure=found.seconds / ours,
        target=500.0,
        sense="least",
        note=f"cost under R1 of {samples} samples, {found.evaluations} evaluations in Octave's own "
        f"process; its cost differs by {number(differs)} of ours",
    )
