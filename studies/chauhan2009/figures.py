"""Figures 2 to 9 as far as the text describes them, and the sweep over lambda."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from studies.chauhan2009.behaviour import Behaviour
from studies.chauhan2009.data import Step, times
from studies.chauhan2009.paper import DRIVEN, EVERY, MAGNIFIED, STEADY, TRACKED
from studies.chauhan2009.problems import CONSTANT, estimated
from studies.chauhan2009.sweep import SHOWN, Sweep
from tuner.run.figure import Chart, Figure, Line, merged
from tuner.run.study import Solutions, best, tuned_values


def figures(sweep: Sweep, solutions: Solutions) -> Iterator[Figure]:
    """All figures."""
    yield _tracking(sweep)
    yield _steady(sweep)
    for angle in (*DRIVEN, MAGNIFIED):
        yield _driven(sweep, Step(angle, "silent"), solutions)
    yield from _swept(sweep)


def _tracking(sweep: Sweep) -> Chart:
    lines = []
    for angle in TRACKED:
        pitch = np.asarray(sweep.fuzzy(Step(angle, "seen")).angles)[:, 0, 1]
        lines.append(Line(f"{angle:g} deg", times(sweep.settings), np.degrees(pitch)))
    title = "Figs 2 to 4: pitch tracked with fuzzy noise, one seed"
    return Chart("fig2_tracking", title, "t, s", "pitch, deg", tuple(lines))


def _steady(sweep: Sweep) -> Chart:
    at = slice(EVERY - 1, None, EVERY)
    t = times(sweep.settings)[at]
    late = t > sweep.settings.seconds - 60
    lines = []
    for angle in STEADY:
        step = Step(angle, "seen")
        pitch = np.asarray(sweep.fuzzy(step).angles)[:, 0, 1]
        error = np.degrees(pitch - np.asarray(sweep.made(step).truth)[:, 0])[at][late]
        lines.append(Line(f"{angle:g} deg", t[late], error))
    title = "Fig. 5 in degrees: the steady error does not depend on the angle"
    return Chart("fig5_steady", title, "t, s", "pitch error, deg", tuple(lines))


def _driven(sweep: Sweep, step: Step, solutions: Solutions) -> Chart:
    settings, made = sweep.settings, sweep.made(step)
    at = slice(EVERY - 1, None, EVERY)
    t = times(settings)[at]
    shown = (t > 50) & (t < 180)
    random = sweep.random(step)
    constant = tuned_values(best("constant", solutions))
    found: dict[str, Any] = {"fuzzy": sweep.fuzzy(step).angles}
    found |= {f"random, lambda {factor:g}": random[factor] for factor in SHOWN}
    found["constant, tuned"] = estimated(CONSTANT, made.inputs, constant).angles
    truth, lines = np.asarray(made.truth)[:, 0], []
    for label, angles in found.items():
        error = np.degrees(np.asarray(angles)[:, 0, 1] - truth)[at][shown]
        lines.append(Line(label, t[shown], 100 * error / step.pitch))
    title = f"Figs 6 to 9: driving noise at {step.pitch:g} deg, a step the gyroscopes do not see"
    return Chart(f"fig6_driven_{step.pitch:g}", title, "t, s", "pitch error, %", tuple(lines))


def _swept(sweep: Sweep) -> Iterator[Chart]:
    """Means over the records: random noise over lambda, beside fuzzy noise."""
    factors = np.array(sweep.settings.factors)
    named = {"peak": "largest error in 60 s, %", "settled": "last error above 5 %, s"}
    named["ripple"] = "deviation over the last 60 s, %"
    for part, label in named.items():
        lines = []
        for case in sweep.cases:
            if case.step.pitch not in (DRIVEN[1], MAGNIFIED):
                continue
            what = f"{case.step.pitch:g} deg {case.step.motion}"
            random = np.array([_mean(each, part) for each in case.random])
            lines.append(Line(f"random, {what}", factors, random))
            lines.append(
                Line(f"fuzzy, {what}", factors, np.full(len(factors), _mean(case.fuzzy, part)))
            )
        title = f"Random noise over lambda beside fuzzy noise: {label.split(',')[0]}"
        yield Chart(f"sweep_{part}", title, "lambda", label, merged(lines), log="x")


def _mean(found: Behaviour, part: str) -> float:
    return float(np.mean(getattr(found, part)))
