"""Times that survive a busy machine: calls take turns, and each is held against its neighbour."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import jax
import numpy as np

Call = Callable[[], object]


@dataclass(frozen=True, eq=False)
class Times:
    """The time of each call in each round, s.

    Attributes:
        seconds: by name, ``(rounds,)`` each; entries of one index were measured one after another.
    """

    seconds: Mapping[str, np.ndarray]

    def median(self, name: str) -> float:
        """The median time, s."""
        return float(np.median(self.seconds[name]))

    def best(self, name: str) -> float:
        """The shortest time, s."""
        return float(self.seconds[name].min())

    def ratio(self, name: str, *limits: str) -> "Ratio":
        """The time over the sum of the limits."""
        ours = self.seconds[name]
        limit = np.sum([self.seconds[one] for one in limits], axis=0)
        best = sum(self.best(one) for one in limits)
        return Ratio(float(np.median(ours / limit)), float(ours.min() / best))

    def noise(self, name: str) -> float:
        """The interquartile range over the median: the precision of one number."""
        low, high = np.quantile(self.seconds[name], [0.25, 0.75])
        return float((high - low) / self.median(name))


@dataclass(frozen=True)
class Ratio:
    """A ratio of times.

    Attributes:
        median: over the rounds, each call against its neighbours.
        best: of the shortest times: what a quiet machine would show.
    """

    median: float
    best: float


def interleave(
    calls: Mapping[str, Call],
    rounds: int,
    repeats: Mapping[str, int] | None = None,
    *,
    clock: Callable[[], float] = time.perf_counter,
) -> Times:
    """Time calls in turns: A B C A B C, after one round that compiles and warms up.

    Args:
        calls: by name.
        rounds: how often each takes its turn.
        repeats: number of calls in a turn, whose mean counts; 1 by default. A call of
            milliseconds after one of seconds needs a few, because that leaves cold caches.
        clock: `time.process_time` where only processor time counts, under any other load.
    """
    seconds: dict[str, list[float]] = {name: [] for name in calls}
    for call in calls.values():
        jax.block_until_ready(call())
    for _ in range(rounds):
        for name, call in calls.items():
            times = (repeats or {}).get(name, 1)
            start = clock()
            for _ in range(times):
                jax.block_until_ready(call())
            seconds[name].append((clock() - start) / times)
    return Times({name: np.array(taken) for name, taken in seconds.items()})
