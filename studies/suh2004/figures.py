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
        lines = tuple(
            Line(LABELS[each], t, np.degrees(np.asarray(o.angles)[:, at]))
            for each, o in found.items()
        )
        title = f"Fig. 5: {name} estimated on the cart; the truth is 0"
        yield Chart(f"fig5_{name}", title, "t, s", f"{name}, deg", lines)
    for each in ("simple", "two_step"):
        r = np.asarray(found[each].r)
        yield Chart(
            name=f"fig6_{each}",
            title=f"Fig. 6: variances that the {LABELS[each]} filter takes",
            x_label="t, s",
            y_label="r, g^2",
            lines=merged(
                [
                    Line(label, t, r[:, k], drawn="points")
                    for k, label in enumerate(("r1 (ax)", "r2 (ay)"))
                ]
            ),
            log="y",
        )
    yield _held_out(bench, solutions)


def _held_out(bench: Bench, solutions: Solutions) -> Chart:
    """The roll error on the first held-out record."""
    inputs = jax.tree.map(lambda leaf: np.asarray(leaf)[:, 0], bench.judged_on.inputs)
    truth = np.asarray(bench.judged_on.truth)[:, 0, 1]
    t = DT * np.arange(len(truth))
    heuristic = outputs(TWO_STEP, inputs, noise({}), bench.tuned_on)
    lines = [Line("two-step, by hand", t, np.degrees(np.asarray(heuristic.angles)[:, 1] - truth))]
    for name, filter in FILTERS.items():
        values = noise(tuned_values(best(name, solutions)))
        tuned = outputs(filter, inputs, values, bench.tuned_on)
        error = np.degrees(np.asarray(tuned.angles)[:, 1] - truth)
        lines.append(Line(f"{LABELS[name]}, tuned", t, error))
    title = "Roll error on a held-out record with motion, accelerations and bias"
    return Chart("held_out_roll", title, "t, s", "error, deg", tuple(lines))
