"""The stretches of a record that a fit leaves out because they contradict the rest."""

from collections.abc import Iterator
from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from filters import Lanes, assembled, bare
from filters.measurement_mask import MeasurementMask
from objectives import Data
from tuner.identifiability.noise import NoModelError
from tuner.identifiability.stretches import wrong_stretches
from tuner.problem.problem import Problem
from tuner.run.gate import parts_of

SHOWN = 4
"""How many stretches are told one by one."""


@dataclass(frozen=True)
class ExcludedStretches:
    """Stretches that were left out.

    Attributes:
        numbers: how many measured numbers are in them.
        of: how many there are.
        stretches: recording, first and last time of each, s.
        recordings: how many there are.
    """

    numbers: int
    of: int
    stretches: tuple[tuple[int, float, float], ...]
    recordings: int = 1

    @property
    def words(self) -> str:
        """In a sentence's part."""
        if not self.stretches:
            return "no stretch contradicts the rest"
        shown = [
            f"{f'recording {lane + 1} ' * (self.recordings > 1)}{start:.4g} to {end:.4g} s"
            for lane, start, end in self.stretches[:SHOWN]
        ]
        more = len(self.stretches) - len(shown)
        rest = f" and {more} more" if more else ""
        return f"{self.numbers} of {self.of} numbers left out ({', '.join(shown)}{rest})"


def without_stretches(
    problem: Problem, gate: float, times: np.ndarray
) -> tuple[Data, ExcludedStretches]:
    """A problem's data without the stretches that contradict the rest, and which they are.

    Args:
        problem: of a linear model.
        gate: how many times as far out a stretch may be, as of
            :func:`tuner.identifiability.stretches.wrong_stretches`.
        times: of the samples, s, ``(N,)`` or ``(N, k)``.

    Raises:
        ValueError: where half of the numbers or more would be left out, and for a filter that is
            not the Kalman filter of a linear model.
    """
    try:
        found = wrong_stretches(problem, gate)
    except NoModelError as error:
        raise ValueError(f"stretches are judged by a linear model: {error}; try gate=4") from None
    seen, gone = (sum(int(part.sum()) for part in each) for each in zip(*found, strict=True))
    if 2 * gone >= seen:
        raise ValueError(
            f"{gone} of {seen} measured numbers lie in stretches that contradict the rest, so "
            f"too few are left; give more than stretches={gate:g}, or none"
        )
    filter, data = problem.filter, problem.data
    params = assembled(bare(filter), problem.parameters(problem.space.start()))
    without = jax.vmap(MeasurementMask(parts_of(filter, params, data.inputs)).masked)
    wrong = [each.wrong for each in found]
    if isinstance(filter, Lanes):
        inputs = jax.vmap(without)(data.inputs, jnp.asarray(np.stack(wrong, axis=1)))
    else:
        inputs = without(data.inputs, jnp.asarray(wrong[0]))
    clocks = times.reshape(len(times), -1).T
    stretches = tuple(
        (lane, float(clocks[lane][start]), float(clocks[lane][end - 1]))
        for lane, each in enumerate(wrong)
        for start, end in _runs(each, found[lane].seen)
    )
    return Data(inputs, data.truth), ExcludedStretches(gone, seen, stretches, len(found))


def _runs(wrong: np.ndarray, seen: np.ndarray) -> Iterator[tuple[int, int]]:
    """First and last sample, that after it, of what is refused without a measurement between."""
    rows = np.flatnonzero(seen.any(axis=1))
    far = np.asarray(wrong.any(axis=1))[rows]
    for start, end in np.flatnonzero(np.diff(far, prepend=False, append=False)).reshape(-1, 2):
        yield int(rows[start]), int(rows[end - 1]) + 1
