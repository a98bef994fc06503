"""Figures 5 and 6, and a held-out record."""

from collections.abc import Iterator

import jax
import numpy as np

from studies.suh2004.bench import Bench
from studies.suh2004.data import experiment_2
from studies.suh2004.paper import DT, FILTERS, TWO_STEP
from studies.suh2004.problems import noise, outputs
from tuner.run.figure import Chart, Figure, Line, merged
from tuner.run.study import Solutions, best, tuned_values

LABELS = {"standard": "standard", "simple": "simple adaptive", "two_step": "two-step"}


def figures(bench: Bench, solutions: Solutions) -> Iterator[Figure]:
    """All figures."""
    inputs = experiment_2(bench.settings.gyro_unit)
    t = DT * np.arange(1, len(inputs.gyr) + 1)
    by_hand, beside = noise({}), bench.tuned_on
    found = {name: outputs(one, inputs, by_hand, beside) for name, one in FILTERS.items()}
    for at, name in ((1, "roll"), (0, "pitch")):
        angles = {each: np.degrees(np.asarray(o.angles)[:, at]) for each, o in found.items()}
        largest = {LABELS[each]: float(np.abs(angle).max()) for each, angle in angles.items()}
        yield Chart(
            name=f"fig5_{name}",
            title=f"Fig. 5: the true {name} is 0; the largest errors are {_degrees(largest)}",
            x_label="time, s",
            y_label=f"{name}, deg",
            lines=tuple(Line(LABELS[each], t, angle) for each, angle in angles.items()),
        )
    for each in ("simple", "two_step"):
        r = np.asarray(found[each].r)
        names = ("r1 (ax)", "r2 (ay)")
        axes = [Line(label, t, r[:, k], drawn="points") for k, label in enumerate(names)]
        yield Chart(
            name=f"fig6_{each}",
            title=f"Fig. 6: the {LABELS[each]} filter takes {_variances(r, names)}",
            x_label="time, s",
            y_label="variance r of the accelerometer, g^2",
            lines=merged(axes),
            log="y",
        )
    yield _held_out(bench, solutions)


def _variances(r: np.ndarray, names: tuple[str, ...]) -> str:
    """The range of each variance; two values that all share as such."""
    found = np.unique(r.round(9))
    if len(found) == 2 and np.array_equal(r[:, 0], r[:, 1]):
        high = 100 * float(np.mean(r[:, 0] > found.mean()))
        return f"{found[0]:.2g} or {found[1]:.2g} g^2 on both axes, {high:.0f} % the latter"
    low, high_ones = r.min(axis=0), r.max(axis=0)
    each = zip(names, low, high_ones, strict=True)
    return " and ".join(f"{name} from {a:.2g} to {b:.2g} g^2" for name, a, b in each)


def _degrees(values: dict[str, float]) -> str:
    return ", ".join(f"{value:.2g} deg ({name})" for name, value in values.items())


def _held_out(bench: Bench, solutions: Solutions) -> Chart:
    """The roll error on the first held-out record."""
    inputs = jax.tree.map(lambda leaf: np.asarray(leaf)[:, 0], bench.judged_on.inputs)
    truth = np.asarray(bench.judged_on.truth)[:, 0, 1]
    t = DT * np.arange(len(truth))
    heuristic = outputs(TWO_STEP, inputs, noise({}), bench.tuned_on)
    found = {"two-step, by hand": heuristic}
    for name, filter in FILTERS.items():
        values = noise(tuned_values(best(name, solutions)))
        found[f"{LABELS[name]}, tuned"] = outputs(filter, inputs, values, bench.tuned_on)
    errors = {name: np.degrees(np.asarray(one.angles)[:, 1] - truth) for name, one in found.items()}
    rms = {name: float(np.sqrt(np.mean(error**2))) for name, error in errors.items()}
    return Chart(
        name="held_out_roll",
        title=f"Roll error on a held-out record, rms: {_degrees(rms)}",
        x_label="time, s",
        y_label="roll error, deg",
        lines=tuple(Line(name, t, error) for name, error in errors.items()),
    )
