"""Figures of a design: the response to an error, and the poles."""

from collections.abc import Iterator

import jax.numpy as jnp
import numpy as np

from filters.exponential import expm
from studies.design.designed import Designed
from studies.design.problems import Posed
from tuner.run.figure import Chart, Figure, Line
from tuner.run.study import Solutions, best

CURVE = 400
SMALL = 0.02
"""An error that is this share of its largest has decayed."""


def figures(posed: Posed, solutions: Solutions) -> Iterator[Figure]:
    """The response, and the poles."""
    designed, full = posed.designed, posed.designed.full
    L = designed.gain(posed.problem.params(best(posed.problem.name, solutions)))
    yield _response(designed, L)
    yield _poles(np.asarray(full.poles(L)), discrete=bool(full.discrete))


def _poles(poles: np.ndarray, *, discrete: bool) -> Chart:
    """The poles, with the stability limit: the unit circle, or the imaginary axis."""
    angle = np.linspace(0, 2 * np.pi, CURVE)
    reach = max(1.2 * float(np.abs(poles).max()), 1e-9)
    edge = (
        Line("unit circle", np.cos(angle), np.sin(angle), drawn="limit")
        if discrete
        else Line("imaginary axis", np.zeros(2), np.array([-reach, reach]), drawn="limit")
    )
    inside = bool(np.all(np.abs(poles) < 1) if discrete else np.all(poles.real < 0))
    slowest = poles[np.argmax(np.abs(poles) if discrete else poles.real)]
    value = f"{slowest.real:.3g}"
    if slowest.imag:
        value += f" ± {abs(slowest.imag):.3g}j"
    per = "" if discrete else ", 1/s"
    return Chart(
        name="poles",
        title=f"Poles of the observer's error: {'stable' if inside else 'unstable'}, the slowest "
        f"at {value}{per.removeprefix(',')}",
        x_label=f"real part{per}",
        y_label=f"imaginary part{per}",
        lines=(edge, Line("poles", poles.real, poles.imag, drawn="points")),
        equal=True,
    )


def _response(designed: Designed, L: np.ndarray) -> Chart:
    """Response of the error that counts to an initial error in each state."""
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
    large = at[(np.abs(found) > SMALL * size).any(axis=1)]
    return Chart(
        name="response",
        title="After an initial error in any one state, the error that counts is within "
        f"{100 * SMALL:g} % of its largest from {large[-1]:.3g} s on",
        x_label="time, s",
        y_label="error that counts, over its largest",
        lines=tuple(
            Line(f"{name} (x {size[i]:.3g})", at, found[:, i] / size[i])
            for i, name in enumerate(full.states)
            if size[i] > 0
        ),
    )
