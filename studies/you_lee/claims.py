"""The paper's gains and claims, each checked by one function."""

from dataclasses import replace
from functools import partial
from math import asin, degrees

import jax.numpy as jnp
import numpy as np

from filters import PiComplementary
from objectives import ComplementaryLoop
from studies.you_lee.cases import Bench, Case, Spread, errors_of, gains
from studies.you_lee.data import deterministic
from studies.you_lee.flight import TRAJECTORIES, Trajectory, rate_and_slope
from studies.you_lee.paper import GRAVITY, MISREAD, PER_HOUR, PUBLISHED, TwoGains
from studies.you_lee.problems import AIDS, spaces, tuned_case
from studies.you_lee.settings import Settings, Start
from tuner.run.comparison import Comparison, Verdict, claim, number, undecided
from tuner.run.study import Claim, Solutions, best

LARGE = 2.0
"""Ratio to the level flight's error from which an error in the turn is large."""
MUCH = 0.5
""""Much reduced": the largest share of the error that may remain, of roll and of pitch."""
FLAT = 0.01
"""Change of the error over four decades, and 0, below which a parameter is not determined."""
SETTLES = 3.0
"""Time constants of the filter after which an error is settled."""
VANISHES = 1e-9
"""A determinant counts as 0 below this share of its largest term."""
PRINTED_GAINS = TwoGains()
Q_SWEPT = (0.0, 2e-11, 2e-9, 2e-8, 2e-7)
REDUCED: tuple[tuple[str, Trajectory, Start], ...] = (
    ("T1_zero_start", "T1", "zero"),
    ("T1_true_start", "T1", "true"),
    ("T0", "T0", "zero"),
    ("T2", "T2", "zero"),
)
"""Where the velocity filter is judged. On T0 and T2 both starts are one: v and w begin at 0."""


def tau_of_K1(bench: Bench, solutions: Solutions, printed: TwoGains = PRINTED_GAINS) -> Comparison:
    """The time constant to which K1 belongs."""
    note = f"K2 = {1 / (2 * printed.tau_of_K1):.4g} would belong to it"
    return _of_15(printed, "tau_from_K1", printed.tau_of_K1, "s", note)


def tau_of_K2(bench: Bench, solutions: Solutions, printed: TwoGains = PRINTED_GAINS) -> Comparison:
    """The time constant to which K2 belongs."""
    note = f"K1 = {2 / printed.tau_of_K2:.4g} would belong to it"
    return _of_15(printed, "tau_from_K2", printed.tau_of_K2, "s", note)


def one_tau(bench: Bench, solutions: Solutions, printed: TwoGains = PRINTED_GAINS) -> Comparison:
    """Whether both time constants are equal."""
    K1, K2 = printed
    return _of_15(
        printed,
        "tau_consistent",
        printed.tau_of_K1 / printed.tau_of_K2,
        "",
        f"tau is {printed.tau_of_K1:.4g} s from K1 = {K1:g}, {printed.tau_of_K2:.4g} s from K2 = "
        f"{K2:g}, {(K1 * K2) ** -0.5:.4g} s from both; K1 may be a misprint of .05: both are run",
    )


def damping(bench: Bench, solutions: Solutions, printed: TwoGains = PRINTED_GAINS) -> Comparison:
    """The damping of the poles, which (15) makes 1."""
    loop = ComplementaryLoop(*map(jnp.asarray, printed))
    fast, slow = np.asarray(loop.poles)
    note = f"poles {_complex(fast)}, {_complex(slow)}"
    return replace(_of_15(printed, "damping", float(loop.damping), "", note), paper=1.0)


def _of_15(printed: TwoGains, name: str, ours: float, unit: str, note: str) -> Comparison:
    agreed = Verdict.MATCH if printed.agree else Verdict.INCONSISTENT
    return Comparison(f"gains.{name}", "(15)", None, ours, unit, None, agreed, note)


def _complex(pole: complex) -> str:
    return f"{pole.real:.6g}" if pole.imag == 0 else f"{pole.real:.6g} {pole.imag:+.6g}i"


def small_in_level_flight(bench: Bench, solutions: Solutions) -> Comparison:
    """The worst of all runs with (10), on all three flights."""

    def worst(values: tuple[tuple[str, float], ...] = ()) -> np.ndarray:
        cases = [Case(name, "airspeed", values=values) for name in TRAJECTORIES]
        peaks = [found.level_peak.max(axis=0) for found in bench.spreads(cases)]
        return np.asarray(np.max(peaks, axis=0))

    (roll, pitch), other = worst(), worst(MISREAD)
    return claim(
        "level.error_below_1deg",
        "section 5: in level flight errors do not pass 1 deg",
        bool(max(roll, pitch) < 1),
        ours=float(max(roll, pitch)),
        unit="deg",
        note=f"worst of {bench.settings.runs} runs with (10): roll {roll:.3g}, pitch {pitch:.3g} "
        f"deg; K1 = .05: {other[0]:.3g}, {other[1]:.3g}",
    )


def large_in_the_turn(bench: Bench, solutions: Solutions) -> Comparison:
    """The error in the bank turn with (10), over that in level flight."""

    def grown(name: Trajectory, values: tuple[tuple[str, float], ...] = ()) -> float:
        found = bench.spread(Case(name, "airspeed", values=values))
        level = found.level_peak[:, 0].mean()
        return float(found.turn_maximum[0] / level) if level else np.nan

    roll = bench.spread(Case("T1", "airspeed")).turn_maximum[0]
    row = (
        "turn.error_large_eq10",
        "section 4 (1), Fig. 4: in the bank turn errors become very large",
    )
    if not np.isfinite(grown("T1")):
        return undecided(*row, note="in level flight there is no error to compare with")
    return claim(
        *row,
        grown("T1") > LARGE,
        ours=grown("T1"),
        note=f"mean largest roll error in the turn ({roll:.3g} deg on T1) over that in level "
        f"flight; T0 {grown('T0'):.3g}, T2 {grown('T2'):.3g}; "
        f"K1 = .05: {grown('T1', MISREAD):.3g} on T1",
    )


def reduced(
    bench: Bench, solutions: Solutions, *, name: str, trajectory: Trajectory, start: Start
) -> Comparison:
    """The share of the error in the turn that remains with the velocity filter."""

    def left(values: tuple[tuple[str, float], ...]) -> tuple[np.ndarray, Spread, Spread]:
        plain = bench.spread(Case(trajectory, "airspeed", values=values))
        aided = bench.spread(Case(trajectory, "velocity", start, values))
        return aided.turn_maximum / plain.turn_maximum, plain, aided

    share, plain, aided = left(())
    other = left(MISREAD)[0]
    before, after = plain.turn_maximum, aided.turn_maximum
    return claim(
        f"turn.reduced_by_kf_{name}",
        "section 4 (2), Fig. 5: in the bank turn the error is much reduced",
        bool(share.max() <= MUCH),
        ours=float(share[0]),
        note=f"mean largest error in the turn, roll {after[0]:.3g} for {before[0]:.3g}, pitch "
        f"{after[1]:.3g} for {before[1]:.3g} deg; K1 = .05: {other[0]:.2g} of roll, "
        f"{other[1]:.2g} of pitch",
    )


def process_noise(bench: Bench, solutions: Solutions) -> Comparison:
    """Whether any Q_k near the published one is better than another."""
    cases = [Case("T1", "velocity", values=(("Q_k", q),)) for q in Q_SWEPT]
    roll = [float(found.turn_maximum[0]) for found in bench.spreads(cases)]
    change, lowest = max(roll) / min(roll) - 1, Q_SWEPT[int(np.argmin(roll))]
    words = f"from {Q_SWEPT[0]:g} to {Q_SWEPT[-1]:g} the roll error in the turn changes by"
    if change < FLAT:
        return undecided(
            "Qk.identifiable",
            "section 4 (2): Q_k = 2e-9 decided by a few simulations",
            paper=PUBLISHED["Q_k"],
            unit="(ft/s)^2",
            note=f"{words} {100 * change:.2g} %",
        )
    row = number(
        "Qk.identifiable",
        "section 4 (2): Q_k = 2e-9 decided by a few simulations",
        PUBLISHED["Q_k"],
        lowest,
        tolerance=FLAT,
        unit="(ft/s)^2",
    )
    return replace(row, note=f"{words} {100 * change:.2g} %, and is lowest at {lowest:g}")


def level_floor(bench: Bench, solutions: Solutions) -> Comparison:
    """A bias of r alone, which (10) takes for a turn."""
    settings, flight = bench.settings, bench.flights["T1"]
    inputs = deterministic(settings, flight, (2,))
    end = round(settings.level * settings.rate_hz) - 1

    def left(**values: float) -> float:
        params = gains(settings, flight, "zero", values)
        filter = PiComplementary(settings.dt, "airspeed")
        return float(errors_of(filter, params, inputs, flight.truth)[end, 0, 0])

    row = "level.roll_floor_deg", "(10): b_r u / g"
    sine = settings.gyro_bias * PER_HOUR * flight.velocity0[0] / GRAVITY
    if sine >= 1:
        return undecided(*row, note=f"b_r u / g is {sine:.3g}, which has no arc sine")
    floor = degrees(asin(sine))
    loop = ComplementaryLoop(jnp.asarray(settings.K1), jnp.asarray(settings.K2))
    slowest = float(np.abs(np.asarray(loop.poles).real).min())
    if settings.level * slowest < SETTLES:
        return undecided(
            *row,
            paper=floor,
            unit="deg",
            note=f"{settings.level:g} s of level flight are fewer than {SETTLES:g} time constants "
            f"of the filter's slowest pole, -{slowest:.3g} 1/s, so the error is not settled",
        )
    bias = settings.gyro_bias
    twice = {"K1": 2 * settings.K1, "K2": 2 * settings.K2}
    return number(
        *row,
        floor,
        left(),
        tolerance=0.02,
        unit="deg",
        note=f"roll error that {bias:g} deg/h of r leave in level flight whatever the gains: "
        f"{left(**twice):.4g} with both doubled, {left(K1=0.05):.4g} with K1 = .05",
    )


def observability(bench: Bench, solutions: Solutions) -> Comparison:
    """(13) det V = p (q^2 + r^2) + q r' - r q'; its largest term is p (q^2 + r^2)."""
    settings = bench.settings
    t = jnp.asarray(settings.level + settings.turn * np.linspace(0.001, 0.999, 499))
    found = {}
    for name in TRAJECTORIES:
        both = rate_and_slope(name, settings.course, t)
        (p, q, r), (_, dq, dr) = (np.asarray(part).T for part in both)
        term = p * (q**2 + r**2)
        found[name] = np.abs(term + q * dr - r * dq).max() / np.abs(term).max()
    return claim(
        "observability.det_theta0",
        "(13): v and w are observable where p, q and r are not 0",
        found["T0"] > VANISHES,
        ours=float(found["T0"]),
        note="largest abs(det V) over its largest term; with theta = 0 it is 0 for "
        f"any roll and yaw; {found['T1']:.2g} on T1, {found['T2']:.2g} on T2",
    )


def better_tuned(bench: Bench, solutions: Solutions, *, problem: str) -> Comparison:
    """The share of the published filter's error that remains after tuning, on held-out runs."""
    settings, solution = bench.settings, best(problem, solutions)
    case = tuned_case(settings, solution)
    ours, plain = bench.spreads([case, _published(settings, case)])
    found = {
        name: float(solution.parameters[name].value) for name in spaces(settings)[problem].names
    }
    words = ", ".join(f"{name} = {value:.4g}" for name, value in found.items())
    return claim(
        f"tuned.{problem}_over_published",
        "section 3 (3): tau is varied and the one with the least error taken; tuning does better",
        ours.whole_rms < plain.whole_rms,
        ours=ours.whole_rms / plain.whole_rms,
        note=f"{case.trajectory}, {words}: {ours.whole_rms:.4g} for {plain.whole_rms:.4g} deg over "
        f"{settings.runs} held-out runs, {solution.value:.4g} on the {settings.train} tuned on; "
        f"roll in the turn {ours.turn_maximum[0]:.3g} for {plain.turn_maximum[0]:.3g} deg",
    )


def _published(settings: Settings, case: Case) -> Case:
    """The same filter with the paper's parameters, given only where settings differ."""
    changed = (kv for kv in PUBLISHED.items() if getattr(settings, kv[0]) != kv[1])
    return case._replace(values=tuple(changed))


CLAIMS = (
    Claim("gains.tau_from_K1", tau_of_K1),
    Claim("gains.tau_from_K2", tau_of_K2),
    Claim("gains.tau_consistent", one_tau),
    Claim("gains.damping", damping),
    Claim("level.error_below_1deg", small_in_level_flight),
    Claim("turn.error_large_eq10", large_in_the_turn),
    *(
        Claim(
            f"turn.reduced_by_kf_{name}",
            partial(reduced, name=name, trajectory=trajectory, start=start),
        )
        for name, trajectory, start in REDUCED
    ),
    Claim("Qk.identifiable", process_noise),
    Claim("level.roll_floor_deg", level_floor),
    Claim("observability.det_theta0", observability),
    *(
        Claim(f"tuned.{problem}_over_published", partial(better_tuned, problem=problem), (problem,))
        for problem in AIDS
    ),
)
"""The claims; those of problems that are not posed are dropped."""
