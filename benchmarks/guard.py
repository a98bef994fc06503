"""The performance guard for CI: ``python -m benchmarks.guard``.

The worst slowdown is silent: without one option XLA interprets a time loop operation by operation,
10 to 100 times slower, and nothing fails. Here the same code runs in two processes, with the option
and without. Only ratios are judged, with wide margins, so a busy machine does not matter. Of larger
filters, whose loops are the first to be lost, the compiled text is read, and their likelihoods are
held against C by their shortest times; so are those of compiled C that computes entries of a row at
once. A likelihood with constant gains is held against the same with every step.
"""

import sys
from collections.abc import Mapping

from benchmarks.baseline import NoCompilerError
from benchmarks.gradients import c_over_c, over_c
from benchmarks.long_records import settled
from benchmarks.processes import measure
from benchmarks.whole_loops import large
from tuner.compiler import NoCodeError

SAMPLES = 20_000
LEAST_EFFECT = 3.0  # 10 to 70 is usual
MOST_GRADIENT = 12.0  # times the forward pass; 2 to 4 is usual
LEAST_SPEED = 3.0  # times a plain Python loop; 10 to 40 is usual
MOST_OVER_C = {(4, 2): (3.5, 4.0), (9, 3): (2.7, 2.9), (15, 3): (1.7, 2.0)}
"""States and measurements, and what a likelihood and its gradient may take over C; two thirds and
less are usual."""
BY_ROWS = (9, 3)
MOST_BY_ROWS = (2.0, 1.9)
"""The same of C by rows, in place of XLA; 1.3 is usual."""
LEAST_SETTLED = 2.0  # times as fast with constant gains; 4 is usual
GRADIENTS = {"cost + gradient": "gyroscope filter", "generic gradient": "generic LinearKalman"}


def verdict(on: Mapping[str, float], off: Mapping[str, float]) -> list[str]:
    """The faults, one sentence each.

    Args:
        on: seconds by name, measured with the loop option.
        off: the same without it.
    """
    wrong = []
    for name, forward in GRADIENTS.items():
        cost = on[name] / on[forward]
        if cost > MOST_GRADIENT:
            wrong.append(
                f"{name} takes {cost:.0f} times as long as one pass of the {forward} (2 to 4 is "
                "usual): its time loop is not compiled as a whole"
            )
        speed = on["Python loop"] / on[forward]
        if speed < LEAST_SPEED:
            wrong.append(
                f"the {forward} is only {speed:.1f} times as fast as a plain Python loop (10 to 40 "
                "is usual): its time loop is not compiled as a whole"
            )
    effect = max(off[name] / on[name] for name in GRADIENTS)
    if effect < LEAST_EFFECT:
        wrong.append(_no_effect(effect, slow=bool(wrong)))
    return wrong


def slow_products(found: Mapping[tuple[int, int], tuple[float, float]]) -> list[str]:
    """The faults of larger filters, one sentence each, by what they take over C."""
    return [
        f"the {what} of a linear filter of {size[0]} states takes {ratio:.1f} times as long as C, "
        f"not {most:.1f}: the products in its time loop are not vectorised"
        for size, ratios in found.items()
        for what, ratio, most in zip(("value", "gradient"), ratios, MOST_OVER_C[size], strict=True)
        if ratio > most
    ]


def slow_rows(ratios: tuple[float, float]) -> list[str]:
    """The faults of C by rows, one sentence each, by what value and gradient take over C."""
    return [
        f"the {what} of a linear filter of {BY_ROWS[0]} states by compiled C takes {ratio:.1f} "
        f"times as long as C by hand, not {most:.1f}: its loops over rows are not vectorised, or "
        "not chosen"
        for what, ratio, most in zip(("value", "gradient"), ratios, MOST_BY_ROWS, strict=True)
        if ratio > most
    ]


def slow_settling(gain: float) -> list[str]:
    """The fault of constant gains, in a sentence, where they make a likelihood hardly faster."""
    if gain >= LEAST_SETTLED:
        return []
    return [
        f"a likelihood is only {gain:.1f} times as fast with constant gains (4 is usual): they do "
        "not settle any more, or blocks of samples are not vectorised"
    ]


def main() -> int:
    """Measure, print the result, and return the exit code."""
    on = measure("gradient", samples=SAMPLES)
    off = measure("gradient", whole=False, samples=SAMPLES)
    for name in on:
        print(f"{name:22} {1e3 * on[name]:8.2f} ms, without the option {1e3 * off[name]:8.2f} ms")
    wrong = verdict(on, off)
    wrong += [f"{name}: its time loop is not compiled as a whole" for name, lost in large() if lost]
    try:
        over = {size: over_c(*size) for size in MOST_OVER_C}
        by_rows = c_over_c(*BY_ROWS)
    except (NoCompilerError, NoCodeError):
        over, by_rows = {}, (0.0, 0.0)
    for (n, _), ratios in over.items():
        print(f"{n:2} states: value {ratios[0]:.2f} x C, gradient {ratios[1]:.2f} x C")
    gain = settled()
    print(f"by rows: value {by_rows[0]:.2f} x C, gradient {by_rows[1]:.2f} x C")
    print(f"constant gains: {gain:.2f} x")
    wrong += [*slow_products(over), *slow_rows(by_rows), *slow_settling(gain)]
    for sentence in wrong:
        print(sentence, file=sys.stderr)
    return int(bool(wrong))


def _no_effect(effect: float, *, slow: bool) -> str:
    reason = (
        "XLA no longer understands it"
        if slow
        else "XLA compiles whole loops without it; filters/backend.py may not need it any more"
    )
    return f"the loop option has no effect ({effect:.1f} times, 10 to 70 is usual): {reason}"


if __name__ == "__main__":
    sys.exit(main())
