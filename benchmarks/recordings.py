"""``python -m benchmarks.recordings``: a thousand recordings as one objective, beside C."""

import sys
from collections.abc import Callable

import jax.numpy as jnp
import numpy as np
from jax import Array
from rich.console import Console

from benchmarks.gradients import SAMPLES as OF_C
from benchmarks.gradients import in_c, oscillators
from benchmarks.table import Row, markdown, show
from benchmarks.timing import interleave
from filters import Lanes, LinearKalman, LinearModel, Sample, Transition
from objectives import Data, InnovationLikelihood
from tuner import Positive, Problem, Space
from tuner.problem.lines import lines_of
from tuner.problem.programs import value_and_gradient_of, value_of

PART = "Many recordings as one objective, 4 states, 6 parameters"
RECORDINGS, SHORTEST, LONGEST = 1000, 200, 2000
FEWER = 100
"""Recordings of which those padded side by side are measured: more of them take minutes."""
STATES, MEASURED = 4, 2
ROUNDS = 5
MOST = {"value": 50.0, "gradient": 160.0}  # ns a true sample
AGREED = 1e-10
BUSY = "two threads share the processors with whatever else runs; compare the processor's time"
F, H, _ = oscillators(STATES, MEASURED)


def build(values: dict[str, Array]) -> LinearModel:
    """The oscillators of :mod:`benchmarks.gradients`, with the variances of their noise."""
    q = jnp.stack([values[f"q{k}"] for k in range(STATES)])
    r = jnp.stack([values[f"r{k}"] for k in range(MEASURED)])
    step = Transition(jnp.asarray(F), jnp.eye(STATES), jnp.diag(q))
    return LinearModel(step, jnp.asarray(H), r, jnp.eye(STATES), jnp.zeros(STATES))


def recorded(count: int) -> tuple[Problem, int]:
    """The likelihood of recordings of equally likely lengths, and how many samples they have."""
    draw = np.random.default_rng(0)
    lengths = draw.integers(SHORTEST, LONGEST + 1, count)
    x, z = np.zeros((count, STATES)), np.empty((lengths.max(), count, MEASURED))
    for k in range(len(z)):
        x = x @ F.T + draw.normal(size=x.shape)
        z[k] = x @ H.T + draw.normal(size=(count, MEASURED))
    z[np.arange(len(z))[:, None] >= lengths] = np.nan
    names = [*(f"q{k}" for k in range(STATES)), *(f"r{k}" for k in range(MEASURED))]
    space = Space.of(**{name: Positive(1.0, 1e-3, 1e3) for name in names})
    data = Data(Sample(z), np.where(np.isnan(z).all(-1), np.nan, 0.0)[..., None])
    filter = Lanes(LinearKalman(), count)
    return Problem("many", space, filter, build, InnovationLikelihood(), data), int(lengths.sum())


def rows(count: int = RECORDINGS) -> list[Row]:
    """Lines in threads against C on one record, and fewer recordings padded side by side."""
    problem, samples = recorded(count)
    fewer, of_fewer = recorded(min(count, FEWER))
    z = problem.space.start()
    _check(fewer)
    c = in_c(STATES, MEASURED)
    sizes = {"value": samples, "gradient": samples, "C, value": OF_C, "C, gradient": OF_C}
    calls: dict[str, Callable[[], object]] = {
        "value": lambda: problem.value(z),
        "gradient": lambda: problem.value_and_gradient(z),
        "padded, value": lambda: _padded_value(fewer, z),
        "padded, gradient": lambda: _padded_gradient(fewer, z),
        **c,
    }
    sizes |= {"padded, value": of_fewer, "padded, gradient": of_fewer}
    wall = interleave(calls, ROUNDS)
    lines = lines_of(problem.static, problem.data)
    assert lines is not None
    shape = lines.parts[0].inputs.begins.shape
    fill = samples / (len(lines.parts) * shape[0] * shape[1])
    found = []
    for what, most in MOST.items():
        ns = {n: 1e9 * wall.best(n) / sizes[n] for n in calls if n.endswith(what)}
        found.append(
            Row(
                part=PART,
                what=f"{what}, {count} recordings",
                ours=f"{ns[what]:.0f} ns a true sample at best",
                against=f"C, one thread: {ns[f'C, {what}']:.0f} ns; padded side by side, "
                f"{min(count, FEWER)} recordings: {ns[f'padded, {what}']:.0f} ns",
                figure=1e9 * wall.median(what) / samples,
                best=ns[what],
                unit="ns",
                target=most,
                note=f"{len(lines.parts)} parts of {shape[1]} lines of {shape[0]} samples, "
                f"{fill:.1%} of them recordings; gradients by {problem.gradient_by}",
                why=BUSY,
            )
        )
    return found


def _check(problem: Problem) -> None:
    """Lines are the recordings side by side, to rounding."""
    z = problem.space.start() + 0.1
    value, gradient = problem.value_and_gradient(z)
    right, slope = _padded_gradient(problem, z)
    apart = np.abs(np.array([value - right, *(gradient - slope)])).max() / np.abs(slope).max()
    if not apart <= AGREED:
        raise AssertionError(f"recordings in lines differ by {apart:.2g}")


def _padded_value(problem: Problem, z: np.ndarray) -> float:
    values = {name: np.asarray(value) for name, value in problem.parameters(z).items()}
    return float(value_of(problem.static, z, values, False, problem.data))


def _padded_gradient(problem: Problem, z: np.ndarray) -> tuple[float, np.ndarray]:
    value, gradient = value_and_gradient_of(problem.static, "backwards", z, problem.data)
    return float(value), np.asarray(gradient)


def main() -> int:
    """Print the table."""
    found = rows(int(sys.argv[1]) if sys.argv[1:] else RECORDINGS)
    show(found, Console(width=None if sys.stdout.isatty() else 200))
    print(markdown(found))
    return 0


if __name__ == "__main__":
    sys.exit(main())
