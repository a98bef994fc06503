"""The paper's numbers and claims, each decided by one function."""

from functools import partial
from typing import TypeAlias

import numpy as np

from objectives import settling_time
from objectives.in_numpy import in_numpy
from studies.ha1981 import paper, scheme
from studies.ha1981.channel import (
    FORMS,
    Channel,
    Gains,
    kalman_history,
    loop_history,
    times,
)
from studies.ha1981.conventional import gains_of
from studies.ha1981.paper import TS
from studies.ha1981.settings import Settings
from tuner.run.comparison import Comparison, Verdict, claim, number
from tuner.run.study import Claim, Solutions, best

INSENSITIVE = 0.1
"""Sensitivity below which the variance is insensitive to a parameter."""
REACHED = 1.02
"""The conventional loop ends above its bound by the floor; within 2 % counts as there."""


Case: TypeAlias = tuple[Channel, Settings]


def _K1(case: Case, solutions: Solutions) -> Comparison:
    """K1 of the fastest loop within the bound."""
    note = "NLP over factors of the characteristic polynomial; the optimum is global"
    return _loop_gain("K1_over_eta", 16.0, _found(solutions).K1 / case[0].eta, note)


def _K2(case: Case, solutions: Solutions) -> Comparison:
    """K2' of the fastest loop."""
    ours = _found(solutions).K2p / case[0].eta ** 2
    return _loop_gain("K2_over_eta2", 256 / 3, ours, "K2' = K2 - Kgh")


def _K3(case: Case, solutions: Solutions) -> Comparison:
    """K3 of the fastest loop, and the bound on its decay by a matrix inequality."""
    least = solutions["conventional_lmi", "sdp"].certificate.lower_bound or np.inf
    ratio = solutions["conventional", "ipopt"].value / least
    return _loop_gain(
        "K3_over_eta3",
        4096 / 27,
        _found(solutions).K3 / case[0].eta ** 3,
        f"one Lyapunov matrix for variance and decay, as a matrix inequality needs it, proves "
        f"at most {ratio:.3f} of this decay rate",
    )


def _found(solutions: Solutions) -> Gains:
    return gains_of(solutions["conventional", "ipopt"])


def _loop_gain(name: str, paper: float, ours: float, note: str) -> Comparison:
    return number(f"conventional.{name}", "after (9)", paper, ours, tolerance=1e-6, note=note)


def _printed_bound(case: Case, solutions: Solutions) -> Comparison:
    """Consequences of the bound as printed."""
    channel, _ = case
    huge = paper.SIGMA2_AB / paper.Q_A  # ft and s, whatever the unit of the run
    pole, settles = 16 * huge / 3, 1.409363 / huge
    return Comparison(
        quantity="conventional.sigma2_given_4.0",
        where="II.2: sigma_a^2 = 4.0",
        paper=paper.SIGMA2_AB,
        ours=None,
        unit="(ft/s^2)^2",
        tolerance=None,
        verdict=Verdict.INCONSISTENT,
        note=f"III uses this value for the bias's variance; as a bound it gives eta = {huge:g}, "
        f"poles at -{pole:.0f} rad/s, settling in {1e3 * settles:.0f} ms. "
        f"{channel.bound:.4g} {channel.squared} is used",
    )


def _ise(case: Case, solutions: Solutions) -> Comparison:
    """The paper's "better than ISE in viewpoint of the settling time"."""
    pole, form = (_settles(FORMS[name].at(1.0)) for name in ("triple pole", "ISE form"))
    searched = solutions["ise", "ipopt"]
    return claim(
        "ise.better_than_paper_claim",
        "II.2: better than ISE in settling time",
        pole[0.02] < form[0.02] and pole[0.05] < form[0.05],
        ours=pole[0.02] / form[0.02],
        note=f"settling times over those of the ISE form: {pole[0.02] / form[0.02]:.3f} (2 %), "
        f"{pole[0.05] / form[0.05]:.3f} (5 %). ISE within the bound: {searched.status.value}, "
        f"its infimum {0.25 / case[0].eta:g} s needs infinite gains",
    )


def _settling(case: Case, solutions: Solutions) -> Comparison:
    """The paper's "shortest settling time can be obtained from" the fastest slowest pole."""
    pole, bessel = (_settles(FORMS[name].at(1.0)) for name in ("triple pole", "Bessel"))
    return claim(
        "settling.triple_pole_fastest",
        "II.1: the fastest slowest pole settles first",
        pole[0.02] <= bessel[0.02] and pole[0.05] <= bessel[0.05],
        ours=bessel[0.02] / pole[0.02],
        note=f"settling times, Bessel form of the same variance and triple pole: "
        f"{bessel[0.02]:.5f}/eta and {pole[0.02]:.5f}/eta (2 %), "
        f"{bessel[0.05]:.5f}/eta and {pole[0.05]:.5f}/eta (5 %)",
    )


def _settles(gains: Gains) -> dict[float, float]:
    start = np.array([1.0, 0.0, 0.0])
    found = {
        band: in_numpy(settling_time, gains.error, start, start, band) for band in (0.02, 0.05)
    }
    return {band: float(time) for band, time in found.items()}


def _K2_inf(case: Case, solutions: Solutions) -> Comparison:
    """The steady gain on the velocity."""
    return _steady_gain(case[0], "K2", 0, "1/s")


def _K3_inf(case: Case, solutions: Solutions) -> Comparison:
    """The steady gain on the altitude."""
    return _steady_gain(case[0], "K3", 1, "")


def _steady_gain(channel: Channel, name: str, index: int, unit: str) -> Comparison:
    printed = paper.steady_gains(channel.q_a, channel.q_b, TS)
    return number(
        f"kalman.{name}_inf_5s",
        "after (18), Ts = 5 s",
        getattr(printed, name),
        float(scheme.steady_gains(channel, TS)[index]),
        tolerance=1e-3,
        unit=unit,
        note="Riccati equation with Kgh; the paper's formula is exact for Kgh = 0, q_a being "
        "a spectral density",
    )


def _floor(case: Case, solutions: Solutions) -> Comparison:
    """Whether an error of the bias remains."""
    channel, _ = case
    end = scheme.reaches(channel, TS)
    P11 = float(kalman_history(channel, TS, end).P[-1, 0, 0])
    return claim(
        "kalman.p11_floor",
        "after (18): no steady state estimation error exists",
        channel.floor == 0,
        ours=channel.floor,
        unit=channel.squared,
        note=f"P11 falls as q_a/t ({P11:.4g} at {end:g} s); the error of the given altitude, not "
        f"in (11), leaves Kgh^2 sigma_hr^2 = {channel.floor:.4e}",
    )


def _insensitive(case: Case, solutions: Solutions, *, name: str) -> Comparison:
    """The cost of a wrong parameter of the model, with stored gains."""
    channel, settings = case
    end = scheme.reaches(channel, TS)
    key = "sigma2_ab" if name == "sigma_ab" else name
    slope = scheme.sensitivities(channel, TS, settings.seconds)[key]
    late = float(slope[round(end / TS)])
    silent = "; the paper does not mention q_a" if name == "q_a" else ""
    return claim(
        f"kalman.insensitive_{name}",
        "III.2 and IV, by (19)",
        abs(late) < INSENSITIVE,
        ours=late,
        note=f"d ln P11 / d ln {name} with stored gains at {end:g} s, where the bound is "
        f"reached; {float(slope[round(10 / TS)]):.3g} at 10 s{silent}",
    )


def _insensitive_to_period(case: Case, solutions: Solutions) -> Comparison:
    """The cost of another sampling period."""
    channel, at = case[0], 100.0
    coarse, fine = (
        float(kalman_history(channel, Ts, at).P[-1, 0, 0]) for Ts in (TS, scheme.REPLAY)
    )
    slope = np.log(coarse / fine) / np.log(TS / scheme.REPLAY)
    wrong = scheme.replay(channel, TS, at, by="sample")[-1]
    held = scheme.replay(channel, TS, at, by="time")[-1]
    return claim(
        "kalman.insensitive_ts",
        "III.2 and IV",
        abs(slope) < INSENSITIVE,
        ours=float(slope),
        note=f"gains computed for each Ts, at {at:g} s. Gains for {TS:g} s, replayed every "
        f"{scheme.REPLAY:g} s, multiply P11 by {wrong:.0f} sample by sample, by {held:.2f} by time",
    )


def _printed_noise(case: Case, solutions: Solutions) -> Comparison:
    """Whether the printed Q is a covariance."""
    channel, _ = case
    try:
        paper.printed_noise(channel.q_a, channel.k_gh, 0.5)
    except ValueError as error:
        return Comparison(
            quantity="kalman.printed_Q_psd",
            where="below (12), Ts = 0.5 s",
            paper=None,
            ours=None,
            unit="",
            tolerance=None,
            verdict=Verdict.INCONSISTENT,
            note=f"{error}; it is not a covariance for any Ts < 1 s",
        )
    return claim(
        "kalman.printed_Q_psd", "below (12)", True, ours=None, note="a covariance at Ts = 0.5 s"
    )


def _better(case: Case, solutions: Solutions) -> Comparison:
    """Which scheme reaches the bound first."""
    channel, _ = case
    end = scheme.reaches(channel, TS)
    gains = gains_of(best("conventional", solutions))
    span = 4 * end
    loop = loop_history(channel, gains, TS, span)
    kalman = np.asarray(kalman_history(channel, TS, span).P)[:, 0, 0]
    at = times(span, TS)
    above = np.flatnonzero(loop > REACHED * channel.bound)
    there = at[above[-1] + 1] if above.size and above[-1] + 1 < len(at) else np.inf
    i = round(end / TS)
    return claim(
        "kalman.better_than_conventional",
        "IV",
        bool(end < there and (kalman[1:] <= loop[1:] * (1 + 1e-9)).all()),
        ours=there / end,
        note=f"the Kalman scheme meets the bound after {end:g} s, the loop after {there:g} s "
        f"(within {100 * (REACHED - 1):.0f} %); at {end:g} s its variance is "
        f"{loop[i] / kalman[i]:.0f} times as large, without altimeter noise",
    )


def _stages(case: Case, solutions: Solutions) -> Comparison:
    """Gains in two stages against constant ones."""
    end = scheme.reaches(case[0], TS)
    one, two = (best(f"staged_{k}", solutions) for k in (1, 2))
    switch = float(two.parameters["switch"].value)
    return claim(
        "conventional.time_varying_gains_better",
        "IV: better performance with time-varying loop gains",
        two.value < one.value,
        ours=two.value / one.value,
        note=f"variance at {end:g} s over the limit q_a/t: {one.value:.3f} with one triple pole, "
        f"{two.value:.3f} with two that change at {switch:.1f} s",
    )


def _stored(case: Case, solutions: Solutions) -> Comparison:
    """The cost of storing only a few gains."""
    found = best("kalman_stored", solutions)
    return claim(
        "kalman.stored_gains_sluggish",
        "IV: fewer stored gains are somewhat sluggish",
        1 < found.value < 2,
        ours=found.value,
        note=f"mean ratio of the variance to the Kalman filter's over all samples, with "
        f"{case[1].segments} tuned gains besides the first",
    )


CONVENTIONAL = ("conventional",)
CLAIMS = (
    Claim("conventional.K1_over_eta", _K1, CONVENTIONAL),
    Claim("conventional.K2_over_eta2", _K2, CONVENTIONAL),
    Claim("conventional.K3_over_eta3", _K3, ("conventional", "conventional_lmi")),
    Claim("conventional.sigma2_given_4.0", _printed_bound),
    Claim("ise.better_than_paper_claim", _ise, ("ise",)),
    Claim("settling.triple_pole_fastest", _settling),
    Claim("kalman.K2_inf_5s", _K2_inf),
    Claim("kalman.K3_inf_5s", _K3_inf),
    Claim("kalman.p11_floor", _floor),
    *(
        Claim(f"kalman.insensitive_{name}", partial(_insensitive, name=name))
        for name in ("q_b", "sigma_ab", "q_a")
    ),
    Claim("kalman.insensitive_ts", _insensitive_to_period),
    Claim("kalman.printed_Q_psd", _printed_noise),
    Claim("kalman.better_than_conventional", _better, CONVENTIONAL),
    Claim("conventional.time_varying_gains_better", _stages, ("staged_1", "staged_2")),
    Claim("kalman.stored_gains_sluggish", _stored, ("kalman_stored",)),
)
