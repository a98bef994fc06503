"""``python -m benchmarks.starts``: four starts side by side against one after another, in turns."""

import os
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import chain

import jax.numpy as jnp
import numpy as np
from jax import Array
from rich.console import Console

from benchmarks.table import Row, duration, markdown, show
from benchmarks.timing import interleave
from filters import LinearKalman, LinearModel, Sample, Transition
from objectives import Data, InnovationLikelihood
from tuner import Positive, Problem, Space
from tuner.solvers.blas import blas_on_one_thread
from tuner.solvers.gradient import minimise
from tuner.solvers.minimum import Minimum
from tuner.solvers.side_by_side import MANY, descents
from tuner.solvers.simplex import boxed

PART = "Four starts"
STARTS, SEEDS, ROUNDS = 4, (1, 2, 3), 9
ENOUGH = 1.8
LIMITS = {"gtol": 1e-8, "maxiter": 200}
TRIALS = 60
UNEQUAL = "the last descent leaves a processor idle"
SHORT = "a third of the time goes to Python, for which the threads wait"
Descent = Callable[[Problem, np.ndarray], Minimum]


def plane(values: dict[str, Array]) -> LinearModel:
    """Nearly constant velocity along two axes."""
    step, push = jnp.array([[1.0, 0.1], [0.0, 1.0]]), jnp.array([[0.005], [0.1]])
    noise = jnp.diag(jnp.stack([values["qx"], values["qy"]]))
    move = Transition(jnp.kron(jnp.eye(2), step), jnp.kron(jnp.eye(2), push), noise)
    seen = jnp.kron(jnp.eye(2), jnp.eye(1, 2))
    R = jnp.stack([values["rx"], values["ry"]])
    return LinearModel(move, seen, R, 10 * jnp.eye(4), jnp.zeros(4))


def tracked(samples: int) -> Problem:
    """The likelihood of a track, with two noises on each axis."""
    draw = np.random.default_rng(0)
    speed = np.cumsum(0.1 * draw.normal(size=(samples, 2)), 0)
    z = np.cumsum(0.1 * speed, 0) + 0.5 * draw.normal(size=(samples, 2))
    space = Space.of(**{name: Positive(1.0, 1e-4, 1e4) for name in ("qx", "qy", "rx", "ry")})
    data = Data(Sample(z), np.zeros(samples))
    return Problem("track", space, LinearKalman(), plane, InnovationLikelihood(), data)


def by_gradients(problem: Problem, z: np.ndarray) -> Minimum:
    """The descent of l-bfgs-b."""
    return minimise(problem, z, "l-bfgs-b", LIMITS, problem.space.box())


def by_simplex(problem: Problem, z: np.ndarray) -> Minimum:
    """As many trials from each start."""
    box = problem.space.box()
    return boxed(problem.value, z, box, step=0.5, tolerance=0.0, limit=TRIALS)


def rows(sizes: Sequence[int] = (1000, 10_000, 100_000, 300_000)) -> list[Row]:
    """Both descents on tracks of some lengths; C takes part where it pays."""
    ways = {"l-bfgs-b": by_gradients, f"simplex, {TRIALS} trials each": by_simplex}
    return [_row(samples, name, descend) for samples in sizes for name, descend in ways.items()]


def _row(samples: int, name: str, descend: Descent) -> Row:
    problem, threads = tracked(samples), os.cpu_count() or 1
    draws = [problem.starts(STARTS, seed) for seed in SEEDS]
    run = partial(_ends, problem, descend, draws)
    with blas_on_one_thread(), ThreadPoolExecutor(threads) as pool:
        alone, together = run(1), run(threads)
        counts = [[end.evaluations for end in ends] for ends in alone]
        evaluate = problem.value if descend is by_simplex else problem.value_and_gradient
        share = [[draws[0][0]] * (sum(map(sum, counts)) // threads)] * threads
        calls = {
            "alone": lambda: run(1),
            "together": lambda: run(threads),
            "evaluations": lambda: [list(map(evaluate, each)) for each in share],
            "in threads": lambda: list(pool.map(lambda each: list(map(evaluate, each)), share)),
        }
        times = interleave(calls, ROUNDS)
    gain, machine = times.ratio("alone", "together"), times.ratio("evaluations", "in threads")
    pairs = zip(chain(*alone), chain(*together), strict=True)
    same = all(a.z.tobytes() == b.z.tobytes() for a, b in pairs)
    row = Row(
        part=PART,
        what=f"{samples} samples, {name}",
        ours=duration(times.median("together")),
        against=f"one after another: {duration(times.median('alone'))}",
        figure=gain.median,
        best=gain.best,
        note=f"{len(SEEDS)} draws of {STARTS} starts; {'the same' if same else 'OTHER'} ends to "
        f"the last bit; evaluations {'; '.join(', '.join(map(str, each)) for each in counts)} let "
        f"{threads} threads gain {_bound(counts, threads):.2f} x at most, and as many evaluations "
        f"in equal shares gained {machine.median:.2f} x on this machine; gradients by "
        f"{(problem.gradient_by or 'none').split(':')[0]}",
    )
    return replace(row, target=ENOUGH, sense="least", why=UNEQUAL if samples >= MANY else SHORT)


def _ends(
    problem: Problem, descend: Descent, draws: Sequence[np.ndarray], threads: int
) -> list[list[Minimum]]:
    return [list(descents(problem, descend, points, STARTS, threads)) for points in draws]


def _bound(draws: Sequence[Sequence[int]], threads: int) -> float:
    """The gain where the first start comes last, and each goes to the thread that is free first.

    >>> _bound([[20, 20, 20, 20]], 2), _bound([[10, 30], [10, 20, 30]], 2)
    (2.0, 1.6666666666666667)
    """
    longest = 0
    for first, *others in draws:
        busy = [0] * threads
        for count in (*others, first):
            busy[busy.index(min(busy))] += count
        longest += max(busy)
    return sum(map(sum, draws)) / longest


def main() -> int:
    """Print the table."""
    found = rows()
    show(found, Console(width=None if sys.stdout.isatty() else 160))
    if "--markdown" in sys.argv:
        print(markdown(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
