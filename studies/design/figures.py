"""Pictures of a design: how an error is forgotten, and the poles."""

from collections.abc import Iterator

import jax.numpy as jnp
import numpy as np
from jax.scipy.linalg import expm

from studies.design.designed import Designed
from studies.design.problems import Posed
from tuner.run.figure import Chart, Figure, Line
from tuner.run.study import Solutions, best

CURVE = 400


def figures(posed: Posed, solutions: Solutions) -> Iterator[Figure]:
    """The response, and the poles."""
    designed, full = posed.designed, posed.designed.full
    L = designed.gain(posed.problem.params(best(posed.problem.name, solutions)))
    yield _response(designed, L)
    poles = full.poles(L)
    per = "" if full.discrete else ", 1/s"
    yield Chart(
        name="poles",
        title="Poles of the observer's error",
        x_label=f"real part{per}",
        y_label=f"imaginary part{per}",
        lines=tuple(
            Line(f"{pole:.4g}", np.array([pole.real]), np.array([pole.imag])) for pole in poles
        ),
    )


def _response(designed: Designed, L: np.ndarray) -> Chart:
    """What an error in each state does to the error that counts."""
    full = designed.full
    closed = full.A - L @ full.C
    decay = full.decay(L)
    span = 8 / decay if decay > 0 else 100 * (full.dt or 1.0)
    step = full.dt or span / CURVE
    F = closed if full.discrete else np.asarray(expm(jnp.asarray(closed * step)))
    count = min(int(np.ceil(span / step)), 20 * CURVE) + 1
    rows = [designed.error]
    for _ in range(count - 1):
        rows.append(rows[-1] @ F)
    found, at = np.array(rows), np.arange(count) * step
    size = np.abs(found).max(axis=0)
    return Chart(
        name="response",
        title="The error that counts after an error in one state, each over its largest",
        x_label="t, s",
        y_label="share of its largest",
        lines=tuple(
            Line(f"{name} (x {size[i]:.3g})", at, found[:, i] / size[i])
            for i, name in enumerate(full.states)
            if size[i] > 0
        ),
    )
