"""Figures 2 to 9 as far as the text describes them, and the sweep over lambda."""

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from studies.chauhan2009.behaviour import TOLERATED, Behaviour
from studies.chauhan2009.data import BEFORE, MOTIONS, Motion, Step, times
from studies.chauhan2009.paper import DRIVEN, EVERY, MAGNIFIED, STEADY, TRACKED
from studies.chauhan2009.problems import CONSTANT, estimated
from studies.chauhan2009.sweep import SHOWN, Sweep, ranges
from tuner.run.figure import Chart, Figure, Line
from tuner.run.study import Solutions, best, tuned_values


def figures(sweep: Sweep, solutions: Solutions) -> Iterator[Figure]:
    """All figures."""
    yield _tracking(sweep)
    yield _steady(sweep)
    for angle in (*DRIVEN, MAGNIFIED):
        yield _driven(sweep, Step(angle, "silent"), solutions)
    yield from _swept(sweep)


def _tracking(sweep: Sweep) -> Chart:
    lines, errors = [], []
    for angle in TRACKED:
        pitch, error = _followed(sweep, angle)
        lines.append(Line(f"{angle:g} deg", times(sweep.settings), pitch))
        errors.append(_rms(error[_late(sweep)]))
    title = (
        f"Figs 2 to 4: fuzzy noise follows steps of {TRACKED[0]:g} to {TRACKED[-1]:g} deg, "
        f"at the end to {max(errors):.2g} deg rms"
    )
    return Chart("fig2_tracking", title, "time, s", "pitch, deg", tuple(lines))


def _steady(sweep: Sweep) -> Chart:
    at = slice(EVERY - 1, None, EVERY)
    late = _late(sweep)[at]
    t, lines, errors = times(sweep.settings)[at][late], [], []
    for angle in STEADY:
        error = _followed(sweep, angle)[1][at][late]
        lines.append(Line(f"{angle:g} deg", t, error))
        errors.append(_rms(error))
    values = ", ".join(f"{e:.2g} deg at {angle:g}" for angle, e in zip(STEADY, errors, strict=True))
    title = f"Fig. 5 in degrees: the rms of the steady error is {values} deg"
    return Chart("fig5_steady", title, "time, s", "pitch error, deg", tuple(lines))


def _followed(sweep: Sweep, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Pitch and its error by fuzzy noise after a step that the gyroscopes see, deg, one seed."""
    step = Step(angle, "seen")
    pitch = np.degrees(np.asarray(sweep.fuzzy(step).angles)[:, 0, 1])
    return pitch, pitch - np.degrees(np.asarray(sweep.made(step).truth)[:, 0])


def _late(sweep: Sweep) -> np.ndarray:
    """Whether a tick is in the last minute."""
    return times(sweep.settings) > sweep.settings.seconds - 60


def _rms(error: np.ndarray) -> float:
    return float(np.sqrt(np.mean(error**2)))


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
    truth, lines, settled = np.asarray(made.truth)[:, 0], [], {}
    for label, angles in found.items():
        error = 100 * np.degrees(np.asarray(angles)[:, 0, 1] - truth)[at] / step.pitch
        lines.append(Line(label, t[shown], error[shown]))
        outside = t[(np.abs(error) > TOLERATED) & (t > BEFORE)]
        settled[label] = max(outside, default=BEFORE) - BEFORE
    return Chart(
        name=f"fig6_driven_{step.pitch:g}",
        title=f"Figs 6 to 9: {step.pitch:g} deg that the gyroscopes do not see: the error last "
        f"exceeds {TOLERATED:g} % after {settled['fuzzy']:.0f} s with fuzzy noise, "
        f"{settled['constant, tuned']:.0f} s with constant noise",
        x_label="time, s",
        y_label="pitch error, %",
        lines=tuple(lines),
    )


class _Part(NamedTuple):
    """A part of the behaviour, and whether laws are compared by their ratio or difference."""

    name: str
    axis: str
    unit: str
    ratio: bool


PARTS = {
    "peak": _Part("largest error in 60 s", "random over fuzzy", "%", ratio=True),
    "settled": _Part(
        f"time of the last error above {TOLERATED:g} %", "random less fuzzy, s", "s", ratio=False
    ),
    "ripple": _Part("deviation over the last 60 s", "random over fuzzy", "%", ratio=True),
}


def _swept(sweep: Sweep) -> Iterator[Chart]:
    """Means over the records: random noise over lambda against fuzzy noise.

    In every chart a step has the same colour.
    """
    factors = np.array(sweep.settings.factors)
    for part, words in PARTS.items():
        lines, lower = [], dict.fromkeys(MOTIONS, np.ones(len(factors), bool))
        for case in sweep.cases:
            if case.step.pitch not in (DRIVEN[1], MAGNIFIED):
                continue
            fuzzy = _mean(case.fuzzy, part)
            random = np.array([_mean(each, part) for each in case.random])
            against = random / fuzzy if words.ratio else random - fuzzy
            name = f"{case.step.pitch:g} deg {case.step.motion}, fuzzy {fuzzy:.2g} {words.unit}"
            lines.append(Line(name, factors, against))
            motion = case.step.motion
            lower[motion] = lower[motion] & (against < (1 if words.ratio else 0))
        where = [_lambdas(factors, found, motion) for motion, found in lower.items()]
        if not any(found.any() for found in lower.values()):
            where = ["no lambda"]
        same = np.full(2, 1.0 if words.ratio else 0.0)
        equal = Line("as with fuzzy noise", factors[[0, -1]], same, drawn="limit")
        yield Chart(
            name=f"sweep_{part}",
            title=f"Random noise has the smaller {words.name} at {' and '.join(where)}",
            x_label="lambda",
            y_label=f"{words.name}, {words.axis}",
            lines=(*lines, equal),
            log="xy" if words.ratio else "x",
        )


def _lambdas(factors: np.ndarray, found: np.ndarray, motion: Motion) -> str:
    """The lambdas that are found, after steps of a kind, in words."""
    values = f"lambda {ranges(list(factors[found]), list(factors))}" if found.any() else "no lambda"
    return f"{values} ({motion} steps)"


def _mean(found: Behaviour, part: str) -> float:
    return float(np.mean(getattr(found, part)))
