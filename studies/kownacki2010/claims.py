"""What the paper says of both sensors, and what it comes to: one function a claim."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from studies.kownacki2010 import problems
from studies.kownacki2010.data import Bench
from studies.kownacki2010.paper import ACC
from tuner.run.comparison import Comparison, Verdict, claim, number
from tuner.run.study import Claim, Solutions, best
from tuner.solvers import fminsearch

TOLERANCE = 0.05
NEARLY = 1.01
"""A search has found the optimum if it ends at a cost of at most this much of the lowest."""
WHY_ACC = (
    "white noise of Table 1's variance stands in for the paper's record, whose accelerometer held "
    "harmonics from 50 to 500 Hz, and the reading of (10)'s second term is inferred"
)
WHY_LITERAL = (
    "to the letter the step itself makes up the second term, so that it hardly counts: the optimum "
    "is almost no filter"
)


def _ratio(bench: Bench, solutions: Solutions) -> Iterator[Comparison]:
    """Q/R, and the gain and bandwidth that follow from it."""
    name = bench.sensor.name
    published = bench.sensor.table2.Q / bench.sensor.table2.R
    ratio = best(name, solutions).derived["q_over_r"]
    (k1, _, bandwidth), (our_k1, _, our_bandwidth) = bench.steady(published), bench.steady(ratio)
    row = partial(number, tolerance=TOLERANCE, note=WHY_ACC if bench.sensor is ACC else "")
    yield row(f"{name}.q_over_r", "Table 2", published, ratio, unit="1/s^2")
    yield row(f"{name}.k1", "Table 2, steady gain", k1, our_k1)
    yield row(f"{name}.bandwidth_hz", "Table 2, -3 dB", bandwidth, our_bandwidth, unit="Hz")


def _one_by_one(bench: Bench, solutions: Solutions) -> Iterator[Comparison]:
    """R and Q by themselves, by the certificate of the two-parameter problem (as printed)."""
    both = best(f"{bench.sensor.name}.paper", solutions)
    for letter, published in bench.sensor.table2._asdict().items():
        tuned = both.parameters[letter]
        row = number(
            f"{bench.sensor.name}.{letter}",
            "Table 2",
            published,
            float(tuned.value),
            tolerance=TOLERANCE,
            unit=tuned.unit,
        )
        if tuned.interval is None:
            words = "; ".join(both.certificate.flat_directions) or both.message
            row = replace(row, verdict=Verdict.NOT_IDENTIFIABLE, tolerance=None, note=words)
        yield row


def _cost_at_paper(bench: Bench, solutions: Solutions) -> Comparison:
    """What the cost says of Table 2, in the chosen reading."""
    name, optimum = bench.sensor.name, best(bench.sensor.name, solutions)
    published = bench.sensor.table2.Q / bench.sensor.table2.R
    at_paper = problems.problem(bench).value(np.log([published * bench.R]))
    return number(
        f"{name}.cost_at_paper_over_optimum",
        "Table 2 is called optimal",
        1.0,
        at_paper / optimum.value,
        tolerance=0.01,
        note="cost (10) at Table 2's Q/R over its minimum on this record",
    )


def _literal(bench: Bench, solutions: Solutions) -> Comparison:
    """What the cost says to the letter."""
    name = bench.sensor.name
    return number(
        f"{name}.q_over_r_literal",
        "Table 2; (10) to the letter (R1)",
        bench.sensor.table2.Q / bench.sensor.table2.R,
        best(f"{name}.literal", solutions).derived["q_over_r"],
        tolerance=TOLERANCE,
        unit="1/s^2",
        note=WHY_LITERAL,
    )


def _R_stronger(bench: Bench, solutions: Solutions) -> Comparison:
    """Whether R counts beside Q: the relative change when both grow a thousandfold together."""
    ratio = best(bench.sensor.name, solutions).derived["q_over_r"]
    posed, z = problems.paper(bench), np.log([1e-6, 1e-6 * ratio])
    change = posed.value(z + np.log(1e3)) / posed.value(z) - 1
    return claim(
        f"{bench.sensor.name}.R_stronger_than_Q",
        "section 4: R has stronger influence",
        abs(change) > TOLERANCE,
        ours=change,
        note="a thousandfold R with a thousandfold Q changes the cost by this share",
    )


def _table1(bench: Bench, solutions: Solutions) -> Iterator[Comparison]:
    """R and Q of the record by Table 1's procedure."""
    name, table, noise = bench.sensor.name, bench.sensor.table1, bench.noise
    white = table.R * 2 * bench.settings.cutoff_hz * bench.dt
    why = f"white noise of Table 1's R has {white:.3g} below the cutoff: the paper's was not white"
    row = partial(number, tolerance=TOLERANCE, unit=f"({bench.unit})^2")
    yield row(f"{name}.table1_R", "Table 1", table.R, noise.R)
    yield row(f"{name}.table1_Q", "Table 1", table.Q, noise.Q, note=why)


def _fminsearch(bench: Bench, solutions: Solutions) -> Comparison:
    """What fminsearch does from the record's R and Q."""
    posed = problems.paper(bench)
    found = fminsearch(
        lambda v: posed.value(np.log(v)) if (v > 0).all() else np.inf, np.array(bench.noise)
    )
    stuck = found.evaluations == 3
    return claim(
        f"{bench.sensor.name}.nelder_mead_linear_evaluations",
        "section 4: fminsearch results in the optimal values",
        found.value <= NEARLY * best(bench.sensor.name, solutions).value,
        ours=float(found.evaluations),
        note=f"from the record's R and Q with default options it ends at Q/R = "
        f"{found.z[1] / found.z[0]:.4g}"
        + (", where it began: its tolerance of 1e-4 exceeds R and Q" if stuck else ""),
    )


def _fminsearch_in_logarithms(bench: Bench, solutions: Solutions) -> Comparison:
    """The same search in decimal logarithms of R and Q."""
    posed = problems.paper(bench)
    low, high = (np.log(end) for end in (1e-300, 1e300))
    found = fminsearch(
        lambda v: posed.value(np.clip(v * np.log(10), low, high)), np.log10(np.array(bench.noise))
    )
    reached = found.value <= NEARLY * best(bench.sensor.name, solutions).value
    return claim(
        f"{bench.sensor.name}.nelder_mead_log10_evaluations",
        "the same search in log10 R, log10 Q",
        found.finished and reached,
        ours=float(found.evaluations),
        note=f"it ends at Q/R = {10 ** (found.z[1] - found.z[0]):.6g}, R = {10 ** found.z[0]:.3g}",
    )


OfSensor = Callable[[Bench, Solutions], Comparison | Iterable[Comparison]]


def _of_each(rows: OfSensor) -> Callable[[list[Bench], Solutions], Iterator[Comparison]]:
    """The rows of both sensors."""

    def of_each(benches: list[Bench], solutions: Solutions) -> Iterator[Comparison]:
        for bench in benches:
            found = rows(bench, solutions)
            yield from [found] if isinstance(found, Comparison) else found

    return of_each


SENSORS = ("gyro", "acc")
CLAIMS = (
    Claim("*.q_over_r", _of_each(_ratio), SENSORS),
    Claim("*.[RQ]", _of_each(_one_by_one), ("*.paper",)),
    Claim("*.cost_at_paper_over_optimum", _of_each(_cost_at_paper), SENSORS),
    Claim("*.q_over_r_literal", _of_each(_literal), ("*.literal",)),
    Claim("*.R_stronger_than_Q", _of_each(_R_stronger), SENSORS),
    Claim("*.table1_[RQ]", _of_each(_table1)),
    Claim("*.nelder_mead_linear_evaluations", _of_each(_fminsearch), SENSORS),
    Claim("*.nelder_mead_log10_evaluations", _of_each(_fminsearch_in_logarithms), SENSORS),
)
