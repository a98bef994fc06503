"""The paper's claims for both sensors, each checked by one function."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TypeAlias

import numpy as np

from studies.kownacki2010 import problems
from studies.kownacki2010.data import Bench
from studies.kownacki2010.paper import ACC, GYRO, Sensor
from tuner.run.comparison import Comparison, Verdict, claim, number
from tuner.run.study import Claim, Solutions, best
from tuner.solvers import fminsearch

TOLERANCE = 0.05
NEARLY = 1.01
"""Ratio to the lowest cost up to which a search has found the optimum."""
WHY_ACC = (
    "white noise of Table 1's variance replaces the paper's record, which held harmonics from 50 "
    "to 500 Hz; the reading of (10)'s second term is inferred"
)
WHY_LITERAL = (
    "as printed, the step itself dominates the second term, so that noise hardly matters: the "
    "optimum hardly filters"
)


def _of_table_2(bench: Bench, solutions: Solutions) -> tuple[float, float]:
    """Q/R on paper, and that of the optimum."""
    table = bench.sensor.table2
    return table.Q / table.R, best(bench.sensor.name, solutions).derived["q_over_r"]


def _why(bench: Bench) -> str:
    return WHY_ACC if bench.sensor is ACC else ""


def _ratio(bench: Bench, solutions: Solutions) -> Comparison:
    """Q/R."""
    return number(
        f"{bench.sensor.name}.q_over_r",
        "Table 2",
        *_of_table_2(bench, solutions),
        tolerance=TOLERANCE,
        unit="1/s^2",
        note=_why(bench),
    )


def _gain(bench: Bench, solutions: Solutions) -> Comparison:
    """The steady gain that follows from it."""
    published, ours = (bench.steady(ratio)[0] for ratio in _of_table_2(bench, solutions))
    name = f"{bench.sensor.name}.k1"
    where = "Table 2, steady gain"
    return number(name, where, published, ours, tolerance=TOLERANCE, note=_why(bench))


def _bandwidth(bench: Bench, solutions: Solutions) -> Comparison:
    """The bandwidth that follows from it."""
    published, ours = (bench.steady(ratio)[2] for ratio in _of_table_2(bench, solutions))
    return number(
        f"{bench.sensor.name}.bandwidth_hz",
        "Table 2, -3 dB",
        published,
        ours,
        tolerance=TOLERANCE,
        unit="Hz",
        note=_why(bench),
    )


def _one_by_one(bench: Bench, solutions: Solutions, *, letter: str) -> Comparison:
    """R or Q by itself, by the certificate of the two-parameter problem (as printed)."""
    both = best(f"{bench.sensor.name}.paper", solutions)
    tuned = both.parameters[letter]
    row = number(
        f"{bench.sensor.name}.{letter}",
        "Table 2",
        getattr(bench.sensor.table2, letter),
        float(tuned.value),
        tolerance=TOLERANCE,
        unit=tuned.unit,
    )
    if tuned.interval is not None:
        return row
    words = "; ".join(both.certificate.flat_directions) or both.message
    return replace(row, verdict=Verdict.NOT_IDENTIFIABLE, tolerance=None, note=words)


def _cost_at_paper(bench: Bench, solutions: Solutions) -> Comparison:
    """The cost at Table 2 over its minimum, in the chosen reading."""
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
    """The optimum of the cost taken to the letter."""
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


def _table1_R(bench: Bench, solutions: Solutions) -> Comparison:
    """R of the record by Table 1's procedure."""
    return _table1(bench, "R", bench.sensor.table1.R, bench.noise.R)


def _table1_Q(bench: Bench, solutions: Solutions) -> Comparison:
    """Q of the record by Table 1's procedure."""
    table = bench.sensor.table1
    white = table.R * 2 * bench.settings.cutoff_hz * bench.dt
    why = f"white noise of Table 1's R has {white:.3g} below the cutoff: the paper's was not white"
    return _table1(bench, "Q", table.Q, bench.noise.Q, why)


def _table1(bench: Bench, letter: str, paper: float, ours: float, note: str = "") -> Comparison:
    name, unit = f"{bench.sensor.name}.table1_{letter}", f"({bench.unit})^2"
    return number(name, "Table 1", paper, ours, tolerance=TOLERANCE, unit=unit, note=note)


def _fminsearch(bench: Bench, solutions: Solutions) -> Comparison:
    """The outcome of fminsearch from the record's R and Q."""
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


OfSensor: TypeAlias = Callable[[Bench, Solutions], Comparison]


def _claims(sensor: Sensor) -> Iterator[Claim]:
    """The claims for one sensor, in the order of the rows."""
    posed, both, literal = ((f"{sensor.name}{of}",) for of in ("", ".paper", ".literal"))
    rows: tuple[tuple[str, OfSensor, tuple[str, ...]], ...] = (
        ("q_over_r", _ratio, posed),
        ("k1", _gain, posed),
        ("bandwidth_hz", _bandwidth, posed),
        ("R", partial(_one_by_one, letter="R"), both),
        ("Q", partial(_one_by_one, letter="Q"), both),
        ("cost_at_paper_over_optimum", _cost_at_paper, posed),
        ("q_over_r_literal", _literal, literal),
        ("R_stronger_than_Q", _R_stronger, posed),
        ("table1_R", _table1_R, ()),
        ("table1_Q", _table1_Q, ()),
        ("nelder_mead_linear_evaluations", _fminsearch, posed),
        ("nelder_mead_log10_evaluations", _fminsearch_in_logarithms, posed),
    )
    for name, of_sensor, needs in rows:
        yield Claim(f"{sensor.name}.{name}", partial(_of, sensor, of_sensor), needs)


def _of(sensor: Sensor, rows: OfSensor, benches: list[Bench], solutions: Solutions) -> Comparison:
    return rows(next(bench for bench in benches if bench.sensor is sensor), solutions)


CLAIMS = (*_claims(GYRO), *_claims(ACC))
