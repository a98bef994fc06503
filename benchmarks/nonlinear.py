"""Extended, iterated or unscented: one vessel, three sensors. ``python -m benchmarks.nonlinear``.

A vessel of constant velocity is sighted from a mast once a second, by range and bearing. The
results of the three filters, all with the same model, depend on the sensor and on the knowledge at
the start: on the prediction's error compared with the range in which h is straight.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array
from rich.console import Console
from rich.table import Table

from filters import (
    AnyFilter,
    ExtendedKalman,
    ExtendedModel,
    ExtendedSample,
    Lanes,
    UnscentedKalman,
    run,
)

F = np.eye(4) + np.eye(4, k=2)
Q = 0.01 * np.kron([[1 / 3, 1 / 2], [1 / 2, 1]], np.eye(2))
"""A step of one second: east and north, m, and their rates; the velocity wanders by 0.1 m/s."""


class Case(NamedTuple):
    """A sensor, and the knowledge at the start.

    Attributes:
        name: in words.
        at: assumed position of the vessel, m.
        known: deviation of each coordinate, m.
        range: deviation of a measured range, m.
        bearing: deviation of a measured bearing, rad.
    """

    name: str
    at: tuple[float, float]
    known: float
    range: float
    bearing: float


CASES = (
    Case("far off, all measured well", (200.0, 100.0), 5.0, 1.0, 0.01),
    Case("near, a precise fix on a vague start", (20.0, 10.0), 8.0, 0.05, 0.01),
    Case("near, bearings are poor", (20.0, 10.0), 5.0, 0.05, 0.5),
)


class Found(NamedTuple):
    """The errors of a filter over runs.

    Attributes:
        first: median error of the position at the first measurement, m.
        rms: error of the position over all, m.
        nees: median of the states' squared errors over their covariance, per state: 0.84 for a
            consistent filter.
    """

    first: float
    rms: float
    nees: float


def filters() -> dict[str, AnyFilter]:
    """The three, of one model; the bearing is an angle."""
    model, angles = (moved, pushed, sighted), (False, True)
    return {
        "extended": ExtendedKalman(*model, angles=angles),
        "iterated": ExtendedKalman(*model, iterations=5, angles=angles),
        "unscented": UnscentedKalman(*model, angles=angles),
    }


def moved(p: Any, x: Array, u: Any) -> Array:
    """Constant velocity."""
    return jnp.asarray(F) @ x


def pushed(p: Any, x: Array, u: Any) -> Array:
    """Its noise."""
    return jnp.asarray(Q)


def sighted(p: Any, x: Array, u: Any) -> Array:
    """Range and bearing from the mast."""
    return jnp.stack([jnp.hypot(x[0], x[1]), jnp.arctan2(x[1], x[0])])


def simulated(case: Case, runs: int, steps: int) -> tuple[np.ndarray, np.ndarray]:
    """True states of the vessels, ``(N, runs, 4)``, and measurements, ``(N, runs, 2)``."""
    rng, root = np.random.default_rng(1), np.linalg.cholesky(Q)
    x = np.array([*case.at, -0.3, -0.2]) + rng.standard_normal((runs, 4)) * _start(case)
    truth, z = np.empty((steps, runs, 4)), np.empty((steps, runs, 2))
    for k in range(steps):
        x = x @ F.T + rng.standard_normal((runs, 4)) @ root.T
        seen = np.stack([np.hypot(x[:, 0], x[:, 1]), np.arctan2(x[:, 1], x[:, 0])], axis=1)
        truth[k], z[k] = x, seen + rng.standard_normal((runs, 2)) * [case.range, case.bearing]
    return truth, z


def measured(filter: AnyFilter, case: Case, runs: int = 100, steps: int = 60) -> Found:
    """A filter on a case."""
    truth, z = simulated(case, runs, steps)
    R = jnp.array([case.range, case.bearing]) ** 2
    x0, P0 = jnp.array([*case.at, -0.3, -0.2]), jnp.diag(jnp.asarray(_start(case)) ** 2)
    passed = jax.jit(run, static_argnums=0)
    out = passed(Lanes(filter, runs), ExtendedModel(None, R, x0, P0), ExtendedSample(z))[1]
    off = np.asarray(out.x) - truth
    apart = np.hypot(off[..., 0], off[..., 1])
    nees = np.einsum("kri,krij,krj->kr", off, np.linalg.inv(out.P), off) / 4
    return Found(*map(float, (np.median(apart[0]), np.sqrt(np.mean(apart**2)), np.median(nees))))


def _start(case: Case) -> np.ndarray:
    return np.array([case.known, case.known, 0.3, 0.3])


def main() -> None:
    """Print the table."""
    table = Table("case", "filter", "first fix, m", "rms, m", "NEES")
    for case in CASES:
        for name, filter in filters().items():
            found = measured(filter, case)
            table.add_row(case.name, name, *(f"{number:.3g}" for number in found))
    Console(width=100).print(table)


if __name__ == "__main__":
    main()
