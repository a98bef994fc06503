"""The paper's figures 3 and 5 to 9, and further ones, as data."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.linalg import expm

from studies.ha1981 import scheme
from studies.ha1981.channel import (
    FORMS,
    Channel,
    Gains,
    kalman_history,
    loop_history,
    replayed,
    riccati_history,
    times,
)
from studies.ha1981.conventional import gains_of
from studies.ha1981.settings import Settings
from tuner.names import counted
from tuner.run.figure import Chart, Figure, Line
from tuner.run.study import Solutions, best, tuned_values

FINE = 0.1
"""Time step of continuous curves, s."""
NEAR = 0.1
"""A variance that is above the bound by this share is as good as at it."""


def figures(case: tuple[Channel, Settings], solutions: Solutions) -> Iterator[Figure]:
    """All figures."""
    channel, settings = case
    designed = gains_of(best("conventional", solutions))
    yield _loops(channel, settings, designed)
    yield _steps(channel, designed)
    yield from _schemes(channel, settings)
    yield _sensitivity(channel, settings)
    yield _both(channel, settings, designed)
    yield _replayed(channel, settings)
    yield _stored(channel, settings, solutions)
    yield _ise_limit()


def _designs(channel: Channel, designed: Gains) -> dict[str, Gains]:
    others = {name: form.at(channel.eta) for name, form in FORMS.items() if name != "triple pole"}
    return {"triple pole (tuned)": designed} | others


def _loops(channel: Channel, settings: Settings, designed: Gains) -> Chart:
    span = 2 * settings.seconds
    at = times(span, FINE)
    lines = [
        Line(name, at, loop_history(channel, gains, FINE, span))
        for name, gains in _designs(channel, designed).items()
    ]
    when = ", ".join(f"{line.label} {_within(line, channel.bound)}" for line in lines)
    lines.append(Line("bound", at[[0, -1]], np.full(2, channel.bound), drawn="limit"))
    title = f"Conventional loop, at most {100 * NEAR:g} % above the bound: {when}"
    return _over_time(channel, "fig3_conventional", title, lines)


def _within(line: Line, bound: float) -> str:
    """From when on a curve stays near the bound, or below it, in words."""
    above = line.x[line.y > (1 + NEAR) * bound]
    if not len(above):
        return "always"
    return "never" if above[-1] == line.x[-1] else f"from {above[-1]:.0f} s on"


def _steps(channel: Channel, designed: Gains) -> Chart:
    at = np.linspace(0, 2.5 / channel.eta, 501)
    lines = []
    for name, gains in _designs(channel, designed).items():
        F = expm(gains.error * (at[1] - at[0]))
        x, rows = np.array([-1.0, 0.0, 0.0]), []
        for _ in at:
            rows.append(x[0])
            x = F @ x
        lines.append(Line(name, at, 1 + np.array(rows)))
    return Chart(
        name="step_response",
        title=f"Forms of one steady variance overshoot a step of the bias by {_overshoots(lines)}",
        x_label="time, s",
        y_label="estimated bias over the true one",
        lines=tuple(lines),
    )


def _overshoots(lines: list[Line]) -> str:
    return ", ".join(f"{100 * max(line.y.max() - 1, 0.0):.2g} % ({line.label})" for line in lines)


def _schemes(channel: Channel, settings: Settings) -> Iterator[Chart]:
    found = {}
    for Ts in settings.periods:
        if Ts == 0:
            history = riccati_history(channel, FINE, settings.seconds)
            found["continuous"] = times(settings.seconds, FINE), history
        else:
            history = kalman_history(channel, Ts, settings.seconds)
            found[f"Ts = {Ts:g} s"] = times(settings.seconds, Ts), history
    lines = [Line(name, at[1:], np.asarray(h.P[1:, 0, 0])) for name, (at, h) in found.items()]
    ends = [line.y[-1] for line in lines]
    title = f"Kalman scheme: after {settings.seconds:g} s the variance is {min(ends):.3g} to "
    title += f"{max(ends):.3g} {channel.squared} at every sampling period"
    yield replace(_over_time(channel, "fig5_kalman", title, lines), log="xy")
    for i, unit in enumerate(("1/s^2", "1/s", "1")):
        # The continuous filter's gains are per second: a different quantity.
        gains = [
            Line(name, at, np.asarray(h.K[:, i, 0]))
            for name, (at, h) in found.items()
            if name != "continuous"
        ]
        peak = max(int(np.argmax(line.y[1:])) + 1 for line in gains)
        yield Chart(
            name=f"fig{6 + i}_K{i + 1}",
            title=f"Kalman gain K{i + 1} is largest within the first {counted(peak, 'sample')}, "
            "whatever Ts",
            x_label="time, s",
            y_label=f"K{i + 1}, {unit}",
            lines=tuple(replace(line, x=line.x[1:], y=line.y[1:]) for line in gains),
            log="x",
        )


def _sensitivity(channel: Channel, settings: Settings) -> Chart:
    at = times(settings.seconds, settings.Ts)
    found = scheme.sensitivities(channel, settings.Ts, settings.seconds)
    names = {"q_a": "q_a", "q_b": "q_b", "sigma2_ab": "sigma^2_AB"}
    last = ", ".join(f"{found[key][-1]:.2g} ({name})" for key, name in names.items())
    return Chart(
        name="fig9_sensitivity",
        title=f"Sensitivity of P11 by (19), stored gains of Ts = {settings.Ts:g} s: in the end "
        f"{last}",
        x_label="time, s",
        y_label="d ln P11 / d ln parameter",
        lines=tuple(Line(names[key], at, values) for key, values in found.items()),
    )


def _both(channel: Channel, settings: Settings, designed: Gains) -> Chart:
    span = 2 * settings.seconds
    at = times(span, settings.Ts)
    kalman = np.asarray(kalman_history(channel, settings.Ts, span).P)[:, 0, 0]
    loop = loop_history(channel, designed, settings.Ts, span)
    lines = [
        Line("conventional loop", at[1:], loop[1:]),
        Line(f"Kalman scheme, Ts = {settings.Ts:g} s", at[1:], kalman[1:]),
        Line("q_a / t", at[1:], channel.q_a / at[1:]),
        Line("bound", at[[1, -1]], np.full(2, channel.bound), drawn="limit"),
    ]
    when = f"the loop {_within(lines[0], channel.bound)}, the Kalman scheme "
    title = f"At most {100 * NEAR:g} % above the bound: {when}{_within(lines[1], channel.bound)}"
    return replace(_over_time(channel, "both_schemes", title, lines), log="xy")


def _replayed(channel: Channel, settings: Settings) -> Chart:
    at = times(settings.seconds, scheme.REPLAY)
    lines = [
        Line(f"{by} by {by}", at, scheme.replay(channel, settings.Ts, settings.seconds, by=by))
        for by in ("sample", "time")
    ]
    factors = " and ".join(f"{line.y[-1]:.3g} ({line.label})" for line in lines)
    return Chart(
        name="replay",
        title=f"Gains of Ts = {settings.Ts:g} s replayed every {scheme.REPLAY:g} s: in the end, "
        f"P11 is too large by the factor {factors}",
        x_label="time, s",
        y_label="P11 over that of gains made for it",
        lines=tuple(lines),
        log="y",
    )


def _stored(channel: Channel, settings: Settings, solutions: Solutions) -> Chart:
    storage = scheme.Storage.of(channel, settings.Ts, settings.segments)
    at = np.arange(len(storage.which)) * settings.Ts
    tuned = tuned_values(best("kalman_stored", solutions))
    tables = {
        "tuned gains": np.asarray(storage.table(tuned)),
        "mean gains": storage.means[:, :, None],
    }
    model = channel.model(settings.Ts)
    optimal = np.asarray(storage.optimal.P)[:, 0, 0]
    lines = [
        Line(name, at[1:], (replayed(model, K[storage.which]) / optimal)[1:])
        for name, K in tables.items()
    ]
    count = len(storage.edges) - 2
    return Chart(
        name="stored_gains",
        title=f"{count} stored gains besides the first, Ts = {settings.Ts:g} s: P11 is larger by "
        + " and ".join(f"{100 * (line.y[-1] - 1):.2g} % ({line.label})" for line in lines)
        + " in the end",
        x_label="time, s",
        y_label="P11 over the Kalman filter's",
        lines=tuple(lines),
    )


def _ise_limit() -> Chart:
    largest = np.geomspace(8, 1e6, 100)
    return Chart(
        name="ise_limit",
        title="Least ISE within the bound: 1/4 + sqrt(2/G) with gains up to G, never 1/4",
        x_label="largest gain G, in powers of eta",
        y_label="ISE times eta",
        lines=(
            Line("least ISE", largest, 0.25 + np.sqrt(2 / largest)),
            Line("infimum", largest[[0, -1]], np.full(2, 0.25), drawn="limit"),
        ),
        log="x",
    )


def _over_time(channel: Channel, name: str, title: str, lines: list[Line]) -> Chart:
    return Chart(
        name=name,
        title=title,
        x_label="time, s",
        y_label=f"variance of the bias's error, {channel.squared}",
        lines=tuple(lines),
        log="y",
    )
