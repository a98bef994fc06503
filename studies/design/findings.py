"""What is programmed of a design: both gains, named as trackers have them where they are one."""

from collections.abc import Iterator
from math import factorial

import numpy as np

from studies.design.designed import Designed
from studies.design.problems import Posed
from tuner.observers import settling_time
from tuner.run.finding import Finding
from tuner.run.study import Solutions, best

_GREEK = ("alpha", "beta", "gamma")
_SAME = 1e-9
_SHOWN = 3  # of a larger model the exports have the noise


def findings(posed: Posed, solutions: Solutions) -> Iterator[Finding]:
    """The noise a sample, L, and in discrete time K, its names for trackers, and what is left."""
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
    """Alpha, beta and gamma where the model is a position with one or two derivatives.

    K is (alpha, beta / T, gamma / (2 T^2)): Bar-Shalom, Li and Kirubarajan 2001, 6.5.
    """
    full, T = designed.full, designed.full.dt
    n = len(full.A)
    if T is None or n not in (2, 3) or K.shape[1] != 1:
        return
    chain = np.array(
        [[T ** (j - i) / factorial(j - i) if j >= i else 0.0 for j in range(n)] for i in range(n)]
    )
    first = np.eye(n)[:1]
    if not (np.allclose(full.A, chain, rtol=_SAME, atol=0) and np.array_equal(full.C, first)):
        return
    what = "constant velocity" if n == 2 else "constant acceleration"
    for i, name in enumerate(_GREEK[:n]):
        value = float(K[i, 0]) * T**i * factorial(i)
        yield Finding(name, value, "", f"of the {'-'.join(_GREEK[:n])} filter: {what}")
