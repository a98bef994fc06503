"""The paper's statements in words, each decided by one function."""

from functools import partial

import jax.numpy as jnp
import numpy as np

from filters.gps_aided import GpsAidedKalman, GpsAidedSample
from objectives.in_numpy import in_numpy
from studies.chauhan2009.behaviour import Behaviour, behaviour
from studies.chauhan2009.data import MOTIONS, Step
from studies.chauhan2009.paper import DT, EVERY, STEADY, TRACKED
from studies.chauhan2009.problems import (
    FUZZY,
    HELD_OUT,
    by_hand,
    data_of,
    estimated,
    judged_by_hand,
    noise_of,
    passed,
    tuning_records,
)
from studies.chauhan2009.sweep import Holds, Sweep, ranges
from tuner.problem.other_records import mean_on
from tuner.regression import tanaka
from tuner.run.comparison import Comparison, Verdict, claim, number
from tuner.run.study import Claim, Solutions, best, tuned_values

ALIKE = 0.1
"""Standard deviations count as alike that differ by less than this share."""


def textbook_regression(sweep: Sweep, solutions: Solutions) -> Comparison:
    """The linear program of a fuzzy line, on five samples."""
    found = tanaka([1, 2, 3, 4, 5], [8.0, 6.4, 9.5, 13.5, 13.0])
    return number(
        "lp.textbook",
        "(20) to (22) on five samples whose least spread is 103/12",
        103 / 12,
        found.objective,
        tolerance=1e-9,
        note=f"center {found.center[0]:.9g} + {found.center[1]:.9g} t; {found.message}",
    )


def printed_rate(sweep: Sweep, solutions: Solutions) -> Comparison:
    """10 deg/s for 4 s."""
    right, printed = (
        _turned(filter)
        for filter in (
            GpsAidedKalman(DT, EVERY),
            GpsAidedKalman(DT, EVERY, kinematics="printed"),
        )
    )
    return Comparison(
        quantity="attitude.constant_rate_printed",
        where="(3): 10 deg/s for 4 s",
        paper=None,
        ours=printed,
        unit="deg",
        tolerance=None,
        verdict=Verdict.INCONSISTENT if abs(printed - 40) > 1 else Verdict.MATCH,
        note=f"a rate of 10 deg/s turns by 40 deg in 4 s; with the half that (3) leaves out "
        f"{right:.2f}",
    )


def _turned(filter: GpsAidedKalman) -> float:
    count = round(4 / DT)
    rate = np.tile([0.0, 0.0, np.radians(10.0)], (count, 1))
    samples = GpsAidedSample(jnp.asarray(rate), jnp.asarray(np.full((count, 3), np.nan)))
    found = in_numpy(partial(passed, filter), noise_of({"angle": 1.0}), samples)
    return float(np.degrees(found.angles[-1, 2]))


def _behaviour_by_step(sweep: Sweep, angles: tuple[float, ...]) -> dict[Step, Behaviour]:
    """Behaviour of the fuzzy law, by step."""
    found = {}
    for step in (Step(angle, motion) for angle in angles for motion in MOTIONS):
        pitch = np.asarray(sweep.fuzzy(step).angles)[:, :, 1]
        found[step] = behaviour(pitch, sweep.made(step), sweep.settings, step.pitch)
    return found


def tracking_error(sweep: Sweep, solutions: Solutions) -> Comparison:
    """The steady error after a step, in per cent of it."""
    found = _behaviour_by_step(sweep, TRACKED)
    error = {step: float(np.hypot(b.offset, b.ripple).mean()) for step, b in found.items()}
    worst = max(error.values())
    each = ", ".join(f"{step.pitch:g} deg {step.motion} {e:.2g}" for step, e in error.items())
    return claim(
        "tracking.error_below_1pct",
        "6.2: tracking at 4.4, 17.4 and 28.2 deg is within 1 per cent",
        worst < 1,
        ours=worst,
        unit="%",
        note=f"rms error over the last 60 s in per cent of the angle: {each}; "
        f"the measurements have {sweep.settings.noise:g} deg of noise",
    )


def steady_deviation(sweep: Sweep, solutions: Solutions) -> Comparison:
    """Whether the deviation of the steady error depends on the angle."""
    found = _behaviour_by_step(sweep, STEADY)
    degrees = {step: float(b.ripple.mean()) * step.pitch / 100 for step, b in found.items()}
    small, large = (
        max(d for step, d in degrees.items() if step.pitch == angle)
        for angle in (min(STEADY), max(STEADY))
    )
    each = ", ".join(f"{step.pitch:g} deg {step.motion} {d:.4f}" for step, d in degrees.items())
    return claim(
        "steady.smaller_angle_larger_deviation",
        "6.2, Fig. 5: the smaller the angle, the larger the deviation",
        small > (1 + ALIKE) * large,
        ours=small / large,
        note=f"standard deviation over the last 60 s in deg: {each}; relative to an angle "
        f"{max(STEADY) / min(STEADY):.3g} times smaller the same deviation is that much larger",
    )


def faster_settling(sweep: Sweep, solutions: Solutions) -> Comparison:
    """Fuzzy noise beside random noise: when the error was last large."""
    where = "6.3: settling takes longer with random noise"
    return _driven(
        sweep, "faster_settling", where, lambda fuzzy, random: fuzzy.settled < random.settled
    )


def larger_overshoot(sweep: Sweep, solutions: Solutions) -> Comparison:
    """Fuzzy noise beside random noise: the largest error."""
    where = "6.3: the largest error after the change is much larger with fuzzy noise"
    return _driven(sweep, "larger_overshoot", where, lambda fuzzy, random: fuzzy.peak > random.peak)


def smaller_steady(sweep: Sweep, solutions: Solutions) -> Comparison:
    """Fuzzy noise beside random noise: the deviation at the end."""
    where = "6.3, Fig. 9: steady oscillations are much larger with random noise"
    return _driven(
        sweep, "smaller_steady", where, lambda fuzzy, random: fuzzy.ripple < random.ripple
    )


def _driven(sweep: Sweep, name: str, where: str, holds: Holds) -> Comparison:
    factors = sweep.settings.factors
    kept = {case.step: sweep.holds(case, holds) for case in sweep.cases}
    share = sum(map(len, kept.values())) / (len(factors) * len(kept))
    each = "; ".join(
        f"{step.pitch:g} deg {step.motion}: {ranges(found, factors)}"
        for step, found in kept.items()
    )
    return claim(
        f"fuzzy.{name}",
        where,
        share == 1,
        ours=share,
        note="share of steps and lambdas at which it holds for most records; the mean of random "
        f"noise is lambda^2 times that of fuzzy noise. Holds at {each}",
    )


def positive_definite(sweep: Sweep, solutions: Solutions) -> Comparison:
    """Without a floor and without noise, the residual is constant and Q is 0."""
    # As many as the steps have seeds, which share their compilation; they are all the same.
    inputs = sweep.made(Step(0.0, "silent")).inputs
    gyr, angles = (jnp.asarray(0 * np.asarray(each)) for each in (inputs.gyr, inputs.angles))
    still = inputs._replace(gyr=gyr, angles=angles)
    found = estimated(FUZZY, still, by_hand(sweep.settings) | {"floor": 0.0})
    least = float(np.asarray(found.Q)[-1, 0].max())
    # One of the seven is 0 by the projection.
    second = [float(np.linalg.eigvalsh(np.asarray(found.P)[k, 0])[1]) for k in (0, -1)]
    return claim(
        "P.positive_definite_guaranteed",
        "4: the fuzzy process noise keeps P positive definite",
        least > 0,
        ours=least,
        note="largest entry of Q after constant residuals, 0 without a floor: P becomes singular, "
        f"its second smallest eigenvalue falls from {second[0]:.2g} to {second[1]:.2g}",
    )


def fuzzy_or_constant(sweep: Sweep, solutions: Solutions) -> Comparison:
    """Both kinds of noise, tuned alike, on records that neither was tuned on."""
    settings = sweep.settings
    made = tuning_records(settings, settings.held_out, sweep.seed + HELD_OUT)
    error = {
        name: mean_on(problem, tuned_values(best(name, solutions)), data_of(settings, name, made))
        for name, problem in sweep.posed.items()
    }
    fuzzy = [name for name in error if name != "constant"]
    chosen = min(fuzzy, key=lambda name: best(name, solutions).value)
    untuned = judged_by_hand(settings, made)
    each = ", ".join(f"{name} {e:.4f}" for name, e in error.items())
    return claim(
        "fuzzy_vs_tuned_fixed_Q_heldout",
        "7: fuzzy noise is better than a conventional filter; here both are tuned",
        error[chosen] < error["constant"],
        ours=error[chosen] / error["constant"],
        note=f"held-out pitch error of {chosen}, the best in training, over that of a constant Q "
        f"tuned alike; in deg: {each}; fuzzy with hand-made values {untuned:.4f}",
    )


CLAIMS = (
    Claim("lp.textbook", textbook_regression),
    Claim("attitude.constant_rate_printed", printed_rate),
    Claim("tracking.error_below_1pct", tracking_error),
    Claim("steady.smaller_angle_larger_deviation", steady_deviation),
    Claim("fuzzy.faster_settling", faster_settling),
    Claim("fuzzy.larger_overshoot", larger_overshoot),
    Claim("fuzzy.smaller_steady", smaller_steady),
    Claim("P.positive_definite_guaranteed", positive_definite),
    Claim(
        "fuzzy_vs_tuned_fixed_Q_heldout", fuzzy_or_constant, needs=("constant", "fuzzy_*", "edge")
    ),
)
