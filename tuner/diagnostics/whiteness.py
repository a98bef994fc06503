"""Test of whiteness: the correlation at lag one, and Ljung and Box's over several lags."""

import numpy as np

from tuner.diagnostics.column import FEW, Column
from tuner.diagnostics.finding import LEVEL, Finding, judged, not_tried

NAME, WHAT = "whiteness", "Ljung and Box's Q over the correlations of neighbours"
SHORT, LONG = 5, 10
"""Lags: a tuned filter's coloured residual shows in the first five; ten find a slow one."""


def of_whiteness(columns: tuple[Column, ...], lag: float, fitted: int, way: str) -> Finding:
    """Test the correlation of neighbours over five and ten lags, and the mean.

    Args:
        columns: the measurements.
        lag: their correlation at lag one, for the sentence.
        fitted: how many parameters were tuned on these innovations, each of which takes a degree
            of freedom.
        way: the way out, in words.

    Source: Ljung and Box, Biometrika 65, 1978. The mean is known to be 0, so none is subtracted.
    """
    from tuner.distributions import chi_square_above, normal_above

    columns = tuple(c for c in columns if len(c) >= FEW and c.e.any())
    if not columns:
        return not_tried(NAME, WHAT, f"a measurement needs {FEW} innovations")
    lags = min(LONG, min(map(len, columns)) // 4)
    squares = np.array([[_square(c, each) for each in range(1, lags + 1)] for c in columns])
    short = squares[:, :SHORT]
    Q = float(squares.sum())
    chances = {
        "p_short": float(chi_square_above(short.sum(), _degrees(short.size, fitted))),
        "p_ljung_box": float(chi_square_above(Q, _degrees(squares.size, fitted))),
    }
    means = [float(c.e.mean() / np.sqrt(np.mean(c.e**2) / len(c))) for c in columns]
    at = int(np.argmax(np.abs(means)))
    chances["p_mean"] = min(2 * len(columns) * float(normal_above(abs(means[at]))), 1.0)
    p = min(2 * chances["p_short"], 4 * chances["p_ljung_box"], 4 * chances["p_mean"])
    words = (
        f"innovations are correlated (lag one {lag:+.2f}, {_largest(columns, squares)}, "
        f"Ljung-Box {Q:.3g} over {lags} lags)"
    )
    if 4 * chances["p_mean"] < LEVEL:
        offset = columns[at].e.mean()
        name = f" of {columns[at].name}" if columns[at].name else ""
        words += f", and their mean{name} is {offset:+.2g} deviations: an offset"
    details = {"lag_one": lag, "lags": float(lags), **chances}
    return judged(NAME, WHAT, Q, p, f"{words}; {way}", details)


def _degrees(count: int, fitted: int) -> int:
    """Degrees of freedom; tuning takes at most half of them."""
    return count - min(fitted, count // 2)


def _largest(columns: tuple[Column, ...], squares: np.ndarray) -> str:
    row, at = np.unravel_index(np.argmax(squares), squares.shape)
    column, lag = columns[int(row)], int(at) + 1
    return f"at most {column.correlation(lag):+.2f} at lag {lag}"


def _square(column: Column, lag: int) -> float:
    """The square of a correlation over its variance: chi-square with one degree of freedom."""
    count, pairs = len(column), column.pairs(lag)
    return column.correlation(lag) ** 2 * count * (count + 2) / pairs if pairs else 0.0


def lag_one(normalised: np.ndarray) -> float:
    """Correlation of each number with the previous one of the same measurement, over all.

    >>> round(lag_one(np.array([[1.0], [-1.0], [1.0], [-1.0], [np.nan], [1.0]])), 6)
    -1.0
    """
    columns = normalised.reshape(len(normalised), int(np.prod(normalised.shape[1:]))).T
    pairs = [column[np.isfinite(column)] for column in columns]
    products = sum(float(c[1:] @ c[:-1]) for c in pairs)
    squares = sum(float(c[1:] @ c[1:]) + float(c[:-1] @ c[:-1]) for c in pairs) / 2
    return products / squares if squares else float("nan")
