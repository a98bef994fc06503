"""Tanaka's regression on windows of ten samples: many side by side, and single ones."""

from collections.abc import Callable

import numpy as np

from benchmarks.table import Row, duration
from benchmarks.timing import interleave
from tuner.convex import solve
from tuner.regression import tanaka, tanaka_program, tanaka_simplex, tanaka_windows
from tuner.regression.interior import interior_point
from tuner.regression.window import window

PART = "Tanaka's regression, windows of 10 samples"
WINDOWS, ONE_BY_ONE, SAME, SLOW = 10_000, 200, 2000, 10
AGREED = 1e-10
SHARED, OWN = "10 000 windows that share t", "10 000 windows, each with its own t"
ONE, NEW = "one call of 2000 with one t", "one call, a new t each"
WHY = {
    ONE: "the target is of a machine on which HiGHS takes 0.92 ms and Clarabel alone 0.06 ms",
    NEW: "as above; a new t is scaled and its corners are found anew. Many such windows together "
    "are in the second row",
}
TARGETS = {SHARED: 5.0, OWN: 100.0, ONE: 100.0, NEW: 100.0}


def rows() -> list[Row]:
    """Ours, all exact, compared with Clarabel alone, HiGHS and cvxpy with Clarabel."""
    rng = np.random.default_rng(0)
    t, x = np.arange(10.0), rng.normal(size=(WINDOWS, 10))
    own = np.sort(rng.uniform(0, 9, (WINDOWS, 10, 1)), axis=1)
    program, asked = tanaka_program(t), [window(t, one, 0.0, None) for one in x[:ONE_BY_ONE]]
    apart = max(_apart(t, x), _apart(own, x))
    if not apart <= AGREED:
        raise AssertionError(f"windows solved together differ from single ones by {apart:.1g}")
    calls: dict[str, tuple[int, Callable[[], object]]] = {
        SHARED: (WINDOWS, lambda: tanaka_windows(t, x)),
        OWN: (WINDOWS, lambda: tanaka_windows(own, x)),
        ONE: (SAME, lambda: [tanaka(t, one) for one in x[:SAME]]),
        NEW: (ONE_BY_ONE, lambda: [tanaka(own[i], x[i]) for i in range(ONE_BY_ONE)]),
        "Clarabel alone": (ONE_BY_ONE, lambda: [interior_point(one, 1e-8) for one in asked]),
        "HiGHS": (SLOW, lambda: [tanaka_simplex(t, one) for one in x[:SLOW]]),
        "cvxpy": (SLOW, lambda: [solve(program, {"x": one}) for one in x[:SLOW]]),
    }
    times = interleave({name: call for name, (_, call) in calls.items()}, 7)
    each = {name: times.median(name) / count for name, (count, _) in calls.items()}
    others = ", ".join(f"{name}: {duration(each[name])}" for name in calls if name not in TARGETS)
    return [
        Row(
            part=PART,
            what=name,
            ours=f"{duration(each[name])} a window",
            against=others,
            figure=1e6 * each[name],
            best=1e6 * times.best(name) / calls[name][0],
            unit="us",
            target=target,
            note=f"centers of many and of single windows differ by {apart:.1g} at most",
            why=WHY.get(name, ""),
        )
        for name, target in TARGETS.items()
    ]


def _apart(t: np.ndarray, x: np.ndarray) -> float:
    found = tanaka_windows(t, x).center[:ONE_BY_ONE]
    single = [tanaka(t[i] if t.ndim == 3 else t, x[i]).center for i in range(ONE_BY_ONE)]
    return float(np.abs(found - single).max())
