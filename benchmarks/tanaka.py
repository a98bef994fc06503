"""Tanaka's regression on windows of ten samples: many that share t, and one after another."""

from collections.abc import Callable

import numpy as np

from benchmarks.table import Row, duration
from benchmarks.timing import interleave
from tuner import tanaka, tanaka_program, tanaka_simplex, tanaka_windows
from tuner.convex import solve

PART = "Tanaka's regression, windows of 10 samples"
WINDOWS, ONE_BY_ONE, SLOW = 10_000, 200, 10
AGREED = 1e-10
WHY = "the target is in microseconds of an otherwise idle machine"


def rows() -> list[Row]:
    """Ours, all exact, beside HiGHS and cvxpy with Clarabel."""
    t, x = np.arange(10.0), np.random.default_rng(0).normal(size=(WINDOWS, 10))
    program = tanaka_program(t)
    many = tanaka_windows(t, x)
    apart = max(
        float(np.abs(tanaka(t, x[i]).center - many.center[i]).max()) for i in range(ONE_BY_ONE)
    )
    if not apart <= AGREED:
        raise AssertionError(f"windows solved together differ from single ones by {apart:.1g}")
    calls: dict[str, Callable[[], object]] = {
        "many windows that share t": lambda: tanaka_windows(t, x),
        "one window after another": lambda: [tanaka(t, one) for one in x[:ONE_BY_ONE]],
        "HiGHS": lambda: [tanaka_simplex(t, one) for one in x[:SLOW]],
        "cvxpy": lambda: [solve(program, {"x": one}) for one in x[:SLOW]],
    }
    times = interleave(calls, 7)
    each = dict(zip(calls, (WINDOWS, ONE_BY_ONE, SLOW, SLOW), strict=True))
    others = ", ".join(
        f"{name}: {duration(times.median(name) / each[name])}" for name in ("HiGHS", "cvxpy")
    )
    targets = {"many windows that share t": 5.0, "one window after another": 100.0}
    return [
        Row(
            part=PART,
            what=name,
            ours=f"{duration(times.median(name) / each[name])} a window",
            against=others,
            figure=1e6 * times.median(name) / each[name],
            best=1e6 * times.best(name) / each[name],
            unit="us",
            target=target,
            note=f"centers of both ways differ by {apart:.1g} at most",
            why=WHY,
        )
        for name, target in targets.items()
    ]
