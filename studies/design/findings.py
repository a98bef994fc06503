"""The gains to be programmed, named as trackers have them where they are one."""

from collections.abc import Iterator

import numpy as np

from studies.design.designed import Designed
from studies.design.problems import Posed
from tuner.observers import settling_time
from tuner.run.finding import Finding
from tuner.run.study import Solutions, best

_SHOWN = 3  # of a larger model the exports have the noise


def findings(posed: Posed, solutions: Solutions) -> Iterator[Finding]:
    """The noise a sample, L, in discrete time K and its tracker names, and the deviation."""
    designed = posed.designed
    observer = posed.problem.params(best(posed.problem.name, solutions))
    full = designed.full
    if full.discrete and len(full.A) <= _SHOWN:
        yield from _entries("Q", np.triu(full.W), "what enters in a sample: G Q G'", upper=True)
    yield from _entries("L", designed.gain(observer), "gain of x' = A x + L (y - C x)")
    K = designed.sample_gain(observer)
    if K is not None:
        yield from _entries("K", K, "gain on a sample: x+ = x + K (y - C x), L = A K")
        yield from _tracker(designed, K)
    L = designed.gain(observer)
    after = settling_time(full, L, designed.error)
    yield Finding("settles_s", after, "s", "an error of the state that counts to 2 %, for good")
    variance = designed.error @ designed.covariance(observer) @ designed.error
    when = ", before a measurement" if full.discrete else ""
    meaning = f"of the error that counts{when}"
    yield Finding("deviation", float(np.sqrt(max(variance, 0.0))), designed.unit, meaning)


def _entries(
    symbol: str, matrix: np.ndarray, meaning: str, *, upper: bool = False
) -> Iterator[Finding]:
    single = matrix.shape[1] == 1
    for (i, j), value in np.ndenumerate(matrix):
        if not (upper and j < i):
            index = f"{i + 1}" if single and not upper else f"{i + 1}{j + 1}"
            yield Finding(f"{symbol}{index}", float(value), "", meaning)


def _tracker(designed: Designed, K: np.ndarray) -> Iterator[Finding]:
    """Alpha, beta and gamma where the model is a tracker's."""
    found = designed.tracker(K)
    what = "constant velocity" if len(found) == 2 else "constant acceleration"
    for name, value in found.items():
        yield Finding(name, value, "", f"of the {'-'.join(found)} filter: {what}")
