"""Figures 3 to 5 with bands over runs, the three flights, and sweeps."""

from collections.abc import Iterator

import numpy as np

from studies.you_lee import problems
from studies.you_lee.cases import CHUNK, Bench, Case, Spread
from studies.you_lee.flight import TRAJECTORIES
from studies.you_lee.paper import PUBLISHED
from studies.you_lee.problems import tuned_case
from tuner.problem.surface import grid
from tuner.run.figure import Chart, Figure, Line, Map
from tuner.run.study import Solutions, best

ANGLES = ("roll", "pitch")
BANDS = (5, 50, 95)
"""Shares of the runs below a curve, %."""


def figures(bench: Bench, solutions: Solutions) -> Iterator[Figure]:
    """All figures."""
    name = bench.settings.trajectory
    gyro, plain = Case(name, "none"), Case(name, "airspeed")
    zero, true = Case(name, "velocity"), Case(name, "velocity", "true")
    bench.spreads([gyro, plain, zero, true])
    yield from _bands(bench, "fig3", "Fig. 3: gyroscopes alone", {"": gyro})
    yield from _bands(bench, "fig4", "Fig. 4: aided by (10)", {"": plain})
    starts = {", v = w = 0": zero, ", true v, w": true}
    yield from _bands(bench, "fig5", "Fig. 5: with the velocity filter", starts)
    yield from _flights(bench)
    yield _by_tau(bench, solutions)
    yield _by_process_noise(bench)
    yield _by_threshold(bench)
    yield _surface(bench, solutions)


def _bands(bench: Bench, name: str, title: str, cases: dict[str, Case]) -> Iterator[Chart]:
    for at, angle in enumerate(ANGLES):
        lines, largest = [], []
        for label, case in cases.items():
            found = bench.spread(case)
            low, median, high = np.percentile(found.errors[..., at], BANDS, axis=1)
            start = f" ({label.removeprefix(', ')})" if label else ""
            largest.append(f"{np.abs([low, high]).max():.2g} deg{start}")
            lines += [
                Line(f"5 to 95 % of runs{label}", found.t, low, drawn="band", upper=high),
                Line(f"median{label}", found.t, median),
            ]
        words = f"{title}: at any time 90 % of {bench.settings.runs} runs have a {angle} error "
        words += f"below {' or '.join(largest)}"
        yield Chart(f"{name}_{angle}", words, "time, s", f"{angle} error, deg", tuple(lines))


def _flights(bench: Bench) -> Iterator[Chart]:
    """Root mean square over runs of the roll error, in and before the turn."""
    runs, level = bench.settings.runs, bench.settings.level
    for name in TRAJECTORIES:
        cases = {"with (10)": Case(name, "airspeed"), "velocity filter": Case(name, "velocity")}
        if name == "T1":  # v and w begin at 0 on the others
            cases["velocity filter, true v, w"] = Case(name, "velocity", "true")
        lines = tuple(_rms(bench.spread(case), label, level) for label, case in cases.items())
        plain, filtered = (float(line.y.max()) for line in lines[:2])
        title = f"{name}: a roll error of at most {filtered:.2g} deg with the velocity filter, "
        title += f"{plain:.2g} deg without"
        label = f"root mean square roll error of {runs} runs, deg"
        yield Chart(f"flight_{name}", title, "time, s", label, lines)


def _rms(found: Spread, label: str, level: float) -> Line:
    seen = found.t > 0.9 * level
    return Line(label, found.t[seen], np.sqrt((found.errors[seen, :, 0] ** 2).mean(axis=1)))


def _by_tau(bench: Bench, solutions: Solutions) -> Chart:
    """The error by phases over tau of (15)."""
    settings, found = bench.settings, best("damped", solutions)
    tau = np.geomspace(2.0, 300.0, 2 * settings.grid - 1)
    cases = [_damped(bench, value) for value in tau]
    spreads = bench.spreads(cases, CHUNK)
    level = [float(np.hypot(*each.level_rms)) for each in spreads]
    turn, whole = ([getattr(each, key) for each in spreads] for key in ("turn_rms", "whole_rms"))
    value = float(found.parameters["tau"].value)
    there = bench.spread(_damped(bench, value), CHUNK).whole_rms
    alone = [tau[np.argmin(each)] for each in (level, turn)]
    title = f"{settings.trajectory}: level flight alone is best with tau = {alone[0]:.2g} s, "
    title += f"the turn with {alone[1]:.2g} s"
    return Chart(
        name="sweep_tau",
        title=title,
        x_label="tau of (15), s",
        y_label=f"root mean square error of {_runs(bench)} runs, deg",
        lines=(
            Line("whole flight", tau, np.array(whole)),
            Line("level flight", tau, np.array(level)),
            Line("turn", tau, np.array(turn)),
            Line(f"tuned on other runs, tau = {value:.3g} s", np.array([value]), np.array([there])),
        ),
        log="xy",
    )


def _damped(bench: Bench, tau: float) -> Case:
    values = (("K1", 2 / tau), ("K2", 1 / (2 * tau)))
    return Case(bench.settings.trajectory, "airspeed", values=values)


def _by_process_noise(bench: Bench) -> Chart:
    Q_k = np.geomspace(1e-11, 1e3, bench.settings.grid)
    return _sweep(bench, "Q_k", Q_k, "(ft/s)^2")


def _by_threshold(bench: Bench) -> Chart:
    """The error over the threshold, from biases in level flight to most of the largest rate."""
    peak = float(np.linalg.norm(np.asarray(bench.flights["T1"].sensed.rate), axis=1).max())
    low = min(2e-4, bench.settings.threshold)
    thresholds = np.geomspace(low, 0.95 * peak, bench.settings.grid)
    return _sweep(bench, "threshold", thresholds, "rad/s")


def _runs(bench: Bench) -> int:
    """Number of runs in sweeps: few are enough to compare."""
    return min(CHUNK, bench.settings.runs)


def _sweep(bench: Bench, name: str, x: np.ndarray, unit: str) -> Chart:
    """The velocity filter's errors from v = w = 0 on T1 over one of its constants."""
    published = PUBLISHED[name]
    cases = [Case("T1", "velocity", values=((name, float(value)),)) for value in x]
    there = Case("T1", "velocity", values=((name, published),))
    spreads = bench.spreads([*cases, there], CHUNK)
    peaks = np.array([each.turn_maximum for each in spreads])
    lines = [Line(f"largest {a} error in the turn", x, peaks[:-1, i]) for i, a in enumerate(ANGLES)]
    whole = np.array([each.whole_rms for each in spreads])
    lines.append(Line("root mean square of both, whole flight", x, whole[:-1]))
    lines.append(Line(f"published {name}", np.array([published]), peaks[-1:, 0]))
    best = float(peaks[:-1, 0].min())
    title = f"T1: {name} = {published:g} has a largest roll error of {peaks[-1, 0]:.3g} deg, "
    title += f"the best of all {best:.3g}"
    label = f"error, mean over {_runs(bench)} runs, deg"
    return Chart(f"sweep_{name}", title, f"{name}, {unit}", label, tuple(lines), log="x")


def _surface(bench: Bench, solutions: Solutions) -> Map:
    """The score over both gains, on the runs that are tuned on."""
    settings, problem = bench.settings, problems.posed(bench)["free"]
    K1 = np.geomspace(5e-3, 0.2, settings.grid)
    K2 = np.geomspace(2e-3, 0.2, settings.grid)
    z = grid(problem, {"K1": K1, "K2": K2})
    case = dict(tuned_case(settings, best("free", solutions)).values)
    damped = K1 / 4
    inside = (damped >= K2[0]) & (damped <= K2[-1])
    return Map(
        name="surface_gains",
        title=f"{settings.trajectory}: tuned K2 = {case['K2'] / case['K1']:.2g} K1, (15) has K1/4",
        x_label="K1, 1/s",
        y_label="K2, 1/s",
        z_label="root mean square error, deg",
        x=K1,
        y=K2,
        z=z,
        marks=(
            Line("(15): K2 = K1/4", K1[inside], damped[inside]),
            Line("published", np.array([PUBLISHED["K1"]]), np.array([PUBLISHED["K2"]])),
            Line("tuned", np.array([case["K1"]]), np.array([case["K2"]])),
        ),
        log="xyz",
    )
