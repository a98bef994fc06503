"""Whether innovations are independent: lag one, and Ljung and Box over several lags."""

import numpy as np

from tuner.diagnostics.finding import Finding, judged, not_tried
from tuner.diagnostics.innovations import Column, Innovations

NAME, WHAT = "whiteness", "Ljung and Box's Q over the correlations of neighbours"
LAGS = 10
FEW = 20
"""Of fewer numbers nothing is said."""


def of_whiteness(innovations: Innovations, way: str) -> Finding:
    """Test the correlation of neighbours, of all lags together, and the mean.

    Args:
        innovations: they.
        way: the way out, in words.

    Source: Ljung and Box, Biometrika 65, 1978. The mean is known to be 0, so none is taken off.
    """
    from scipy.stats import chi2, norm

    columns = tuple(c for c in innovations.columns if len(c) >= FEW and c.e.any())
    if not columns:
        return not_tried(NAME, WHAT, f"it takes {FEW} innovations of a measurement")
    lags = min(LAGS, min(map(len, columns)) // 5)
    squares = np.array([[_square(c, lag) for lag in range(1, lags + 1)] for c in columns])
    Q = float(squares.sum())
    first = lag_one(innovations.normalised)
    pairs = sum(column.pairs(1) for column in columns)
    means = [float(c.e.mean() / np.sqrt(np.mean(c.e**2)) * np.sqrt(len(c))) for c in columns]
    chances = {
        "all": float(chi2.sf(Q, squares.size)),
        "one": 2 * float(norm.sf(abs(first) * np.sqrt(pairs))),
        "mean": 2 * len(columns) * float(norm.sf(max(map(abs, means)))),
    }
    worst = min(chances, key=lambda name: chances[name])
    at = int(np.argmax(np.abs(means)))
    words = f"innovations are correlated (lag one {first:+.2f}, Ljung-Box {Q:.3g} over {lags} lags)"
    if chances["mean"] < LEVEL_OF_EACH:
        offset = columns[at].e.mean()
        name = f" of {columns[at].name}" if columns[at].name else ""
        words += f", and their mean{name} is {offset:+.2g} deviations: an offset"
    details = {"lag_one": first, "p_lag_one": chances["one"], "lags": float(lags)}
    details |= {"p_ljung_box": chances["all"], "p_mean": min(chances["mean"], 1.0)}
    return judged(NAME, WHAT, Q, 3 * chances[worst], f"{words}; {way}", details)


LEVEL_OF_EACH = 0.01 / 3
"""Of three looks at the same numbers."""


def _square(column: Column, lag: int) -> float:
    """Square of a correlation over its variance, of chi-square with one degree."""
    count, pairs = len(column), column.pairs(lag)
    return column.correlation(lag) ** 2 * count * (count + 2) / pairs if pairs else 0.0


def lag_one(normalised: np.ndarray) -> float:
    """Correlation of each number with the one before of the same measurement, over all.

    >>> round(lag_one(np.array([[1.0], [-1.0], [1.0], [-1.0], [np.nan], [1.0]])), 6)
    -1.0
    """
    columns = normalised.reshape(len(normalised), int(np.prod(normalised.shape[1:]))).T
    pairs = [column[np.isfinite(column)] for column in columns]
    products = sum(float(c[1:] @ c[:-1]) for c in pairs)
    squares = sum(float(c[1:] @ c[1:]) + float(c[:-1] @ c[:-1]) for c in pairs) / 2
    return products / squares if squares else float("nan")
