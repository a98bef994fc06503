"""The comparison with the paper, row by row."""

from dataclasses import replace
from functools import partial

import numpy as np

from studies.kownacki2010.bench import ACC, Bench
from tuner.run.comparison import Comparison, Verdict, claim, number
from tuner.run.study import Solutions, best
from tuner.solvers import fminsearch

TOLERANCE = 0.05
NEARLY = 1.01
"""A search has found the optimum if it ends at a cost of at most this much of the lowest."""
OTHER = "another sensor at another rate: for orientation only"
WHY_ACC = (
    "white noise of Table 1's variance stands in for the paper's record, whose accelerometer held "
    "harmonics from 50 to 500 Hz, and the reading of (10)'s second term is inferred"
)
WHY_LITERAL = (
    "to the letter the step itself makes up the second term, so that it hardly counts: the optimum "
    "is almost no filter"
)


def compare(benches: list[Bench], made_up: bool, solutions: Solutions) -> list[Comparison]:
    """The rows for every sensor."""
    return [row for bench in benches for row in _rows(bench, made_up, solutions)]


def _rows(bench: Bench, made_up: bool, solutions: Solutions) -> list[Comparison]:
    return [
        *_ratio(bench, made_up, solutions),
        *_individual(bench, solutions),
        *_cost(bench, solutions),
        *_table1(bench, made_up),
        *_searches(bench, best(bench.sensor.name, solutions).value),
    ]


def _ratio(bench: Bench, made_up: bool, solutions: Solutions) -> list[Comparison]:
    """Q/R, and the gain and bandwidth that follow from it."""
    name = bench.sensor.name
    published = bench.sensor.table2.Q / bench.sensor.table2.R
    ratio = best(name, solutions).derived["q_over_r"]
    (k1, _, bandwidth), (our_k1, _, our_bandwidth) = bench.steady(published), bench.steady(ratio)
    note = (WHY_ACC if bench.sensor is ACC else "") if made_up else OTHER
    row = partial(number, tolerance=TOLERANCE, note=note)
    return [
        row(f"{name}.q_over_r", "Table 2", published, ratio, unit="1/s^2"),
        row(f"{name}.k1", "Table 2, steady gain", k1, our_k1),
        row(f"{name}.bandwidth_hz", "Table 2, -3 dB", bandwidth, our_bandwidth, unit="Hz"),
    ]


def _cost(bench: Bench, solutions: Solutions) -> list[Comparison]:
    """What the cost says of Table 2, in the chosen reading and to the letter, and of R alone."""
    name, optimum = bench.sensor.name, best(bench.sensor.name, solutions)
    published = bench.sensor.table2.Q / bench.sensor.table2.R
    at_paper = bench.problem().value(np.log([published * bench.R]))
    literal = best(f"{name}.literal", solutions).derived["q_over_r"]
    change = _change_when_scaled(bench, optimum.derived["q_over_r"])
    return [
        number(
            f"{name}.cost_at_paper_over_optimum",
            "Table 2 is called optimal",
            1.0,
            at_paper / optimum.value,
            tolerance=0.01,
            note="cost (10) at Table 2's Q/R over its minimum on this record",
        ),
        number(
            f"{name}.q_over_r_literal",
            "Table 2; (10) to the letter (R1)",
            published,
            literal,
            tolerance=TOLERANCE,
            unit="1/s^2",
            note=WHY_LITERAL,
        ),
        claim(
            f"{name}.R_stronger_than_Q",
            "section 4: R has stronger influence",
            abs(change) > TOLERANCE,
            ours=change,
            note="a thousandfold R with a thousandfold Q changes the cost by this share",
        ),
    ]


def _table1(bench: Bench, made_up: bool) -> list[Comparison]:
    """R and Q of the record by Table 1's procedure."""
    name, table, noise = bench.sensor.name, bench.sensor.table1, bench.noise
    white = table.R * 2 * bench.settings.cutoff_hz * bench.dt
    why = f"white noise of Table 1's R has {white:.3g} below the cutoff: the paper's was not white"
    row = partial(number, tolerance=TOLERANCE, unit=f"({bench.unit})^2")
    return [
        row(f"{name}.table1_R", "Table 1", table.R, noise.R, note="" if made_up else OTHER),
        row(f"{name}.table1_Q", "Table 1", table.Q, noise.Q, note=why if made_up else OTHER),
    ]


def _individual(bench: Bench, solutions: Solutions) -> list[Comparison]:
    """R and Q one by one, judged by the certificate of the two-parameter problem (as printed)."""
    both = best(f"{bench.sensor.name}.paper", solutions)
    rows = []
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
        rows.append(row)
    return rows


def _searches(bench: Bench, optimum: float) -> list[Comparison]:
    """What fminsearch does from the record's R and Q, in these and in their decimal logarithms."""
    problem, start = bench.paper(), np.array(bench.noise)
    low, high = (np.log(end) for end in (1e-300, 1e300))
    linear = fminsearch(lambda v: problem.value(np.log(v)) if (v > 0).all() else np.inf, start)
    ratio = linear.z[1] / linear.z[0]
    decimal = fminsearch(
        lambda v: problem.value(np.clip(v * np.log(10), low, high)), np.log10(start)
    )
    stuck = linear.evaluations == 3
    name = f"{bench.sensor.name}.nelder_mead"
    return [
        claim(
            f"{name}_linear_evaluations",
            "section 4: fminsearch results in the optimal values",
            linear.value <= NEARLY * optimum,
            ours=float(linear.evaluations),
            note=f"from the record's R and Q with default options it ends at Q/R = {ratio:.4g}"
            + (", where it began: its tolerance of 1e-4 exceeds R and Q" if stuck else ""),
        ),
        claim(
            f"{name}_log10_evaluations",
            "the same search in log10 R, log10 Q",
            decimal.finished and decimal.value <= NEARLY * optimum,
            ours=float(decimal.evaluations),
            note=f"it ends at Q/R = {10 ** (decimal.z[1] - decimal.z[0]):.6g}, "
            f"R = {10 ** decimal.z[0]:.3g}",
        ),
    ]


def _change_when_scaled(bench: Bench, ratio: float) -> float:
    """Relative change of the cost when R and Q grow a thousandfold together."""
    problem = bench.paper()
    z = np.log([1e-6, 1e-6 * ratio])
    return problem.value(z + np.log(1e3)) / problem.value(z) - 1
